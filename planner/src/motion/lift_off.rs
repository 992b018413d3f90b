//! Lift-off: a swing foot leaves its foothold straight along the sole's normal, or in a random
//! direction where that has failed often.

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_from_scaled_axis;

use crate::base::random::Random;
use crate::collision::model::FootPhase;
use crate::collision::tuning::{SLIDE_CLEAR_MIN, SLIDE_MAX, SLIDE_TURN_MAX};
use crate::constraints::constraints::Constraints;
use crate::constraints::mode::Mode;
use crate::constraints::mode_state::ModeState;
use crate::constraints::rejection::Rejection;
use crate::motion::local_planner::{LocalPath, LocalPlanner, Progress, feasible_state};
use crate::motion::swing_shapes::MotionShape;
use crate::motion::tuning::{ASIDE_DRAWS_MAX, ASIDE_MAX, ASIDE_TURN_MAX, LIFT_HEIGHTS};
use crate::motion::workspace::push;
use crate::robot::configuration::Configuration;

/// A search for a lift-off. In reverse it is a landing.
#[derive(Debug, Clone)]
pub struct LiftOff {
    from: ModeState,
    /// Number of heights tried.
    tried: usize,
    /// The displacement of the sole in its frame, if it does not leave along its normal.
    displacement: Option<Pose>,
    lifted: ModeState,
}

impl LiftOff {
    /// A search from a state with the foot on its foothold.
    pub fn new(from: &ModeState) -> Self {
        Self { from: *from, tried: 0, displacement: None, lifted: *from }
    }

    /// A search in a random direction: aside, and turned, while the sole rises. A direction in
    /// which the sole (its outline, m) would slide over its foothold is drawn again, and the foot
    /// leaves along the normal if that happens often.
    pub fn aside(from: &ModeState, random: &mut Random, outline: &[DVec2]) -> Self {
        let displacement = (0..ASIDE_DRAWS_MAX).find_map(|_| {
            let mut within = |half: f64| random.uniform(-half, half);
            let [x, y] = [within(ASIDE_MAX), within(ASIDE_MAX)];
            let turn =
                DVec3::new(within(ASIDE_TURN_MAX), within(ASIDE_TURN_MAX), within(ASIDE_TURN_MAX));
            let shift = DVec3::new(x, y, random.uniform(LIFT_HEIGHTS[1], LIFT_HEIGHTS[0]));
            is_clear_before_it_slides(shift, turn, outline)
                .then(|| Pose::from_parts(shift, rotation_from_scaled_axis(turn)))
        });
        Self { displacement, ..Self::new(from) }
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
                let is_last = self.tried == LIFT_HEIGHTS.len() || self.displacement.is_some();
                if is_last { Err(rejection) } else { Ok(None) }
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
            let straight = || Pose::from_translation(DVec3::Z * LIFT_HEIGHTS[self.tried]);
            let displacement = self.displacement.unwrap_or_else(straight);
            self.lifted = raised_state(constraints, mode, &self.from, &displacement)?;
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

/// Whether each corner of a sole is clear of its foothold's plane before the sole has moved as far
/// as a foot that touches the world may.
fn is_clear_before_it_slides(shift: DVec3, turn: DVec3, outline: &[DVec2]) -> bool {
    let part = (SLIDE_MAX / shift.length()).min(SLIDE_TURN_MAX / turn.length()).min(1.0);
    outline.iter().all(|corner| {
        let rise = shift.z + turn.cross(corner.extend(0.0)).z;
        part * rise >= SLIDE_CLEAR_MIN
    })
}

/// The state with the swing sole displaced, in its frame.
fn raised_state(
    constraints: &Constraints,
    mode: &Mode,
    state: &ModeState,
    displacement: &Pose,
) -> Result<ModeState, Rejection> {
    let mut raised = *state;
    if let Some(limb) = mode.swing() {
        let sole = &mut raised.world_from_soles[limb];
        *sole = Pose::from_parts(
            sole.translation + sole.rotation * displacement.translation,
            sole.rotation * displacement.rotation,
        );
    }
    feasible_state(constraints, mode, &raised)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::Stream;

    /// A sole of 24 x 10 cm whose frame is at its back.
    const OUTLINE: [DVec2; 4] = [
        DVec2::new(-0.06, -0.05),
        DVec2::new(0.18, -0.05),
        DVec2::new(0.18, 0.05),
        DVec2::new(-0.06, 0.05),
    ];
    /// As the controller has them.
    const TOUCH: f64 = 1e-3;
    const SLIDE: f64 = 6e-3;
    const SLIDE_TURN: f64 = 0.025;

    #[test]
    fn a_foot_that_leaves_aside_does_not_slide() {
        let mut count = 0;
        for index in 0..200 {
            let mut random = Random::new(3, Stream::Transition, 0, index);
            let from = ModeState {
                configuration: Configuration {
                    world_from_root: Pose::IDENTITY,
                    q: [0.0; surefoot_shared_types::base::limits::JOINTS_MAX],
                },
                world_from_soles: [Pose::IDENTITY; 2],
            };
            let lift_off = LiftOff::aside(&from, &mut random, &OUTLINE);
            let Some(displacement) = lift_off.displacement else { continue };
            count += 1;
            let (axis, angle) = displacement.rotation.to_axis_angle();
            let touching = (0..=1000).map(|step| f64::from(step) / 1000.0).take_while(|part| {
                let pose = Pose::from_parts(
                    *part * displacement.translation,
                    rotation_from_scaled_axis(*part * angle * axis),
                );
                OUTLINE.iter().any(|corner| (pose * corner.extend(0.0)).z < TOUCH)
            });
            let part = touching.last().unwrap_or(0.0);
            assert!(part * displacement.translation.length() < SLIDE, "{displacement:?}");
            assert!(part * angle < SLIDE_TURN, "{displacement:?}");
        }
        assert!(count > 150, "{count} of 200 leave aside");
    }
}
