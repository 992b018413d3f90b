//! pi_S: whole steps without search where the sufficient conditions hold [Grey 3.2, 4.4.5].
//!
//! A [`Preparation`](crate::prepare::Preparation) knows the [`Gait`] of a robot and the range R_S
//! of placement pairs over which its primitives were swept. Where [`crate::prepare::sufficient`]
//! says that C_S holds, [`Emission`] gives motions that meet every constraint; [`print_of`] is how
//! a placement is shown to it. They join without a seam, since a primitive configuration depends on
//! nothing but its two placements.

pub mod emission;
pub mod gait;
pub mod path;
pub mod stand;

pub use emission::Emission;
pub use gait::Gait;
pub use path::{Place, configuration};

use crate::body::Body;
use crate::collision::FootState;
use crate::constraint::Rejection;
use crate::motion::foothold::Foothold;
use crate::motion::track::State;
use crate::prepare::{Print, is_whole};
use path::LANDING;

/// A placement as C_S sees it.
pub fn print_of(body: &Body, foothold: &Foothold) -> Print {
    let is_whole = is_whole(body, foothold.limb, &foothold.support);
    Print { limb: foothold.limb, world_from_sole: foothold.world_from_sole, is_whole }
}

/// What the swing foot does in a stretch.
pub fn foot_state(stretch: usize) -> FootState {
    if stretch == LANDING { FootState::Leaving } else { FootState::Free }
}

/// The state with its legs brought to its soles.
///
/// # Errors
/// A leg does not reach.
pub fn with_legs(body: &Body, mut state: State) -> Result<State, Rejection> {
    let reached = body.place_soles(&mut state.configuration, &state.world_from_soles);
    reached.then_some(state).ok_or(Rejection::Unreachable)
}
