//! How a swing foot leaves its placement: straight along the sole's normal, as high as there is
//! room.

use glam::DVec3;
use surefoot_shared_types::Pose;

use crate::body::Configuration;
use crate::collision::FootState;
use crate::constraint::{Constraints, Mode, Rejection};
use crate::motion::swing::Travel;
use crate::motion::track::{Follower, Progress, State, Stretch, place_at};
use crate::motion::workspace::push;

/// How high a swing foot is lifted off its placement before it may travel, along the sole's normal,
/// m; tried in order.
const HEIGHTS: [f64; 2] = [0.02, 0.012];

/// A search for a lift. The motion is the same backwards, so it serves to land as well.
#[derive(Debug, Clone)]
pub struct Lift {
    from: State,
    tried: usize,
    lifted: State,
}

impl Lift {
    /// Begins with the foot on its placement.
    pub fn new(from: &State) -> Self {
        Self { from: *from, tried: 0, lifted: *from }
    }

    /// Spends one unit of work; answers the state with the foot lifted once that is reached:
    /// `waypoints` then holds the way there.
    ///
    /// # Errors
    /// What stops the last lift.
    pub fn advance(
        &mut self,
        constraints: &Constraints,
        mode: &Mode,
        follower: &mut Follower,
        waypoints: &mut Vec<Configuration>,
    ) -> Result<Option<State>, Rejection> {
        match self.attempt(constraints, mode, follower, waypoints) {
            Ok(false) => Ok(None),
            Ok(true) => {
                follower.stop();
                Ok(Some(self.lifted))
            }
            Err(why) => {
                follower.stop();
                self.tried += 1;
                if self.tried < HEIGHTS.len() { Ok(None) } else { Err(why) }
            }
        }
    }

    fn attempt(
        &mut self,
        constraints: &Constraints,
        mode: &Mode,
        follower: &mut Follower,
        waypoints: &mut Vec<Configuration>,
    ) -> Result<bool, Rejection> {
        if !follower.is_under_way() {
            waypoints.clear();
            self.lifted = lifted(constraints, mode, &self.from, HEIGHTS[self.tried])?;
            let stretch = Stretch {
                from: self.from,
                to: self.lifted,
                exact: true,
                travel: Travel::STRAIGHT,
                swing_foot: FootState::Leaving,
            };
            follower.begin(constraints, &stretch);
            return Ok(false);
        }
        let progress = follower.advance(constraints, mode)?;
        if progress != Progress::Nearer {
            push(waypoints, follower.here().configuration)?;
        }
        Ok(progress == Progress::Arrived)
    }
}

/// A state with the swing sole raised along its normal.
fn lifted(
    constraints: &Constraints,
    mode: &Mode,
    state: &State,
    height: f64,
) -> Result<State, Rejection> {
    let mut raised = *state;
    if let Some(limb) = mode.swing() {
        let sole = &mut raised.world_from_soles[limb];
        *sole =
            Pose::from_parts(sole.translation + sole.rotation * (DVec3::Z * height), sole.rotation);
    }
    place_at(constraints, mode, &raised)
}
