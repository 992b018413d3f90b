//! The states of a primitive [Grey 3.2, 4.4.5]. Where C_S holds
//! ([`sufficient`](crate::preparation::sufficient)), a
//! [`PrimitiveTrajectory`](crate::primitives::PrimitiveTrajectory) meets every constraint.

use crate::collision::model::FootPhase;
use crate::constraints::mode_state::ModeState;
use crate::constraints::rejection::Rejection;
use crate::primitives::step_path::LANDING;
use crate::robot::mechanism::Mechanism;

/// The swing foot's phase in a section of a half swing.
pub fn foot_phase(section: usize) -> FootPhase {
    if section == LANDING { FootPhase::LiftOff } else { FootPhase::Swing }
}

/// The state with its legs solved for its soles.
///
/// # Errors
/// A leg does not reach.
pub fn with_legs(robot: &Mechanism, mut state: ModeState) -> Result<ModeState, Rejection> {
    let reached = robot.place_soles(&mut state.configuration, &state.world_from_soles);
    reached.then_some(state).ok_or(Rejection::Unreachable)
}
