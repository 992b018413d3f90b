//! Whether a plan's first and last waypoint are at its declared start and goal.

use std::collections::BTreeMap;

use glam::DVec2;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_distance, wrap_angle, yaw_of};
use surefoot_shared_types::message::Waypoint;
use surefoot_shared_types::plan_format::blocks::{EndBlock, PoseBlock};
use surefoot_shared_types::robot::model::RobotModel;

use crate::base::comparison::{is_at_most, largest};
use crate::kinematics::forward::{Configuration, Posture};

/// The yaw tolerance of a root region that names a yaw but no tolerance, rad.
const YAW_TOLERANCE: f64 = 0.2;

/// Distance of a plan's first or last waypoint from its start or goal.
#[derive(Debug, Clone, PartialEq)]
pub struct EndpointReport {
    /// The largest error, m or rad, combined as the plan format defines.
    pub error: f64,
    /// The largest one allowed.
    pub limit: f64,
    /// The violation, if any, in one line.
    pub violation: Option<String>,
}

impl EndpointReport {
    fn new(error: f64, limit: f64, what: &str) -> Self {
        let violation =
            (!is_at_most(error, limit)).then(|| format!("{what} by {error:.6}, limit {limit}"));
        Self { error, limit, violation }
    }

    /// The same, with the violation of another comparison where it has none.
    fn and(self, other: Self) -> Self {
        Self { violation: self.violation.or(other.violation), ..self }
    }
}

/// Compares a waypoint with a declared start or goal. `joint_order[j]` is the index of the robot's
/// joint `j` in the plan's own `q`. With `turn_max` (rad) soles may be turned by as much, and their
/// tolerance is that of their place alone.
pub fn check_endpoint(
    model: &RobotModel,
    endpoint: &EndBlock,
    waypoint: &Waypoint,
    joint_order: &[usize],
    turn_max: Option<f64>,
) -> EndpointReport {
    let configuration = Configuration::of_waypoint(waypoint, model.joints.len());
    match endpoint {
        EndBlock::Config { root_xyz, root_quat_xyzw, q, tol } => {
            let root = PoseBlock { xyz: *root_xyz, quat_xyzw: *root_quat_xyzw }.pose();
            let off = |(joint, &place): (usize, &usize)| {
                q.get(place).map_or(f64::INFINITY, |want| (configuration.q[joint] - want).abs())
            };
            let joints = joint_order.iter().enumerate().map(off);
            let error = largest(joints.chain(pose_errors(&configuration.world_from_root, &root)));
            EndpointReport::new(error, *tol, "the configuration is off")
        }
        EndBlock::RootRegion { xy, radius, z_range, yaw, yaw_tol } => {
            let root = &configuration.world_from_root;
            let place = check_place(root, (*xy, *radius), *z_range);
            let turn = yaw.map_or(0.0, |yaw| wrap_angle(yaw_of(root.rotation) - yaw).abs());
            let turn_max = yaw_tol.unwrap_or(YAW_TOLERANCE);
            place.and(EndpointReport::new(turn, turn_max, "the root's heading is off"))
        }
        EndBlock::Feet { soles, tol } => {
            check_soles(model, &Posture::new(model, &configuration), (soles, *tol), turn_max)
        }
    }
}

/// Distance (m) and turn (rad) between two poses.
fn pose_errors(actual: &Pose, target: &Pose) -> [f64; 2] {
    [
        actual.translation.distance(target.translation),
        rotation_distance(actual.rotation, target.rotation),
    ]
}

/// Compares the root's position with a declared circle and range of heights, m.
fn check_place(
    root: &Pose,
    (middle, radius): ([f64; 2], f64),
    heights: Option<[f64; 2]>,
) -> EndpointReport {
    let [x, y, z] = root.translation.to_array();
    let distance = DVec2::new(x, y).distance(middle.into());
    let report = EndpointReport::new(distance, radius, "the root is off the region's middle");
    let heights = heights.filter(|[low, high]| !(*low..=*high).contains(&z));
    let violation =
        heights.map(|[low, high]| format!("the root is at z {z:.4}, not {low} to {high}"));
    EndpointReport { violation: report.violation.or(violation), ..report }
}

/// Compares the soles with declared poses. With `turn_max` (rad) they may be turned by as much.
fn check_soles(
    model: &RobotModel,
    posture: &Posture,
    (soles, tol): (&BTreeMap<String, PoseBlock>, f64),
    turn_max: Option<f64>,
) -> EndpointReport {
    let off = |(name, block): (&String, &PoseBlock)| {
        let limb = model.feet.iter().position(|foot| foot.name == *name);
        let actual = limb.map(|limb| posture.world_from_sole(model, limb));
        actual.map_or([f64::INFINITY; 2], |actual| pose_errors(&actual, &block.pose()))
    };
    let off: Vec<[f64; 2]> = soles.iter().map(off).collect();
    let [distance, turn] = [0, 1].map(|part| largest(off.iter().map(|off| off[part])));
    let Some(turn_max) = turn_max else {
        let error = largest([distance, 0.5 * turn]);
        return EndpointReport::new(error, tol, "a sole is off its pose");
    };
    let report = EndpointReport::new(distance, tol, "a sole is off its place");
    let turned = EndpointReport::new(turn, turn_max, "a sole is turned from its pose");
    report.and(turned)
}
