//! pi_S: whole steps without search where the sufficient conditions hold [Grey 3.2, 4.4.5].
//!
//! A [`Preparation`](crate::prepare::Preparation) knows the [`Gait`] of a robot and the range R_S
//! of placement pairs over which its primitives were swept. Where [`crate::prepare::sufficient`]
//! says that C_S holds, [`PrimitiveTrajectory`] gives motions that meet every constraint;
//! [`placement_of`] is how a placement is shown to it. They join without a seam, since a primitive
//! configuration depends on nothing but its two placements.

pub mod emission;
pub mod gait;
pub mod path;
pub mod stand;

pub use emission::PrimitiveTrajectory;
pub use gait::Gait;
pub use path::{HalfSwing, configuration};

use crate::body::Mechanism;
use crate::collision::FootPhase;
use crate::constraint::Rejection;
use crate::motion::foothold::Foothold;
use crate::motion::track::ModeState;
use crate::prepare::{FootPlacement, is_whole};
use path::LANDING;

/// A placement as C_S sees it.
pub fn placement_of(robot: &Mechanism, foothold: &Foothold) -> FootPlacement {
    let is_whole = is_whole(robot, foothold.limb, &foothold.support);
    FootPlacement { limb: foothold.limb, world_from_sole: foothold.world_from_sole, is_whole }
}

/// What the swing foot does in a section.
pub fn foot_phase(section: usize) -> FootPhase {
    if section == LANDING { FootPhase::LiftOff } else { FootPhase::Swing }
}

/// The state with its legs brought to its soles.
///
/// # Errors
/// A leg does not reach.
pub fn with_legs(robot: &Mechanism, mut state: ModeState) -> Result<ModeState, Rejection> {
    let reached = robot.place_soles(&mut state.configuration, &state.world_from_soles);
    reached.then_some(state).ok_or(Rejection::Unreachable)
}
