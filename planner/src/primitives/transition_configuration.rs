//! Transition configurations: both feet on their footholds, all weight on one of them [Grey 4.4.2].
//!
//! The unknowns are the root's pose and the free joints. The root's rotation and height are chosen,
//! its horizontal position follows ([`solve_posture_into`]). The first attempts are primitive
//! postures, then samples near them, then uniform samples [Grey 4.4.5], at last also from all
//! postures.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DQuat, DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_about, rotation_from_rpy, wrap_angle, yaw_of};

use crate::base::random::{Random, Stream};
use crate::collision::model::FootPhase;
use crate::constraints::constraints::Constraints;
use crate::constraints::foothold::{Foothold, double_mode, single_mode};
use crate::constraints::mode::Mode;
use crate::constraints::rejection::Rejection;
use crate::geometry::convex_region::ConvexRegion;
use crate::kinematics::Leg;
use crate::primitives::level_sole::side_of;
use crate::primitives::tuning::{
    ANY_BRANCH_EVERY, COM_SPREAD, EXTENSION_SPREAD, FAR_REACHING_POSTURES, FREE_JOINT_SPREAD,
    LEAN_BOUNDS, LEAN_SPREAD, NEIGHBOURHOOD_ATTEMPTS, NEIGHBOURHOOD_SPREAD, PRIMITIVE_POSTURES,
    PROJECTED_FROM, PROJECTION_WEIGHT, PrimitivePosture, ROTATION_SPREADS, UNBOUNDED_FROM,
    UNBOUNDED_LEG_EXTENSIONS,
};
use crate::robot::configuration::Configuration;
use crate::robot::constrained_projection::{ProjectionTarget, project};
use crate::robot::crouch::Crouch;
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::Mechanism;
use crate::robot::posture_ik::{COM_TOLERANCE, Posture, initial_guess, solve_posture_into};
use crate::robot::single_support::SingleSupportPosture;

/// The footholds of a transition: all weight on `stance`, `other` in contact.
#[derive(Debug, Clone, Copy)]
pub struct TransitionPair<'a> {
    /// The foothold that supports the robot.
    pub stance: &'a Foothold,
    /// The foothold that is touched.
    pub other: &'a Foothold,
}

/// Samples a transition configuration. `attempt` counts the attempts S(T) made so far. `random` is
/// the seed and the transition's number in the random stream. `mode` is the single-support mode of
/// the stance foothold.
///
/// # Errors
/// The constraint that this attempt violates.
pub fn sample(
    constraints: &Constraints,
    mode: &Mode,
    pair: TransitionPair<'_>,
    random: (u64, u64),
    attempt: u64,
) -> Result<Configuration, Rejection> {
    let (seed, object) = random;
    let mut stream = Random::new(seed, Stream::Transition, object, attempt);
    let robot = &constraints.robot;
    let com_margin = constraints.com_margin(mode);
    let (posture, free) = if is_unbounded(attempt) {
        let (posture, mut free) = choose_anywhere(constraints, mode, pair, com_margin, &mut stream);
        if attempt.is_multiple_of(ANY_BRANCH_EVERY) {
            draw_legs(robot, &mut free, &mut stream);
        }
        (posture, free)
    } else {
        choose(constraints, mode, pair, com_margin, attempt, &mut stream)
    };
    let soles = world_from_soles(pair);
    let mut kinematic_state = KinematicState::default();
    let is_projected =
        is_projected(robot, attempt) || robot.is_projected_at(posture.world_from_root);
    let configuration = if is_projected {
        let target =
            ProjectionTarget { world_from_soles: &soles, region: &mode.region, com_margin };
        let begin = initial_guess(robot, &soles, &posture, free);
        project(robot, &target, &begin, &mut kinematic_state).ok_or(Rejection::Unreachable)?
    } else {
        solve_posture_into(robot, &soles, &posture, free, &mut kinematic_state)?
    };
    constraints.check(mode, &kinematic_state, [FootPhase::Stance; 2])?;
    // The configuration also ends the double support, whose region may demand a larger margin.
    let is_balanced =
        constraints.is_balanced(&double_mode(pair.stance, pair.other), &kinematic_state);
    is_balanced.then_some(configuration).ok_or(Rejection::Balance)
}

