//! Lift-off: a swing foot leaves its foothold straight along the sole's normal.

use glam::DVec3;
use surefoot_shared_types::Pose;

use crate::collision::model::FootPhase;
use crate::constraints::constraints::Constraints;
use crate::constraints::mode::Mode;
use crate::constraints::mode_state::ModeState;
use crate::constraints::rejection::Rejection;
use crate::motion::local_planner::{LocalPath, LocalPlanner, Progress, feasible_state};
use crate::motion::swing_shapes::MotionShape;
use crate::motion::tuning::LIFT_HEIGHTS;
use crate::motion::workspace::push;
use crate::robot::configuration::Configuration;

/// A search for a lift-off. In reverse it is a landing.
#[derive(Debug, Clone)]
pub struct LiftOff {
    from: ModeState,
    /// Number of heights tried.
    tried: usize,
    lifted: ModeState,
}

impl LiftOff {
    /// A search from a state with the foot on its foothold.
    pub fn new(from: &ModeState) -> Self {
        Self { from: *from, tried: 0, lifted: *from }
    }

    /// Spends one work unit. Returns the state with the foot lifted once it is reached; `waypoints`
    /// then holds the path after the first state.
    ///
    /// # Errors
    /// The rejection at the last height tried.
    pub fn advance(
        &mut self,
        constraints: &Constraints,
        mode: &Mode,
        local_planner: &mut LocalPlanner,
        waypoints: &mut Vec<Configuration>,
    ) -> Result<Option<ModeState>, Rejection> {
        match self.attempt(constraints, mode, local_planner, waypoints) {
            Ok(false) => Ok(None),
            Ok(true) => {
                local_planner.stop();
                Ok(Some(self.lifted))
            }
            Err(rejection) => {
                local_planner.stop();
                self.tried += 1;
                if self.tried < LIFT_HEIGHTS.len() { Ok(None) } else { Err(rejection) }
            }
        }
    }

    /// Spends one work unit at the current height. Returns whether the lifted state is reached.
    fn attempt(
        &mut self,
        constraints: &Constraints,
        mode: &Mode,
        local_planner: &mut LocalPlanner,
        waypoints: &mut Vec<Configuration>,
    ) -> Result<bool, Rejection> {
        if !local_planner.is_active() {
            waypoints.clear();
            self.lifted = raised_state(constraints, mode, &self.from, LIFT_HEIGHTS[self.tried])?;
            let local_path = LocalPath {
                from: self.from,
                to: self.lifted,
                exact: true,
                shape: MotionShape::STRAIGHT,
                swing_foot: FootPhase::LiftOff,
            };
            local_planner.begin(constraints, &local_path);
            return Ok(false);
        }
        let progress = local_planner.advance(constraints, mode)?;
        if progress != Progress::ShorterStep {
            push(waypoints, local_planner.state().configuration)?;
        }
        Ok(progress == Progress::Reached)
    }
}

/// The state with the swing sole raised along its normal by `height`, m.
fn raised_state(
    constraints: &Constraints,
    mode: &Mode,
    state: &ModeState,
    height: f64,
) -> Result<ModeState, Rejection> {
    let mut raised = *state;
    if let Some(limb) = mode.swing() {
        let sole = &mut raised.world_from_soles[limb];
        *sole =
            Pose::from_parts(sole.translation + sole.rotation * (DVec3::Z * height), sole.rotation);
    }
    feasible_state(constraints, mode, &raised)
}
