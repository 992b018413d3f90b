//! Projection of a configuration onto two soles [Berenson 2009].
//!
//! Each step moves the root, the trunk and both legs together. It is the least-norm step that moves
//! both soles to their poses and the centre of mass into its region, within the joint limits.
//!
//! Inverse kinematics of one leg after the other needs a root pose at which both have a solution.
//! With narrow joint limits such poses are rare, and samples of the root pose miss them.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_from_scaled_axis, scaled_axis_from_rotation};
use surefoot_shared_types::robot::model::JointKind;

use crate::geometry::convex_region::ConvexRegion;
use crate::kinematics::least_norm::{Unknown, least_norm};
use crate::kinematics::leg_joint::LEG_JOINTS_MAX;
use crate::robot::configuration::Configuration;
use crate::robot::free_joints::TRUNK_JOINTS_MAX;
use crate::robot::gravity_torques::com_shift;
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::Mechanism;
use crate::robot::tuning::{
    PROJECTION_COM_DEPTHS, PROJECTION_ERROR_NEAR, PROJECTION_PROGRESS_RATIO_MAX,
    PROJECTION_ROTATION_WEIGHT, PROJECTION_STALLS_MAX, PROJECTION_STEP_ERROR_MAX,
    PROJECTION_STEPS_MAX, ROOT_SHIFT_RATIO,
};

/// Rows of the error: the twist of each sole (linear before angular), then the centre of mass in x
/// and y.
const ROWS: usize = 14;
/// First row of the centre of mass.
const COM: usize = 12;
/// Unknowns of a step: translation and rotation of the root, the trunk joints, and the joints of
/// both legs.
const UNKNOWNS: usize = 6 + TRUNK_JOINTS_MAX + 2 * LEG_JOINTS_MAX;

/// The constraints that a projection satisfies.
#[derive(Debug, Clone, Copy)]
pub struct ProjectionTarget<'a> {
    /// Poses of the soles, by limb.
    pub world_from_soles: &'a [Pose; 2],
    /// Region of the centre of mass.
    pub region: &'a ConvexRegion,
    /// Margin of the centre of mass inside the region, m.
    pub com_margin: f64,
}

/// Projects `start` onto the target; `None` if the steps do not converge. `kinematic_state` is
/// overwritten with the state of the last step.
pub fn project(
    robot: &Mechanism,
    target: &ProjectionTarget<'_>,
    start: &Configuration,
    kinematic_state: &mut KinematicState,
) -> Option<Configuration> {
    let mut configuration = *start;
    let (mut last, mut stalls) = (f64::INFINITY, 0);
    for _ in 0..PROJECTION_STEPS_MAX {
        kinematic_state.update(robot, &configuration);
        let reached = [0, 1].map(|limb| {
            configuration.world_from_root * robot.legs[limb].root_from_sole(&configuration.q)
        });
        let mut error = error(target, &reached, kinematic_state);
        let size = error.iter().fold(0.0_f64, |size, row| size.max(row.abs()));
        if size < PROJECTION_ERROR_NEAR {
            let is_placed = robot.place_soles_near(&mut configuration, target.world_from_soles);
            kinematic_state.update(robot, &configuration);
            return is_placed.then_some(configuration);
        }
        stalls = if size > PROJECTION_PROGRESS_RATIO_MAX * last { stalls + 1 } else { 0 };
        if stalls == PROJECTION_STALLS_MAX {
            return None;
        }
        last = size;
        error.iter_mut().for_each(|row| *row *= (PROJECTION_STEP_ERROR_MAX / size).min(1.0));
        let step = least_norm(&unknowns(robot, &configuration, &reached, kinematic_state), &error)?;
        take_step(robot, &mut configuration, &step);
    }
    None
}

/// The error of the reached sole poses and centre of mass, m and rad.
fn error(
    target: &ProjectionTarget<'_>,
    reached: &[Pose; 2],
    kinematic_state: &KinematicState,
) -> [f64; ROWS] {
    let mut error = [0.0; ROWS];
    for (limb, (from, to)) in reached.iter().zip(target.world_from_soles).enumerate() {
        let rotation = scaled_axis_from_rotation(to.rotation * from.rotation.conjugate());
        write_twist(&mut error, limb, to.translation - from.translation, rotation);
    }
    let com = kinematic_state.com.truncate();
    let [least, desired] = PROJECTION_COM_DEPTHS.map(|depth| target.com_margin + depth);
    if !target.region.contains(com, least) {
        let shift = target.region.nearest_inside(com, desired) - com;
        [error[COM], error[COM + 1]] = shift.to_array();
    }
    error
}

