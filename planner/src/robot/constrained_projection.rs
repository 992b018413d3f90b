//! A configuration that stands on two soles, from one that is near: steps of the root, the trunk
//! and both legs together, each the smallest that brings both soles to their places and the centre
//! of mass over what carries it, no joint beyond its limits.
//!
//! Inverse kinematics of one leg and then the other needs a pose of the root for which both have a
//! solution. Where joints have little room, such poses are few, and this finds what samples of the
//! root's pose all miss.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_from_scaled_axis, scaled_axis_from_rotation};
use surefoot_shared_types::robot::model::JointKind;

use crate::geometry::convex_region::ConvexRegion;
use crate::kinematics::least_norm::{Unknown, least_norm};
use crate::kinematics::leg::LEG_JOINTS_MAX;
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::{Configuration, Mechanism, TRUNK_JOINTS_MAX};
use crate::robot::posture_ik::LEGS_LAG;

/// Steps of one projection; from near the solution four to eight suffice.
const STEPS_MAX: usize = 12;
/// A step that leaves more than this share of the error makes no progress.
const STALL: f64 = 0.97;
/// So many such steps in a row end the projection.
const STALLS_MAX: usize = 4;
/// The largest error (m and rad) from which the legs' own inverse kinematics finish.
const NEAR: f64 = 1e-4;
/// The largest error (m and rad) that one step makes up for.
const ERROR_MAX: f64 = 0.5;
/// How readily the root turns, compared with a joint: where it was desired is left only where it
/// must be.
const ROOT_WEIGHT: f64 = 0.05;
/// How much deeper than its margin inside its region the centre of mass is desired, m: it is
/// moved where it is not as deep as the first, and then as deep as the second.
const DEEPER: [f64; 2] = [1e-3, 3e-3];

/// Rows of the error: the twist of each sole, linear before angular, and the centre of mass in x
/// and y.
const ROWS: usize = 14;
/// The row of the centre of mass.
const COM: usize = 12;
/// Unknowns of a step: the root's shift and turn, the joints that carry the trunk, and those of
/// both legs.
const UNKNOWNS: usize = 6 + TRUNK_JOINTS_MAX + 2 * LEG_JOINTS_MAX;

/// What a configuration shall stand on.
#[derive(Debug, Clone, Copy)]
pub struct ProjectionTarget<'a> {
    /// The soles by limb.
    pub world_from_soles: &'a [Pose; 2],
    /// Where the centre of mass may be.
    pub region: &'a ConvexRegion,
    /// How deep inside, m.
    pub com_margin: f64,
}

/// The configuration to which the steps from `start` lead, if they do; `kinematic state` is the one
/// of the last step.
pub fn project(
    robot: &Mechanism,
    target: &ProjectionTarget<'_>,
    start: &Configuration,
    kinematic_state: &mut KinematicState,
) -> Option<Configuration> {
    let mut configuration = *start;
    let (mut last, mut stalls) = (f64::INFINITY, 0);
    for _ in 0..STEPS_MAX {
        robot.update_kinematic_state(&configuration, kinematic_state);
        let reached = [0, 1].map(|limb| {
            configuration.world_from_root * robot.legs[limb].root_from_sole(&configuration.q)
        });
        let mut error = error(target, &reached, kinematic_state);
        let size = error.iter().fold(0.0_f64, |size, row| size.max(row.abs()));
        if size < NEAR {
            let is_placed = robot.place_soles_near(&mut configuration, target.world_from_soles);
            robot.update_kinematic_state(&configuration, kinematic_state);
            return is_placed.then_some(configuration);
        }
        stalls = if size > STALL * last { stalls + 1 } else { 0 };
        if stalls == STALLS_MAX {
            return None;
        }
        last = size;
        error.iter_mut().for_each(|row| *row *= (ERROR_MAX / size).min(1.0));
        let step = least_norm(&unknowns(robot, &configuration, &reached, kinematic_state), &error)?;
        take_step(robot, &mut configuration, &step);
    }
    None
}

fn error(
    target: &ProjectionTarget<'_>,
    reached: &[Pose; 2],
    kinematic_state: &KinematicState,
) -> [f64; ROWS] {
    let mut error = [0.0; ROWS];
    for (limb, (from, to)) in reached.iter().zip(target.world_from_soles).enumerate() {
        let turn = scaled_axis_from_rotation(to.rotation * from.rotation.conjugate());
        write_twist(&mut error, limb, to.translation - from.translation, turn);
    }
    let com = kinematic_state.com.truncate();
    let [least, desired] = DEEPER.map(|deeper| target.com_margin + deeper);
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

/// What shifting and turning the root and moving each joint of the trunk and the legs does to the
/// rows of the error.
fn unknowns(
    robot: &Mechanism,
    configuration: &Configuration,
    reached: &[Pose; 2],
    kinematic_state: &KinematicState,
) -> heapless::Vec<Unknown<ROWS>, UNKNOWNS> {
    let root = configuration.world_from_root;
    let axes = [DVec3::X, DVec3::Y, DVec3::Z];
    let shift = |axis: DVec3| (root_effect(reached, |_| axis, DVec3::ZERO, axis / LEGS_LAG), 1.0);
    let turn = |axis: DVec3| {
        let moved = |point: DVec3| axis.cross(point - root.translation);
        (root_effect(reached, moved, axis, moved(kinematic_state.com)), ROOT_WEIGHT)
    };
    let free =
        |(effect, weight)| Unknown { effect, weight, range: [f64::NEG_INFINITY, f64::INFINITY] };
    let mut unknowns: heapless::Vec<_, UNKNOWNS> =
        axes.map(shift).into_iter().chain(axes.map(turn)).map(free).collect();
    unknowns.extend(robot.trunk_joints.iter().map(|joint| {
        let mut effect = [0.0; ROWS];
        [effect[COM], effect[COM + 1]] =
            robot.statics.com_shift(kinematic_state, joint.index).truncate().to_array();
        joint_unknown(effect, [joint.lower, joint.upper], configuration.q[joint.index])
    }));
    for (limb, leg) in robot.legs.iter().enumerate() {
        unknowns.extend(leg.axes(&configuration.q).map(|(joint, motion)| {
            let world_from_joint = root * motion;
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

/// A joint, which stops at its limits.
fn joint_unknown(effect: [f64; ROWS], [lower, upper]: [f64; 2], position: f64) -> Unknown<ROWS> {
    Unknown {
        effect,
        weight: 1.0,
        range: [(lower - position).min(0.0), (upper - position).max(0.0)],
    }
}

/// What a motion of the root does: how it moves the points of the soles, how it turns them, and how
/// it moves the centre of mass.
fn root_effect(
    reached: &[Pose; 2],
    moved: impl Fn(DVec3) -> DVec3,
    angular: DVec3,
    com: DVec3,
) -> [f64; ROWS] {
    let mut effect = [0.0; ROWS];
    for (limb, sole) in reached.iter().enumerate() {
        write_twist(&mut effect, limb, moved(sole.translation), angular);
    }
    [effect[COM], effect[COM + 1]] = com.truncate().to_array();
    effect
}

fn take_step(robot: &Mechanism, configuration: &mut Configuration, step: &[f64; UNKNOWNS]) {
    let root = configuration.world_from_root;
    let [shift, turn] = [0, 3].map(|first| DVec3::from_slice(&step[first..]));
    let rotation = (rotation_from_scaled_axis(turn) * root.rotation).normalize();
    configuration.world_from_root = Pose::from_parts(root.translation + shift, rotation);
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
