//! How a swing foot leaves its placement: straight along the sole's normal, as high as there is
//! room.

use glam::DVec3;
use surefoot_shared_types::Pose;

use crate::collision::model::FootPhase;
use crate::constraints::constraints::Constraints;
use crate::constraints::mode::Mode;
use crate::constraints::mode_state::ModeState;
use crate::constraints::rejection::Rejection;
use crate::motion::local_planner::{LocalPath, LocalPlanner, Progress, feasible_state};
use crate::motion::swing_shapes::MotionShape;
use crate::motion::workspace::push;
use crate::robot::configuration::Configuration;

/// How high a swing foot is lifted off its placement before it may travel, along the sole's normal,
/// m; tried in order.
const HEIGHTS: [f64; 2] = [0.02, 0.012];

/// A search for a lift-off. The motion is the same backwards, so it serves to land as well.
#[derive(Debug, Clone)]
pub struct LiftOff {
    from: ModeState,
    tried: usize,
    lifted: ModeState,
}

impl LiftOff {
    /// Begins with the foot on its placement.
    pub fn new(from: &ModeState) -> Self {
        Self { from: *from, tried: 0, lifted: *from }
    }

    /// Spends one unit of work; answers the state with the foot lifted once that is reached:
    /// `waypoints` then holds the way there.
    ///
    /// # Errors
    /// What stops the last lift-off.
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
                if self.tried < HEIGHTS.len() { Ok(None) } else { Err(rejection) }
            }
        }
    }

    fn attempt(
        &mut self,
        constraints: &Constraints,
        mode: &Mode,
        local_planner: &mut LocalPlanner,
        waypoints: &mut Vec<Configuration>,
    ) -> Result<bool, Rejection> {
        if !local_planner.is_active() {
            waypoints.clear();
            self.lifted = raised_state(constraints, mode, &self.from, HEIGHTS[self.tried])?;
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
            push(waypoints, local_planner.here().configuration)?;
        }
        Ok(progress == Progress::Reached)
    }
}

/// A state with the swing sole raised along its normal.
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
