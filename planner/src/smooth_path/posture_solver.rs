//! The configuration at a place of the curve: the centre of mass on it, both soles in place.

use glam::{DMat2, DVec2};
use surefoot_shared_types::Pose;

use crate::constraints::rejection::Rejection;
use crate::robot::configuration::Configuration;
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::Mechanism;
use crate::smooth_path::tuning::{
    COM_ERROR_ACCEPTED, COM_ERROR_MAX, COM_STEPS_MAX, ROOT_SHIFT_FIRST,
};

/// Shortest shift (m) from which the ratio is learned; shorter ones are rounding errors.
const LEARNED_SHIFT_MIN: f64 = 1e-7;

/// Finds the horizontal position of the root that brings the centre of mass to a place (Broyden's
/// method). It keeps the ratio of both shifts from one place to the next.
#[derive(Debug, Clone, Copy)]
pub(crate) struct PostureSolver {
    /// Shift of the root for a shift of the centre of mass.
    root_from_com: DMat2,
}

impl Default for PostureSolver {
    fn default() -> Self {
        Self { root_from_com: DMat2::from_diagonal(DVec2::splat(ROOT_SHIFT_FIRST)) }
    }
}

impl PostureSolver {
    /// Moves the root and the legs of `configuration` so that the centre of mass is at `com` (world
    /// x and y, m) and the soles at their poses. `kinematic_state` becomes that of the result.
    ///
    /// # Errors
    /// A leg does not reach its sole, or the centre of mass does not converge.
    pub fn solve(
        &mut self,
        robot: &Mechanism,
        world_from_soles: &[Pose; 2],
        com: DVec2,
        configuration: &mut Configuration,
        kinematic_state: &mut KinematicState,
    ) -> Result<(), Rejection> {
        let mut last: Option<(DVec2, DVec2)> = None;
        for _ in 0..COM_STEPS_MAX {
            if !robot.place_soles_near(configuration, world_from_soles) {
                return Err(Rejection::Unreachable);
            }
            kinematic_state.update(robot, configuration);
            let error = com - kinematic_state.com.truncate();
            if error.length() <= COM_ERROR_MAX {
                return Ok(());
            }
            if let Some((shift, before)) = last {
                self.learn(shift, before - error);
            }
            let shift = self.root_from_com * error;
            configuration.world_from_root.translation += shift.extend(0.0);
            last = Some((shift, error));
        }
        let is_near = last.is_some_and(|(_, error)| error.length() <= COM_ERROR_ACCEPTED);
        if !is_near {
            *self = Self::default();
            return Err(Rejection::Balance);
        }
        let is_placed = robot.place_soles_near(configuration, world_from_soles);
        kinematic_state.update(robot, configuration);
        is_placed.then_some(()).ok_or(Rejection::Unreachable)
    }

    /// Broyden's update from a shift of the root and the shift of the centre of mass that followed.
    fn learn(&mut self, shift: DVec2, moved: DVec2) {
        let expected = self.root_from_com * moved;
        let denominator = shift.dot(expected);
        if denominator < LEARNED_SHIFT_MIN * LEARNED_SHIFT_MIN {
            return;
        }
        let row = self.root_from_com.transpose() * shift;
        let gain = (shift - expected) / denominator;
        self.root_from_com += DMat2::from_cols(gain * row.x, gain * row.y);
    }
}