/// Samples a configuration on both feet, with the centre of mass over either of them or between.
/// `attempt` counts the attempts made so far: even ones begin with primitive postures, odd ones
/// draw from all postures. `random` is the seed and the number of the sample's object.
///
/// # Errors
/// The constraint that this attempt violates.
pub fn sample_double(
    constraints: &Constraints,
    [left, right]: [&Foothold; 2],
    random: (u64, u64),
    attempt: u64,
) -> Result<Configuration, Rejection> {
    let (seed, object) = random;
    let mut stream = Random::new(seed, Stream::Transition, object, attempt);
    let mode = double_mode(left, right);
    let pair = TransitionPair { stance: left, other: right };
    let com_margin = constraints.com_margin(&mode);
    let (posture, free) = if attempt.is_multiple_of(2) {
        choose(constraints, &mode, pair, com_margin, attempt / 2, &mut stream)
    } else {
        choose_anywhere(constraints, &mode, pair, com_margin, &mut stream)
    };
    let mut kinematic_state = KinematicState::default();
    let configuration = solve_posture_into(
        &constraints.robot,
        &world_from_soles(pair),
        &posture,
        free,
        &mut kinematic_state,
    )?;
    constraints.check(&mode, &kinematic_state, [FootPhase::Stance; 2])?;
    Ok(configuration)
}

/// Whether an attempt draws from all postures instead of those near a primitive one: every other
/// attempt after many have failed.
pub fn is_unbounded(attempt: u64) -> bool {
    attempt >= UNBOUNDED_FROM && attempt.is_multiple_of(2)
}

/// The number of attempts that this one counts for in S(T): a projection takes as long as several
/// samples, and succeeds more often. Where the root leans far on the footholds it does not, and
/// samples from all postures, to which few motions lead, are to come late.
pub fn attempt_weight(robot: &Mechanism, pair: TransitionPair<'_>, attempt: u32) -> u32 {
    let leans_far = || {
        let Crouch { roll, pitch, .. } = pair.stance.crouch.deeper(pair.other.crouch);
        robot.is_projected_at(rotation_from_rpy(roll, pitch, 0.0))
    };
    if is_projected(robot, u64::from(attempt)) && !leans_far() { PROJECTION_WEIGHT } else { 1 }
}

/// Whether an attempt is a projection: after samples have failed, and only where the legs have no
/// closed form. With a closed form, samples find more in the time of a projection.
fn is_projected(robot: &Mechanism, attempt: u64) -> bool {
    attempt >= PROJECTED_FROM && !robot.legs.iter().all(Leg::is_closed_form)
}

/// Whether one of the [`FAR_REACHING_POSTURES`] brings both soles to their footholds, with the
/// centre of mass over the stance [Grey 4.4.2]. `mode` is the single-support mode of the stance
/// foothold. A pair that is not reached is unlikely, not impossible: another posture may reach it.
pub fn is_reached(constraints: &Constraints, mode: &Mode, pair: TransitionPair<'_>) -> bool {
    let mut kinematic_state = KinematicState::default();
    FAR_REACHING_POSTURES
        .into_iter()
        .any(|attempt| reaches_in(constraints, mode, pair, attempt, &mut kinematic_state))
}

/// Whether the robot, standing on one foothold, reaches another one in one of these postures.
pub fn is_within_reach(constraints: &Constraints, stance: &Foothold, other: &Foothold) -> bool {
    is_reached(constraints, &single_mode(stance), TransitionPair { stance, other })
}

/// Whether the robot, standing on the first foothold, reaches the second one, and can then stand on
/// the second one while it touches the first, by inverse kinematics [Grey 4.4.2].
pub fn is_step(constraints: &Constraints, [from, to]: [&Foothold; 2]) -> bool {
    is_within_reach(constraints, from, to) && is_within_reach(constraints, to, from)
}

