//! pi_S: whole steps without search where the sufficient conditions hold [Grey 3.2, 4.4.5].
//!
//! A [`Preparation`](crate::preparation::build::Preparation) knows the [`Gait`] of a robot and the
//! range R_S of placement pairs over which its primitives were swept. Where
//! [`crate::preparation::sufficient`] says that C_S holds, [`PrimitiveTrajectory`] gives motions
//! that meet every constraint; [`placement_of`] is how a placement is shown to it. They join
//! without a seam, since a primitive configuration depends on nothing but its two placements.

use crate::collision::model::FootPhase;
use crate::constraints::foothold::{FootPlacement, Foothold, is_whole};
use crate::constraints::mode_state::ModeState;
use crate::constraints::rejection::Rejection;
use crate::primitives::step_path::LANDING;
use crate::robot::mechanism::Mechanism;

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
