//! Transition configurations: both feet on their placements, all weight on one of them
//! [Grey 4.4.2].
//!
//! The root's pose is the only unknown beside the free joints: its rotation and height are chosen,
//! the rest follows ([`settle_into`]). The first attempts are primitive configurations, then their
//! neighbourhood, then uniform samples [Grey 4.4.5].

use glam::{DQuat, DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::spatial::{rotation_about, rotation_from_rpy, wrap_angle, yaw_of};

use crate::body::{Body, Configuration};
use crate::carriage::Carriage;
use crate::collision::FootState;
use crate::constraint::{Constraints, Mode, Rejection};
use crate::kinematics::Leg;
use crate::motion::foothold::{Foothold, double_mode, single_mode};
use crate::motion::primitive::stand::side_of;
use crate::posture::{COM_TOLERANCE, Posture, settle_into, unsettled};
use crate::projection::{Ground, project};
use crate::random::{Random, Stream};
use crate::region::Region;
use crate::snapshot::Snapshot;

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
pub const REACHING: [u64; 4] = [10, 8, 11, 5];
/// Attempts in the neighbourhood of the primitives, before uniform ones.
const NEIGHBOURHOOD_ATTEMPTS: u64 = 24;
/// Attempts from here on are projections, where the legs have no closed form.
const PROJECTED_FROM: u64 = 24;
/// As many attempts a projection counts for.
const PROJECTION_COUNTS: u32 = 5;

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
    let mut draws = Random::new(seed, Stream::Transition, object, attempt);
    let body = &constraints.body;
    let com_margin = constraints.com_margin(mode);
    let (posture, free) = choose(body, mode, pair, com_margin, attempt, &mut draws);
    let soles = world_from_soles(pair);
    let mut snapshot = Snapshot::default();
    let configuration = if is_projected(body, attempt) {
        let ground = Ground { world_from_soles: &soles, region: &mode.region, com_margin };
        let begin = unsettled(body, &soles, &posture, free);
        project(body, &ground, &begin, &mut snapshot).ok_or(Rejection::Unreachable)?
    } else {
        settle_into(body, &soles, &posture, free, &mut snapshot)?
    };
    constraints.check(mode, &snapshot, [FootState::Stance; 2])?;
    // It also ends the double support, which may be wished to be deeper inside its larger region.
    let is_deep = constraints.is_balanced(&double_mode(pair.stance, pair.other), &snapshot);
    is_deep.then_some(configuration).ok_or(Rejection::Balance)
}

/// As many attempts this one counts for in S(T): a projection takes as long as several samples, and
/// tells more.
pub fn counts(body: &Body, attempt: u32) -> u32 {
    if is_projected(body, u64::from(attempt)) { PROJECTION_COUNTS } else { 1 }
}

/// Whether an attempt is a projection: once samples have failed, and only where the legs have no
/// closed form. With one, samples cost so little that as many of them as a projection takes find
/// more.
fn is_projected(body: &Body, attempt: u64) -> bool {
    attempt >= PROJECTED_FROM && !body.legs.iter().all(Leg::is_closed_form)
}

/// Whether one of a few primitive postures brings both soles to their placements, the centre of
/// mass where the stance can carry it [Grey 4.4.2]. `mode` is the single-support mode of the stance
/// placement. Where none does, another posture may: a pair that is not reached is unlikely, not
/// impossible.
pub fn is_reached(constraints: &Constraints, mode: &Mode, pair: TransitionPair<'_>) -> bool {
    let mut snapshot = Snapshot::default();
    REACHING.into_iter().any(|attempt| reach(constraints, mode, pair, attempt, &mut snapshot))
}

/// Whether the robot, standing on one placement, reaches another one in one of these postures.
pub fn reaches(constraints: &Constraints, stance: &Foothold, other: &Foothold) -> bool {
    is_reached(constraints, &single_mode(stance), TransitionPair { stance, other })
}

/// The first of the same postures, which are [`REACHING`], that also holds: balanced, within
/// limits, free of the world, the legs apart [Grey figure 4.14].
pub fn posture_that_holds(
    constraints: &Constraints,
    mode: &Mode,
    pair: TransitionPair<'_>,
) -> Option<usize> {
    let mut snapshot = Snapshot::default();
    let mut holds = |attempt: u64| {
        reach(constraints, mode, pair, attempt, &mut snapshot)
            && constraints.check(mode, &snapshot, [FootState::Stance; 2]).is_ok()
    };
    REACHING.into_iter().position(&mut holds)
}

/// Whether any primitive posture is a configuration of a transition.
pub fn any_posture_holds(constraints: &Constraints, mode: &Mode, pair: TransitionPair<'_>) -> bool {
    (0..PRIMITIVES.len() as u64)
        .any(|attempt| sample(constraints, mode, pair, (0, 0), attempt).is_ok())
}

fn reach(
    constraints: &Constraints,
    mode: &Mode,
    pair: TransitionPair<'_>,
    attempt: u64,
    snapshot: &mut Snapshot,
) -> bool {
    let body = &constraints.body;
    let mut draws = Random::new(0, Stream::Transition, 0, 0);
    let (posture, free) =
        choose(body, mode, pair, constraints.com_margin(mode), attempt, &mut draws);
    settle_into(body, &world_from_soles(pair), &posture, free, snapshot).is_ok()
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

type FreeJoints = [f64; surefoot_shared_types::message::limits::JOINTS_MAX];

fn choose(
    body: &Body,
    mode: &Mode,
    pair: TransitionPair<'_>,
    com_margin: f64,
    attempt: u64,
    draws: &mut Random,
) -> (Posture, FreeJoints) {
    let primitives = PRIMITIVES.len() as u64;
    let heading =
        mean_yaw(pair.stance.world_from_sole.rotation, pair.other.world_from_sole.rotation);
    let (share, pitch, roll, lean) = PRIMITIVES[(attempt % primitives) as usize];
    let side = side_of(pair.stance.limb);
    let Carriage { rotation: [carried_roll, carried_pitch], q: mut free, .. } =
        body.carriages[pair.stance.limb];
    let uniform = attempt >= primitives + NEIGHBOURHOOD_ATTEMPTS;
    let spread = match attempt {
        _ if uniform => 1.0,
        _ if attempt >= primitives => 0.4,
        _ => 0.0,
    };
    let stoop = pair.stance.stoop.deeper(pair.other.stoop);
    let mut jitter = |half: f64| spread * draws.uniform(-half, half);
    let rotation = rotation_about(DVec3::Z, heading + jitter(0.6))
        * rotation_from_rpy(
            carried_roll - side * roll + jitter(0.25),
            carried_pitch + pitch + stoop.pitch + jitter(0.3),
            0.0,
        );
    let share = stoop.share * (share + jitter(0.15)) * body.standing_reach_share;
    let lean = (lean + jitter(0.6)).clamp(-0.5, 1.0);
    if uniform {
        for joint in body.free_joints.iter().filter(|joint| joint.is_sampled) {
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
    (Posture { world_from_root: rotation, reach_share: share, com }, free)
}

/// The point a share `lean` of the way from the region's centroid toward `other`, as far as the
/// margin allows.
fn lean_target(region: &Region, other: DVec2, lean: f64, margin: f64) -> DVec2 {
    let centroid = region.centroid();
    let limit = region.nearest_inside(other, margin);
    centroid + lean * (limit - centroid)
}

/// The heading halfway between two.
pub fn mean_yaw(a: DQuat, b: DQuat) -> f64 {
    let (a, b) = (yaw_of(a), yaw_of(b));
    a + 0.5 * wrap_angle(b - a)
}