/// The index of the first of the [`FAR_REACHING_POSTURES`] that reaches both footholds and meets
/// every constraint: balanced, within limits, free of collisions [Grey figure 4.14].
pub fn first_valid_posture(
    constraints: &Constraints,
    mode: &Mode,
    pair: TransitionPair<'_>,
) -> Option<usize> {
    let mut kinematic_state = KinematicState::default();
    let mut is_valid = |attempt: u64| {
        reaches_in(constraints, mode, pair, attempt, &mut kinematic_state)
            && constraints.check(mode, &kinematic_state, [FootPhase::Stance; 2]).is_ok()
    };
    FAR_REACHING_POSTURES.into_iter().position(&mut is_valid)
}

/// Whether any primitive posture is a configuration of a transition.
pub fn has_valid_posture(constraints: &Constraints, mode: &Mode, pair: TransitionPair<'_>) -> bool {
    (0..PRIMITIVE_POSTURES.len() as u64)
        .any(|attempt| sample(constraints, mode, pair, (0, 0), attempt).is_ok())
}

fn reaches_in(
    constraints: &Constraints,
    mode: &Mode,
    pair: TransitionPair<'_>,
    attempt: u64,
    kinematic_state: &mut KinematicState,
) -> bool {
    let robot = &constraints.robot;
    let mut stream = Random::new(0, Stream::Transition, 0, 0);
    let (posture, free) =
        choose(constraints, mode, pair, constraints.com_margin(mode), attempt, &mut stream);
    solve_posture_into(robot, &world_from_soles(pair), &posture, free, kinematic_state).is_ok()
}

/// Whether the left foot stands to the right of the right one, in the mean heading of both.
pub fn are_crossed(pair: TransitionPair<'_>) -> bool {
    let [left, right] = world_from_soles(pair);
    let leftward = rotation_about(DVec3::Z, mean_yaw(left.rotation, right.rotation)) * DVec3::Y;
    (left.translation - right.translation).dot(leftward) < 0.0
}

/// The sole poses of a pair, by limb.
pub fn world_from_soles(pair: TransitionPair<'_>) -> [Pose; 2] {
    let mut soles = [pair.other.world_from_sole; 2];
    soles[pair.stance.limb] = pair.stance.world_from_sole;
    soles
}

type FreeJoints = [f64; surefoot_shared_types::base::limits::JOINTS_MAX];

/// The posture of an attempt and its free joints: a primitive posture, or a random deviation from
/// one.
fn choose(
    constraints: &Constraints,
    mode: &Mode,
    pair: TransitionPair<'_>,
    com_margin: f64,
    attempt: u64,
    stream: &mut Random,
) -> (Posture, FreeJoints) {
    let primitives = PRIMITIVE_POSTURES.len() as u64;
    let heading =
        mean_yaw(pair.stance.world_from_sole.rotation, pair.other.world_from_sole.rotation);
    let PrimitivePosture { extension, pitch, roll, lean } =
        PRIMITIVE_POSTURES[(attempt % primitives) as usize];
    let side = side_of(pair.stance.limb);
    let SingleSupportPosture { rotation: [base_roll, base_pitch], q: mut free, .. } =
        constraints.single_support_postures[pair.stance.limb];
    let uniform = attempt >= primitives + NEIGHBOURHOOD_ATTEMPTS;
    let spread = match attempt {
        _ if uniform => 1.0,
        _ if attempt >= primitives => NEIGHBOURHOOD_SPREAD,
        _ => 0.0,
    };
    let crouch = pair.stance.crouch.deeper(pair.other.crouch);
    let mut jitter = |half: f64| spread * stream.uniform(-half, half);
    let [yaw_spread, roll_spread, pitch_spread] = ROTATION_SPREADS;
    let rotation = rotation_about(DVec3::Z, heading + jitter(yaw_spread))
        * rotation_from_rpy(
            base_roll - side * roll + crouch.roll + jitter(roll_spread),
            base_pitch + pitch + crouch.pitch + jitter(pitch_spread),
            0.0,
        );
    let leg_extension = crouch.leg_extension
        * (extension + jitter(EXTENSION_SPREAD))
        * constraints.robot.standing_leg_extension;
    let lean = (lean + jitter(LEAN_SPREAD)).clamp(LEAN_BOUNDS[0], LEAN_BOUNDS[1]);
    constraints.bend_waist(&mut free, crouch.waist);
    if uniform {
        let waist = constraints.waist.filter(|_| crouch.waist > 0.0);
        let is_bent = |index| waist.is_some_and(|waist| waist.joint() == index);
        let joints = constraints.robot.free_joints.iter();
        for joint in joints.filter(|joint| joint.is_sampled && !is_bent(joint.index)) {
            let position = free[joint.index] + jitter(FREE_JOINT_SPREAD);
            free[joint.index] = position.clamp(joint.lower, joint.upper);
        }
    }
    let target = lean_target(
        &mode.region,
        pair.other.region.centroid(),
        lean,
        com_margin + 2.0 * COM_TOLERANCE,
    );
    let com = target + DVec2::new(jitter(COM_SPREAD), jitter(COM_SPREAD));
    (Posture { world_from_root: rotation, leg_extension, com }, free)
}

