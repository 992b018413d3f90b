//! Where and how a chunk brakes if the next one is not there, and how the robot goes on from there.
//!
//! The rate of plan time falls along a smooth ramp (`surefoot_shared_types::message::Ramp`) and the
//! robot comes to rest at the chunk's end; the shortest ramp within the limits begins last. A ramp
//! may begin before a short chunk does, but not before the one of the chunk before it: until then
//! the robot does not brake.

use surefoot_shared_types::message::Ramp;

use crate::timing::path_timing::PathTiming;
use crate::timing::tuning::{RAMP_SAMPLES, RAMP_SHORTEST, RAMP_STEP, RAMP_STEPS_MAX};

/// The braking ramp of a chunk, and the ramp with which the robot goes on after it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stop {
    /// The plan time at which the robot begins to brake, s.
    pub brake_at: f64,
    /// How long it brakes, s; 0 for a chunk that ends at rest.
    pub brake_duration: f64,
    /// How long it takes to go on at full speed, s.
    pub resume_duration: f64,
}

impl PathTiming {
    /// The stop at the end (plan time, s) of a chunk whose predecessor brakes at `brake_after` (s; 0
    /// for the first one). `None` if no ramp within the limits begins late enough.
    pub fn stop(&self, brake_after: f64, end: f64) -> Option<Stop> {
        let resume_duration = self.resume_duration(end);
        if self.law().at(end).speed <= REST_SPEED {
            return Some(Stop { brake_at: end, brake_duration: 0.0, resume_duration });
        }
        let longest = 2.0 * (end - brake_after);
        let mut seconds = RAMP_SHORTEST;
        for _ in 0..RAMP_STEPS_MAX {
            let seconds_now = seconds.min(longest);
            let brake_at = end - 0.5 * seconds_now;
            if self.ramp_holds(brake_at, Ramp::Brake { seconds: seconds_now }) {
                return Some(Stop { brake_at, brake_duration: seconds_now, resume_duration });
            }
            if seconds >= longest {
                return None;
            }
            seconds *= RAMP_STEP;
        }
        None
    }

    /// The shortest ramp, in the same steps, by which the robot goes on after a rest at `time`; the
    /// longest one if none is within the limits of the path known so far.
    fn resume_duration(&self, time: f64) -> f64 {
        let mut seconds = RAMP_SHORTEST;
        for _ in 0..RAMP_STEPS_MAX {
            if self.ramp_holds(time, Ramp::Resume { seconds }) {
                return seconds;
            }
            seconds *= RAMP_STEP;
        }
        seconds
    }

    /// Whether a ramp that begins at plan time `begin` (s) is within the limits.
    fn ramp_holds(&self, begin: f64, ramp: Ramp) -> bool {
        (0..=RAMP_SAMPLES).all(|sample| {
            let at = ramp.at(ramp.seconds() * sample as f64 / RAMP_SAMPLES as f64);
            let time = (begin + at.elapsed).min(self.law().end());
            self.share_at(time, at.rate, at.rate_change) <= 1.0
        })
    }
}

/// Speed along the path below which it rests.
const REST_SPEED: f64 = 1e-9;
