//! Transition configurations: both feet on their placements, all weight on one of them
//! [Grey 4.4.2].
//!
//! The root's pose is the only unknown beside the free joints: its rotation and height are chosen,
//! the rest follows ([`solve_posture_into`]). The first attempts are primitive configurations, then
//! their neighbourhood, then uniform samples [Grey 4.4.5].

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
use crate::robot::configuration::Configuration;
use crate::robot::constrained_projection::{ProjectionTarget, project};
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::Mechanism;
use crate::robot::posture_ik::{COM_TOLERANCE, Posture, initial_guess, solve_posture_into};
use crate::robot::single_support::SingleSupportPosture;

/// The primitive postures: share of the standing reach beyond which to bend, pitch (rad), roll
/// toward the stance foot (rad), and how far the centre of mass stands from the support's centroid
/// toward the other foot (share of what the margin leaves).
const PRIMITIVES: [(f64, f64, f64, f64); 12] = [
    (1.0, 0.0, 0.0, 0.5),
    (1.0, 0.0, 0.0, 0.0),
    (0.96, 0.0, 0.0, 0.7),
    (1.03, 0.0, 0.0, 0.6),
    (0.92, 0.12, 0.0, 0.5),
    (1.02, 0.0, 0.08, 0.8),
    (0.96, 0.15, 0.08, 0.8),
    (0.88, 0.25, 0.0, 0.6),
    (1.02, 0.2, 0.0, 0.9),
    (0.98, -0.08, -0.08, 0.6),
    (0.84, 0.35, 0.1, 0.8),
    (1.03, 0.0, -0.1, 0.9),
];
/// The primitive postures that reach farthest, by attempt: these few reach nineteen of twenty pairs
/// that any of them does. First the one that asks most of the room about the robot: where it holds,
/// swings find their way, too.
pub const FAR_REACHING_POSTURES: [u64; 4] = [10, 8, 11, 5];
/// Attempts in the neighbourhood of the primitives, before uniform ones.
const NEIGHBOURHOOD_ATTEMPTS: u64 = 24;
/// Attempts from here on are projections, where the legs have no closed form.
const PROJECTED_FROM: u64 = 24;
/// As many attempts a projection counts for.
const PROJECTION_WEIGHT: u32 = 5;

/// A transition: all weight on `stance`, `other` in touch.
#[derive(Debug, Clone, Copy)]
pub struct TransitionPair<'a> {
    /// The placement that carries the robot.
    pub stance: &'a Foothold,
    /// The placement that is touched.
    pub other: &'a Foothold,
}

/// Samples a transition configuration. `attempt` counts the attempts S(T) made so far; `object`
/// names the transition in the random stream. `mode` is the single-support mode of the stance
/// placement.
///
/// # Errors
/// Why this attempt failed.
pub fn sample(
    constraints: &Constraints,
    mode: &Mode,
    pair: TransitionPair<'_>,
    random: (u64, u64),
    attempt: u64,
) -> Result<Configuration, Rejection> {
    let (seed, object) = random;
    let mut random_draws = Random::new(seed, Stream::Transition, object, attempt);
    let robot = &constraints.robot;
    let com_margin = constraints.com_margin(mode);
    let (posture, free) = choose(constraints, mode, pair, com_margin, attempt, &mut random_draws);
    let soles = world_from_soles(pair);
    let mut kinematic_state = KinematicState::default();
    let configuration = if is_projected(robot, attempt) {
        let target =
            ProjectionTarget { world_from_soles: &soles, region: &mode.region, com_margin };
        let begin = initial_guess(robot, &soles, &posture, free);
        project(robot, &target, &begin, &mut kinematic_state).ok_or(Rejection::Unreachable)?
    } else {
        solve_posture_into(robot, &soles, &posture, free, &mut kinematic_state)?
    };
    constraints.check(mode, &kinematic_state, [FootPhase::Stance; 2])?;
    // It also ends the double support, which may be desired to be deeper inside its larger region.
    let is_deep = constraints.is_balanced(&double_mode(pair.stance, pair.other), &kinematic_state);
    is_deep.then_some(configuration).ok_or(Rejection::Balance)
}

/// As many attempts this one counts for in S(T): a projection takes as long as several samples, and
/// tells more.
pub fn attempt_weight(robot: &Mechanism, attempt: u32) -> u32 {
    if is_projected(robot, u64::from(attempt)) { PROJECTION_WEIGHT } else { 1 }
}

/// Whether an attempt is a projection: once samples have failed, and only where the legs have no
/// closed form. With one, samples cost so little that as many of them as a projection takes find
/// more.
fn is_projected(robot: &Mechanism, attempt: u64) -> bool {
    attempt >= PROJECTED_FROM && !robot.legs.iter().all(Leg::is_closed_form)
}

/// Whether one of a few primitive postures brings both soles to their placements, the centre of
/// mass where the stance can carry it [Grey 4.4.2]. `mode` is the single-support mode of the stance
/// placement. Where none does, another posture may: a pair that is not reached is unlikely, not
/// impossible.
pub fn is_reached(constraints: &Constraints, mode: &Mode, pair: TransitionPair<'_>) -> bool {
    let mut kinematic_state = KinematicState::default();
    FAR_REACHING_POSTURES
        .into_iter()
        .any(|attempt| reaches_in(constraints, mode, pair, attempt, &mut kinematic_state))
}

