//! Whether a plan's first and last waypoint are at its declared start and goal.

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
    let root = configuration.world_from_root;
    match endpoint {
        EndBlock::Config { root_xyz, root_quat_xyzw, q, tol } => {
            let target = pose(&PoseBlock { xyz: *root_xyz, quat_xyzw: *root_quat_xyzw });
            let off = |(joint, &place): (usize, &usize)| {
                q.get(place).map_or(f64::INFINITY, |want| (configuration.q[joint] - want).abs())
            };
            let joints = joint_order.iter().enumerate().map(off);
            let error = largest(joints.chain([
                root.translation.distance(target.translation),
                rotation_distance(root.rotation, target.rotation),
            ]));
            EndpointReport::new(error, *tol, "the configuration is off")
        }
        EndBlock::RootRegion { xy, radius, z_range, yaw, yaw_tol } => {
            let distance = root.translation.truncate().distance((*xy).into());
            let report =
                EndpointReport::new(distance, *radius, "the root is off the region's middle");
            let height_violation =
                z_range.filter(|[low, high]| !(*low..=*high).contains(&root.translation.z));
            let height_violation = height_violation.map(|[low, high]| {
                format!("the root is at z {:.4}, not {low} to {high}", root.translation.z)
            });
            let turn = yaw.map_or(0.0, |yaw| wrap_angle(yaw_of(root.rotation) - yaw).abs());
            let yaw_violation = EndpointReport::new(
                turn,
                yaw_tol.unwrap_or(YAW_TOLERANCE),
                "the root's heading is off",
            )
            .violation;
            EndpointReport {
                violation: report.violation.or(height_violation).or(yaw_violation),
                ..report
            }
        }
        EndBlock::Feet { soles, tol } => {
            let posture = Posture::new(model, &configuration);
            let off = |(name, block): (&String, &PoseBlock)| {
                let Some(limb) = model.feet.iter().position(|foot| foot.name == *name) else {
                    return [f64::INFINITY; 2];
                };
                let (actual, target) = (posture.world_from_sole(model, limb), pose(block));
                [
                    actual.translation.distance(target.translation),
                    rotation_distance(actual.rotation, target.rotation),
                ]
            };
            let off: Vec<[f64; 2]> = soles.iter().map(off).collect();
            let [distance, turn] = [0, 1].map(|part| largest(off.iter().map(|off| off[part])));
            let Some(turn_max) = turn_max else {
                let error = largest([distance, 0.5 * turn]);
                return EndpointReport::new(error, *tol, "a sole is off its pose");
            };
            let report = EndpointReport::new(distance, *tol, "a sole is off its place");
            let turned = EndpointReport::new(turn, turn_max, "a sole is turned from its pose");
            EndpointReport { violation: report.violation.or(turned.violation), ..report }
        }
    }
}

fn pose(block: &PoseBlock) -> Pose {
    Pose::from_parts(block.xyz.into(), glam::DQuat::from_array(block.quat_xyzw).normalize())
}
