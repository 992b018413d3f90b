//! A primitive as it is emitted, waypoint by waypoint.

use super::gait::Gait;
use super::path::{LANDING, Place, STRETCHES, configuration, shift_at};
use super::{foot_state, with_legs};
use crate::collision::FootState;
use crate::constraint::{Constraints, Rejection};
use crate::motion::foothold::Foothold;
use crate::motion::track::State;

/// The first step along a stretch that is tried, as a share of it.
const STEP_FIRST: f64 = 0.25;
/// The smallest step along a stretch, as a share of it: less means that a joint would jump.
const STEP_MIN: f64 = 1.0 / 4096.0;
/// The longest way of root or sole between two waypoints, m.
const TRAVEL_MAX: f64 = 0.04;
/// The share of the step limits that the next step is aimed at.
const AIM: f64 = 0.95;
/// A stretch shorter than this (m) is none.
const LENGTH_MIN: f64 = 1e-6;

/// The emission of one primitive. Ends that are joined hold the very same configurations.
#[derive(Debug, Clone)]
pub struct Emission {
    course: Course,
    ends: [State; 2],
    here: State,
    /// The stretch that is followed, of all that the course has.
    stretch: usize,
    /// The share of it that is done, and the step to try next.
    done: f64,
    step: f64,
}

#[derive(Debug, Clone)]
#[allow(clippy::large_enum_variant, reason = "a box would allocate during the search")]
enum Course {
    /// A place backwards, then a place.
    Swing { back: Place, place: Place },
    /// From one end to the other.
    Shift,
}

impl Emission {
    /// The swing over `stance` from the primitive configuration on `from` to the one on `to`.
    ///
    /// # Errors
    /// A leg does not reach: not where C_S holds.
    pub fn swing(
        constraints: &Constraints,
        gait: &Gait,
        stance: &Foothold,
        [from, to]: [&Foothold; 2],
    ) -> Result<Self, Rejection> {
        let back = Place::new(&constraints.body, gait, stance, from)?;
        let place = back.onto(&constraints.body, gait, stance, to)?;
        let ends = [back.placed, place.placed];
        Ok(Self::begin(Course::Swing { back, place }, ends))
    }

    /// The shift of all weight from `from` to `to` between their two primitive configurations.
    ///
    /// # Errors
    /// As [`Emission::swing`].
    pub fn shift(
        constraints: &Constraints,
        gait: &Gait,
        [from, to]: [&Foothold; 2],
    ) -> Result<Self, Rejection> {
        let first = configuration(&constraints.body, gait, from, to)?;
        let last = configuration(&constraints.body, gait, to, from)?;
        Ok(Self::begin(Course::Shift, [first, last]))
    }

    fn begin(course: Course, ends: [State; 2]) -> Self {
        let mut emission =
            Self { course, here: ends[0], ends, stretch: 0, done: 0.0, step: STEP_FIRST };
        emission.skip_empty();
        emission
    }

    /// The configurations at both ends.
    pub fn ends(&self) -> &[State; 2] {
        &self.ends
    }

    /// Whether the last waypoint was emitted.
    pub fn is_over(&self) -> bool {
        self.stretch == self.stretches()
    }

    /// Tries one step; answers the next waypoint and what the swing foot does on the way to it, or
    /// `None` where the step was too long and a shorter one is to be tried. To be called until it
    /// is over.
    ///
    /// # Errors
    /// A leg does not reach or would jump: not where C_S holds.
    pub fn advance(
        &mut self,
        constraints: &Constraints,
    ) -> Result<Option<(&State, FootState)>, Rejection> {
        if self.step < STEP_MIN {
            return Err(Rejection::Discontinuous);
        }
        let ahead =
            if self.done + self.step > 1.0 - STEP_MIN { 1.0 } else { self.done + self.step };
        let (wished, foot) = self.at(ahead);
        let next = match self.exact_end() {
            Some(end) if ahead >= 1.0 => *end,
            _ => with_legs(&constraints.body, wished)?,
        };
        let used = step_use(constraints, &self.here, &next);
        self.step *= (AIM / used.max(1e-3)).clamp(0.1, 2.0);
        if used > 1.0 {
            return Ok(None);
        }
        (self.here, self.done) = (next, ahead);
        if ahead >= 1.0 {
            (self.stretch, self.done, self.step) = (self.stretch + 1, 0.0, STEP_FIRST);
            self.skip_empty();
        }
        Ok(Some((&self.here, foot)))
    }

    fn stretches(&self) -> usize {
        match self.course {
            Course::Swing { .. } => 2 * STRETCHES,
            Course::Shift => 1,
        }
    }

    fn skip_empty(&mut self) {
        while let Course::Swing { back, place } = &self.course
            && self.stretch < 2 * STRETCHES
            && length(back, place, self.stretch) <= LENGTH_MIN
        {
            self.stretch += 1;
        }
    }

    /// The state a share of the way along the stretch, legs not yet brought to their soles, and
    /// what the swing foot does.
    fn at(&self, t: f64) -> (State, FootState) {
        match &self.course {
            Course::Shift => (
                shift_at(&self.ends[0].configuration, &self.ends[1].configuration, t, &self.here),
                FootState::Stance,
            ),
            Course::Swing { back, .. } if self.stretch < STRETCHES => {
                let stretch = STRETCHES - 1 - self.stretch;
                (back.at(stretch, 1.0 - t, &self.here), foot_state(stretch))
            }
            Course::Swing { place, .. } => {
                let stretch = self.stretch - STRETCHES;
                (place.at(stretch, t, &self.here), foot_state(stretch))
            }
        }
    }

    /// The configuration with which the stretch ends, where it is a known one.
    fn exact_end(&self) -> Option<&State> {
        match &self.course {
            Course::Shift => Some(&self.ends[1]),
            Course::Swing { back, .. } if self.stretch == STRETCHES - 1 => Some(&back.neutral),
            Course::Swing { .. } => (self.stretch == STRETCHES + LANDING).then_some(&self.ends[1]),
        }
    }
}

/// How far the swing sole travels in a stretch of a swing, m.
fn length(back: &Place, place: &Place, stretch: usize) -> f64 {
    if stretch < STRETCHES {
        back.length(STRETCHES - 1 - stretch)
    } else {
        place.length(stretch - STRETCHES)
    }
}

/// The largest share of a step limit between two states.
fn step_use(constraints: &Constraints, a: &State, b: &State) -> f64 {
    let joints = a.configuration.q.iter().zip(&b.configuration.q);
    let joint_step = joints.map(|(x, y)| (x - y).abs()).fold(0.0, f64::max);
    let [from, to] = [a, b].map(|state| state.configuration.world_from_root.translation);
    let soles = a.world_from_soles.iter().zip(&b.world_from_soles);
    let travel =
        soles.map(|(x, y)| x.translation.distance(y.translation)).fold(from.distance(to), f64::max);
    (joint_step / constraints.config.waypoint_joint_step).max(travel / TRAVEL_MAX)
}
