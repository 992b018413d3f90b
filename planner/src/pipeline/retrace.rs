//! Retracing: reverse execution of the last chunks, back to a state from which a search can start.
//!
//! A robot that met an unknown obstacle may be in a state in which no search can start: its lifted
//! foot touches the obstacle, or its support is not exactly where it was planned. It can always
//! execute its last motions in reverse, since it has been there. So the lifted foot returns to
//! where it was lifted, farther back if necessary, and the search starts there.

use surefoot_shared_types::message::{Interpolation, PlanChunk, RestState, SupportMode, Waypoint};
use surefoot_shared_types::world::world::World;

use crate::constraints::constraints::Constraints;
use crate::foot_placement::sole_support::SurfacesError;
use crate::pipeline::endpoints::{StanceSurfaces, stand_in};

/// Lift-offs that are examined, the latest first.
const LIFT_OFFS_MAX: usize = 32;

/// How far back a plan leads before it leads to the goal.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Retrace {
    /// Number of the plan's first chunks that lead back.
    pub chunks: usize,
    /// Number of lift-offs passed at which every condition holds, the last one included.
    pub depth: usize,
}

/// A state that the robot was in when a foot was lifted.
#[derive(Debug, Clone)]
pub(crate) struct LiftOff<'a> {
    /// The state, with the support that the world gives it.
    pub rest_state: RestState,
    /// The chunks executed since, the first one first. Of a smooth chunk in which the robot rests,
    /// only the motion up to there is executed.
    pub since: &'a [PlanChunk],
    /// Number of such states from here to the current state.
    pub depth: usize,
}

/// A lift-off that the robot passed, at which it stood on both feet and every condition holds in
/// `world` with the centre of mass `margin_min` (m) inside the support. It is the `depth`-th last
/// one, or the farthest. `executed` are the chunks that led to `rest_state`. Allocates.
///
/// # Errors
/// A shape of the world cannot be compiled into surfaces.
pub(crate) fn lift_off_before<'a>(
    (constraints, margin_min): (&Constraints, f64),
    world: &World,
    rest_state: &RestState,
    (executed, depth): (&'a [PlanChunk], usize),
) -> Result<Option<LiftOff<'a>>, SurfacesError> {
    let executed = &executed[connected_from(rest_state, executed)..];
    let is_lift_off = |pair: &[PlanChunk]| is_double(&pair[0]) && !is_double(&pair[1]);
    let lift_offs = executed.windows(2).enumerate().rev().filter(|(_, pair)| is_lift_off(pair));
    let mut ground = StanceSurfaces::new(world)?;
    let mut farthest: Option<LiftOff<'_>> = None;
    for (index, pair) in lift_offs.take(LIFT_OFFS_MAX) {
        let passed = farthest.as_ref().map_or(0, |lift_off| lift_off.depth);
        if passed == depth {
            break;
        }
        let (mode, contacts, waypoint) =
            (pair[0].mode, pair[0].contacts(), &pair[1].waypoints()[0]);
        let state =
            ground.with_support(&constraints.robot, &rest_state.after(mode, contacts, waypoint));
        if stand_in(constraints, &state).is_ok_and(|end| end.holds(constraints, margin_min)) {
            let since = &executed[index + 1..];
            farthest = Some(LiftOff { rest_state: state, since, depth: passed + 1 });
        }
    }
    Ok(farthest)
}

/// The first chunk from which on each begins where the one before it ends, and the last one leads
/// to `rest_state`; the number of chunks if the last one does not.
fn connected_from(rest_state: &RestState, executed: &[PlanChunk]) -> usize {
    let Some((last, before)) = executed.split_last() else { return 0 };
    let rest = &rest_state.waypoint;
    let leads_to_rest = rests_within(last, rest) || ends_in(last, rest);
    if !leads_to_rest || executed_before(last, rest.time).next().is_none() {
        return executed.len();
    }
    let (mut at, mut first) = (&last.waypoints()[0], before.len());
    for chunk in before.iter().rev() {
        let [begin, .., _] = chunk.waypoints() else { break };
        if !ends_in(chunk, at) {
            break;
        }
        (at, first) = (begin, first - 1);
    }
    first
}

fn ends_in(chunk: &PlanChunk, at: &Waypoint) -> bool {
    chunk.waypoints().last().is_some_and(|end| difference(end, at) == 0.0)
}

/// Whether the robot passes a waypoint on the way through a smooth chunk, in which it stops if no
/// chunk follows.
fn rests_within(chunk: &PlanChunk, rest: &Waypoint) -> bool {
    let waypoints = chunk.waypoints();
    let after = waypoints.partition_point(|waypoint| waypoint.time <= rest.time);
    if !chunk.is_smooth() || !(1..waypoints.len()).contains(&after) {
        return false;
    }
    let [from, to] = [&waypoints[after - 1], &waypoints[after]];
    difference(&Interpolation::Quintic.between(from, to, rest.time), rest) <= REST_DIFFERENCE_MAX
}

/// The waypoints of an executed chunk before a time (s), the last one first.
pub(crate) fn executed_before(
    chunk: &PlanChunk,
    time: f64,
) -> impl DoubleEndedIterator<Item = &Waypoint> + Clone {
    chunk.waypoints().iter().filter(move |waypoint| waypoint.time < time - INTERVAL_MIN).rev()
}

/// A rest that [`rests_within`] an executed chunk or ends it, with the feed-forward torques at rest
/// that the chunk states there.
pub(crate) fn rest_in(chunk: &PlanChunk, rest: &Waypoint) -> Waypoint {
    let waypoints = chunk.waypoints();
    let after = waypoints.partition_point(|waypoint| waypoint.time <= rest.time);
    let rest_torque = if chunk.is_smooth() && (1..waypoints.len()).contains(&after) {
        let [from, to] = [&waypoints[after - 1], &waypoints[after]];
        Interpolation::Quintic.between(from, to, rest.time).rest_torque
    } else {
        waypoints[waypoints.len() - 1].rest_torque
    };
    Waypoint { rest_torque, ..*rest }
}

/// The largest difference of two configurations in any number.
fn difference(a: &Waypoint, b: &Waypoint) -> f64 {
    let numbers = |waypoint: &Waypoint| {
        let Waypoint { root_position, root_rotation, q, .. } = *waypoint;
        root_position.into_iter().chain(root_rotation).chain(q)
    };
    numbers(a).zip(numbers(b)).map(|(a, b)| (a - b).abs()).fold(0.0, f64::max)
}

/// Largest difference of a rest from the plan's motion, by which both sides' rounding may differ.
const REST_DIFFERENCE_MAX: f64 = 1e-9;
/// Shortest interval (s) before a rest that is retraced.
const INTERVAL_MIN: f64 = 1e-6;

/// Number of steps in the first `retraced` of a plan's chunks.
pub(crate) fn steps_retraced(chunks: &[PlanChunk], retraced: usize) -> usize {
    let ends_step =
        |index: &usize| !is_double(&chunks[*index]) && chunks.get(index + 1).is_none_or(is_double);
    (0..retraced.min(chunks.len())).filter(ends_step).count()
}

/// Whether the robot stands on both feet throughout a chunk.
fn is_double(chunk: &PlanChunk) -> bool {
    chunk.mode == SupportMode::Double as u32
}