fn write_twist(rows: &mut [f64; ROWS], limb: usize, linear: DVec3, angular: DVec3) {
    rows[6 * limb..6 * limb + 3].copy_from_slice(&linear.to_array());
    rows[6 * limb + 3..6 * limb + 6].copy_from_slice(&angular.to_array());
}

/// The unknowns of a step with their effects on the rows of the error.
fn unknowns(
    robot: &Mechanism,
    configuration: &Configuration,
    reached: &[Pose; 2],
    kinematic_state: &KinematicState,
) -> heapless::Vec<Unknown<ROWS>, UNKNOWNS> {
    let mut unknowns = root_unknowns(&configuration.world_from_root, reached, kinematic_state.com);
    unknowns.extend(robot.trunk_joints.iter().map(|joint| {
        let mut effect = [0.0; ROWS];
        let shift = com_shift(&robot.mass_tree, kinematic_state, joint.index);
        [effect[COM], effect[COM + 1]] = shift.truncate().to_array();
        joint_unknown(effect, [joint.lower, joint.upper], configuration.q[joint.index])
    }));
    for (limb, leg) in robot.legs.iter().enumerate() {
        unknowns.extend(leg.axes(&configuration.q).map(|(joint, motion)| {
            let world_from_joint = configuration.world_from_root * motion;
            let axis = world_from_joint.rotation * joint.axis;
            let mut effect = [0.0; ROWS];
            match joint.kind {
                JointKind::Revolute => {
                    let linear =
                        axis.cross(reached[limb].translation - world_from_joint * joint.point);
                    write_twist(&mut effect, limb, linear, axis);
                }
                JointKind::Prismatic => write_twist(&mut effect, limb, axis, DVec3::ZERO),
            }
            joint_unknown(effect, [joint.lower, joint.upper], configuration.q[joint.index])
        }));
    }
    unknowns
}

/// Translations and rotations of the root along the world's axes.
fn root_unknowns(
    world_from_root: &Pose,
    reached: &[Pose; 2],
    com: DVec3,
) -> heapless::Vec<Unknown<ROWS>, UNKNOWNS> {
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let translation =
        |axis: DVec3| (root_effect(reached, |_| axis, DVec3::ZERO, axis / ROOT_SHIFT_RATIO), 1.0);
    let rotation = |axis: DVec3| {
        let moved = |point: DVec3| axis.cross(point - world_from_root.translation);
        (root_effect(reached, moved, axis, moved(com)), PROJECTION_ROTATION_WEIGHT)
    };
    let free =
        |(effect, weight)| Unknown { effect, weight, range: [f64::NEG_INFINITY, f64::INFINITY] };
    axes.map(translation).into_iter().chain(axes.map(rotation)).map(free).collect()
}

/// A joint, which stops at its limits.
fn joint_unknown(effect: [f64; ROWS], [lower, upper]: [f64; 2], position: f64) -> Unknown<ROWS> {
    Unknown {
        effect,
        weight: 1.0,
        range: [(lower - position).min(0.0), (upper - position).max(0.0)],
    }
}

/// The effect of a root motion on the rows of the error: the displacement of each sole, the
/// rotation, and the displacement of the centre of mass.
fn root_effect(
    reached: &[Pose; 2],
    displacement: impl Fn(DVec3) -> DVec3,
    angular: DVec3,
    com: DVec3,
) -> [f64; ROWS] {
    let mut effect = [0.0; ROWS];
    for (limb, sole) in reached.iter().enumerate() {
        write_twist(&mut effect, limb, displacement(sole.translation), angular);
    }
    [effect[COM], effect[COM + 1]] = com.truncate().to_array();
    effect
}

fn take_step(robot: &Mechanism, configuration: &mut Configuration, step: &[f64; UNKNOWNS]) {
    let root = configuration.world_from_root;
    let [translation, rotation] = [0, 3].map(|first| DVec3::from_slice(&step[first..]));
    let rotation = (rotation_from_scaled_axis(rotation) * root.rotation).normalize();
    configuration.world_from_root = Pose::from_parts(root.translation + translation, rotation);
    let trunk = robot.trunk_joints.iter().map(|joint| (joint.index, joint.lower, joint.upper));
    let legs = robot
        .legs
        .iter()
        .flat_map(|leg| leg.joints())
        .map(|joint| (joint.index, joint.lower, joint.upper));
    for ((index, lower, upper), change) in trunk.chain(legs).zip(&step[6..]) {
        let position = &mut configuration.q[index];
        *position = (*position + change).clamp(lower, upper);
    }
}