/// Whether the robot, standing on one placement, reaches another one in one of these postures.
pub fn is_within_reach(constraints: &Constraints, stance: &Foothold, other: &Foothold) -> bool {
    is_reached(constraints, &single_mode(stance), TransitionPair { stance, other })
}

/// Whether the robot, standing on the first foothold, reaches the second one, and then stands on
/// that with the first still touched, by inverse kinematics [Grey 4.4.2].
pub fn is_step(constraints: &Constraints, [from, to]: [&Foothold; 2]) -> bool {
    is_within_reach(constraints, from, to) && is_within_reach(constraints, to, from)
}

/// The first of the same postures, which are [`FAR_REACHING_POSTURES`], that also holds: balanced,
/// within limits, free of the world, the legs apart [Grey figure 4.14].
pub fn first_valid_posture(
    constraints: &Constraints,
    mode: &Mode,
    pair: TransitionPair<'_>,
) -> Option<usize> {
    let mut kinematic_state = KinematicState::default();
    let mut holds = |attempt: u64| {
        reaches_in(constraints, mode, pair, attempt, &mut kinematic_state)
            && constraints.check(mode, &kinematic_state, [FootPhase::Stance; 2]).is_ok()
    };
    FAR_REACHING_POSTURES.into_iter().position(&mut holds)
}

/// Whether any primitive posture is a configuration of a transition.
pub fn has_valid_posture(constraints: &Constraints, mode: &Mode, pair: TransitionPair<'_>) -> bool {
    (0..PRIMITIVES.len() as u64)
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
    let mut random_draws = Random::new(0, Stream::Transition, 0, 0);
    let (posture, free) =
        choose(constraints, mode, pair, constraints.com_margin(mode), attempt, &mut random_draws);
    solve_posture_into(robot, &world_from_soles(pair), &posture, free, kinematic_state).is_ok()
}

/// Whether the left foot stands to the right of the other, as the robot faces.
pub fn are_crossed(pair: TransitionPair<'_>) -> bool {
    let [left, right] = world_from_soles(pair);
    let leftward = rotation_about(DVec3::Z, mean_yaw(left.rotation, right.rotation)) * DVec3::Y;
    (left.translation - right.translation).dot(leftward) < 0.0
}

/// The soles of a pair by limb.
pub fn world_from_soles(pair: TransitionPair<'_>) -> [Pose; 2] {
    let mut soles = [pair.other.world_from_sole; 2];
    soles[pair.stance.limb] = pair.stance.world_from_sole;
    soles
}

type FreeJoints = [f64; surefoot_shared_types::base::limits::JOINTS_MAX];

fn choose(
    constraints: &Constraints,
    mode: &Mode,
    pair: TransitionPair<'_>,
    com_margin: f64,
    attempt: u64,
    random_draws: &mut Random,
) -> (Posture, FreeJoints) {
    let primitives = PRIMITIVES.len() as u64;
    let heading =
        mean_yaw(pair.stance.world_from_sole.rotation, pair.other.world_from_sole.rotation);
    let (share, pitch, roll, lean) = PRIMITIVES[(attempt % primitives) as usize];
    let side = side_of(pair.stance.limb);
    let SingleSupportPosture { rotation: [base_roll, base_pitch], q: mut free, .. } =
        constraints.single_support_postures[pair.stance.limb];
    let uniform = attempt >= primitives + NEIGHBOURHOOD_ATTEMPTS;
    let spread = match attempt {
        _ if uniform => 1.0,
        _ if attempt >= primitives => 0.4,
        _ => 0.0,
    };
    let crouch = pair.stance.crouch.deeper(pair.other.crouch);
    let mut jitter = |half: f64| spread * random_draws.uniform(-half, half);
    let rotation = rotation_about(DVec3::Z, heading + jitter(0.6))
        * rotation_from_rpy(
            base_roll - side * roll + jitter(0.25),
            base_pitch + pitch + crouch.pitch + jitter(0.3),
            0.0,
        );
    let share =
        crouch.leg_extension * (share + jitter(0.15)) * constraints.robot.standing_leg_extension;
    let lean = (lean + jitter(0.6)).clamp(-0.5, 1.0);
    if uniform {
        for joint in constraints.robot.free_joints.iter().filter(|joint| joint.is_sampled) {
            let position = free[joint.index] + jitter(0.5);
            free[joint.index] = position.clamp(joint.lower, joint.upper);
        }
    }
    let toward = lean_target(
        &mode.region,
        pair.other.region.centroid(),
        lean,
        com_margin + 2.0 * COM_TOLERANCE,
    );
    let com = toward + DVec2::new(jitter(0.02), jitter(0.02));
    (Posture { world_from_root: rotation, leg_extension: share, com }, free)
}

/// The point a share `lean` of the way from the region's centroid toward `other`, as far as the
/// margin allows.
fn lean_target(region: &ConvexRegion, other: DVec2, lean: f64, margin: f64) -> DVec2 {
    let centroid = region.centroid();
    let limit = region.nearest_inside(other, margin);
    centroid + lean * (limit - centroid)
}

/// The heading halfway between two.
pub fn mean_yaw(a: DQuat, b: DQuat) -> f64 {
    let (a, b) = (yaw_of(a), yaw_of(b));
    a + 0.5 * wrap_angle(b - a)
}