/// A random posture anywhere: every rotation of the root, every leg extension, every point of the
/// region for the centre of mass, and all positions of the free joints within their limits. Half of
/// the range in the middle is drawn more often, since most postures at the limits collide.
fn choose_anywhere(
    constraints: &Constraints,
    mode: &Mode,
    pair: TransitionPair<'_>,
    com_margin: f64,
    stream: &mut Random,
) -> (Posture, FreeJoints) {
    let heading =
        mean_yaw(pair.stance.world_from_sole.rotation, pair.other.world_from_sole.rotation);
    let share = stream.uniform(0.0, 1.0);
    let mut angle = |half: f64| share * stream.uniform(-half, half);
    let rotation = rotation_about(DVec3::Z, heading + angle(PI))
        * rotation_from_rpy(angle(PI), angle(FRAC_PI_2), 0.0);
    let mut free = constraints.single_support_postures[pair.stance.limb].q;
    let share = stream.uniform(0.0, 1.0);
    for joint in constraints.robot.free_joints.iter().filter(|joint| joint.is_sampled) {
        let position = &mut free[joint.index];
        *position += share * (stream.uniform(joint.lower, joint.upper) - *position);
    }
    let leg_extension = stream.uniform(UNBOUNDED_LEG_EXTENSIONS[0], UNBOUNDED_LEG_EXTENSIONS[1]);
    let (sin, cos) = libm::sincos(stream.uniform(-PI, PI));
    let centroid = mode.region.centroid();
    let extents = mode.region.vertices().iter().map(|vertex| vertex.distance(centroid));
    let offset = extents.fold(0.0, f64::max) * libm::sqrt(stream.uniform(0.0, 1.0));
    let drawn = centroid + offset * DVec2::new(cos, sin);
    let com = mode.region.nearest_inside(drawn, com_margin + 2.0 * COM_TOLERANCE);
    (Posture { world_from_root: rotation, leg_extension, com }, free)
}

/// Draws the joints of both legs within their limits: inverse kinematics then finds another of its
/// branches where there are several.
fn draw_legs(robot: &Mechanism, q: &mut FreeJoints, stream: &mut Random) {
    for joint in robot.legs.iter().flat_map(Leg::joints) {
        q[joint.index] = stream.uniform(joint.lower, joint.upper);
    }
}

/// The point at the fraction `lean` from the region's centroid to the point nearest to `other` that
/// keeps the margin (m).
fn lean_target(region: &ConvexRegion, other: DVec2, lean: f64, margin: f64) -> DVec2 {
    let centroid = region.centroid();
    let limit = region.nearest_inside(other, margin);
    centroid + lean * (limit - centroid)
}

/// The mean heading of two rotations, rad.
pub fn mean_yaw(a: DQuat, b: DQuat) -> f64 {
    let (a, b) = (yaw_of(a), yaw_of(b));
    a + 0.5 * wrap_angle(b - a)
}
