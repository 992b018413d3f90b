//! pi_S: whole steps without search where the sufficient conditions hold [Grey 3.2, 4.4.5].
//!
//! A [`Preparation`](crate::prepare::Preparation) knows the [`Gait`] of a robot and the range R_S of placement pairs over
//! which its primitives were swept. Where [`crate::prepare::sufficient`] says that C_S holds, [`swing`] and [`shift`] emit
//! motions that meet every constraint; [`print_of`] is how a placement is shown to it. They join without a seam, since a
//! primitive configuration depends on nothing but its two placements.

pub mod gait;
pub mod path;
pub mod stand;

pub use gait::Gait;
pub use path::{Place, configuration};

use crate::body::Body;
use crate::collision::FootState;
use crate::constraint::{Constraints, Rejection};
use crate::motion::foothold::Foothold;
use crate::motion::track::State;
use crate::prepare::Print;
use crate::region::Region;
use path::{LANDING, STRETCHES, shift_at};

/// The smallest step along a stretch, as a share of it: less means that a joint would jump.
const STEP_MIN: f64 = 1.0 / 4096.0;
/// The longest way of root or sole between two waypoints, m.
const TRAVEL_MAX: f64 = 0.03;
/// The share of the step limits that the next step is aimed at.
const AIM: f64 = 0.85;
/// A stretch shorter than this (m) is none.
const LENGTH_MIN: f64 = 1e-6;

/// How much of a sole's rim may be unsupported where the sole still counts as whole, m.
const WHOLE_TOLERANCE: f64 = 2e-3;

/// Takes a waypoint and what the swing foot did on the way to it; `false` ends the motion.
pub type Emit<'a> = dyn FnMut(&State, FootState) -> bool + 'a;

/// Emits the swing over `stance` from the primitive configuration on `from` to the one on `to`: the waypoints after the
/// first, the last one included.
///
/// # Errors
/// A leg does not reach or would jump, or `emit` has no room: not where C_S holds.
pub fn swing(
    constraints: &Constraints,
    gait: &Gait,
    stance: &Foothold,
    [from, to]: [&Foothold; 2],
    work: &mut u64,
    emit: &mut Emit<'_>,
) -> Result<(), Rejection> {
    let body = &constraints.body;
    let back = Place::new(body, gait, stance, from, work)?;
    let mut here = back.placed;
    for stretch in (0..STRETCHES).rev().filter(|&stretch| back.length(stretch) > LENGTH_MIN) {
        let end = (stretch == 0).then_some(&back.neutral);
        let at = |t: f64, seed: &State| back.at(stretch, 1.0 - t, seed);
        here = follow(constraints, &here, end, &at, foot_state(stretch), work, emit)?;
    }
    let place = Place::new(body, gait, stance, to, work)?;
    for stretch in (0..STRETCHES).filter(|&stretch| place.length(stretch) > LENGTH_MIN) {
        let end = (stretch == LANDING).then_some(&place.placed);
        let at = |t: f64, seed: &State| place.at(stretch, t, seed);
        here = follow(constraints, &here, end, &at, foot_state(stretch), work, emit)?;
    }
    Ok(())
}

/// Emits the shift of all weight from `from` to `to` between their two primitive configurations.
///
/// # Errors
/// As [`swing`].
pub fn shift(
    constraints: &Constraints,
    gait: &Gait,
    [from, to]: [&Foothold; 2],
    work: &mut u64,
    emit: &mut Emit<'_>,
) -> Result<(), Rejection> {
    let body = &constraints.body;
    let first = configuration(body, gait, from, to, work)?;
    let last = configuration(body, gait, to, from, work)?;
    let at = |t: f64, seed: &State| shift_at(&first.configuration, &last.configuration, t, seed);
    follow(constraints, &first, Some(&last), &at, FootState::Stance, work, emit).map(drop)
}

/// A placement as C_S sees it: whole where its support reaches every corner of the sole.
pub fn print_of(body: &Body, foothold: &Foothold) -> Print {
    let support = Region::hull(foothold.support.iter().copied());
    let corners = &body.sole_polygons[foothold.limb];
    let is_whole = corners.iter().all(|&corner| support.margin(corner) >= -WHOLE_TOLERANCE);
    Print { limb: foothold.limb, world_from_sole: foothold.world_from_sole, is_whole }
}

/// What the swing foot does in a stretch.
pub fn foot_state(stretch: usize) -> FootState {
    if stretch == LANDING { FootState::Leaving } else { FootState::Free }
}

/// Follows a path from `here` in steps as long as the limits allow; answers where it ended.
fn follow(
    constraints: &Constraints,
    here: &State,
    end: Option<&State>,
    at: &dyn Fn(f64, &State) -> State,
    foot: FootState,
    work: &mut u64,
    emit: &mut Emit<'_>,
) -> Result<State, Rejection> {
    let mut here = *here;
    let (mut done, mut step) = (0.0, 0.25);
    while done < 1.0 {
        if step < STEP_MIN {
            return Err(Rejection::Discontinuous);
        }
        *work += 1;
        let ahead: f64 = if done + step > 1.0 - STEP_MIN { 1.0 } else { done + step };
        let next = match end {
            Some(end) if ahead >= 1.0 => *end,
            _ => with_legs(&constraints.body, at(ahead, &here))?,
        };
        let used = step_use(constraints, &here, &next);
        if used <= 1.0 {
            (here, done) = (next, ahead);
            if !emit(&here, foot) {
                return Err(Rejection::Discontinuous);
            }
        }
        step *= (AIM / used.max(1e-3)).clamp(0.1, 2.0);
    }
    Ok(here)
}

/// The state with its legs brought to its soles.
///
/// # Errors
/// A leg does not reach.
pub fn with_legs(body: &Body, mut state: State) -> Result<State, Rejection> {
    let reached = body.place_soles(&mut state.configuration, &state.world_from_soles);
    reached.then_some(state).ok_or(Rejection::Unreachable)
}

/// The largest share of a step limit between two states.
fn step_use(constraints: &Constraints, a: &State, b: &State) -> f64 {
    let joints = a.configuration.q.iter().zip(&b.configuration.q);
    let joint_step = joints.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    let roots = [&a.configuration.world_from_root, &b.configuration.world_from_root];
    let soles = a.world_from_soles.iter().zip(&b.world_from_soles);
    let travel =
        soles.map(|(x, y)| x.translation.distance(y.translation)).fold(roots[0].translation.distance(roots[1].translation), f64::max);
    (joint_step / constraints.config.waypoint_joint_step).max(travel / TRAVEL_MAX)
}
