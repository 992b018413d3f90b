//! Transition configurations: both feet on their footholds, all weight on one of them [Grey 4.4.2].
//!
//! The unknowns are the root's pose and the free joints. The root's rotation and height are chosen,
//! its horizontal position follows ([`solve_posture_into`]). The first attempts are primitive
//! postures, then samples near them, then uniform samples [Grey 4.4.5], at last also from all
//! postures.

use surefoot_shared_types::base::spatial::rotation_from_rpy;

use crate::base::random::{Random, Stream};
use crate::collision::model::FootPhase;
use crate::constraints::constraints::Constraints;
use crate::constraints::foothold::{Foothold, double_mode, single_mode};
use crate::constraints::mode::Mode;
use crate::constraints::rejection::Rejection;
use crate::kinematics::Leg;
use crate::primitives::posture_choice::{FreeJoints, PostureChoice};
use crate::primitives::transition_pair::TransitionPair;
use crate::primitives::tuning::{
    ANY_BRANCH_EVERY, FAR_REACHING_POSTURES, PRIMITIVE_POSTURES, PROJECTED_FROM, PROJECTION_WEIGHT,
    UNBOUNDED_FROM,
};
use crate::robot::configuration::Configuration;
use crate::robot::constrained_projection::{ProjectionTarget, project};
use crate::robot::crouch::Crouch;
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::Mechanism;
use crate::robot::posture_ik::{initial_guess, solve_posture_into};

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
    let choice = PostureChoice::new(constraints, mode, pair);
    let (posture, free) = if is_unbounded(attempt) {
        let (posture, mut free) = choice.anywhere(&mut stream);
        if attempt.is_multiple_of(ANY_BRANCH_EVERY) {
            draw_legs(robot, &mut free, &mut stream);
        }
        (posture, free)
    } else {
        choice.near_primitive(attempt, &mut stream)
    };
    let soles = pair.world_from_soles();
    let mut kinematic_state = KinematicState::default();
    let is_projected =
        is_projected(robot, attempt) || robot.is_projected_at(posture.world_from_root);
    let configuration = if is_projected {
        let com_margin = constraints.com_margin(mode);
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
    let choice = PostureChoice::new(constraints, &mode, pair);
    let (posture, free) = if attempt.is_multiple_of(2) {
        choice.near_primitive(attempt / 2, &mut stream)
    } else {
        choice.anywhere(&mut stream)
    };
    let mut kinematic_state = KinematicState::default();
    let configuration = solve_posture_into(
        &constraints.robot,
        &pair.world_from_soles(),
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

/// Whether the robot can stand on the first foothold and touch the second one, and then stand on the
/// second one and touch the first, in postures that meet every constraint.
pub fn is_valid_step(constraints: &Constraints, [from, to]: [&Foothold; 2]) -> bool {
    let is_valid = |stance: &Foothold, other: &Foothold| {
        let pair = TransitionPair { stance, other };
        first_valid_posture(constraints, &single_mode(stance), pair).is_some()
    };
    is_valid(from, to) && is_valid(to, from)
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
    let choice = PostureChoice::new(constraints, mode, pair);
    let (posture, free) = choice.near_primitive(attempt, &mut stream);
    solve_posture_into(robot, &pair.world_from_soles(), &posture, free, kinematic_state).is_ok()
}

/// Draws the joints of both legs within their limits: inverse kinematics then finds another of its
/// branches where there are several.
fn draw_legs(robot: &Mechanism, q: &mut FreeJoints, stream: &mut Random) {
    for joint in robot.legs.iter().flat_map(Leg::joints) {
        q[joint.index] = stream.uniform(joint.lower, joint.upper);
    }
}
