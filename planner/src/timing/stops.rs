//! Where and how a chunk brakes if the next one is not there, and how the robot goes on from there.
//!
//! The rate of plan time falls along a smooth ramp (`surefoot_shared_types::message::Ramp`) and the
//! robot comes to rest at the chunk's end; the shortest ramp within the limits begins last. A ramp
//! may begin before a short chunk does, but not before the one of the chunk before it: until then
//! the robot does not brake.

use surefoot_shared_types::message::Ramp;

use crate::timing::path_timing::PathTiming;
use crate::timing::tuning::{
    CHUNKS_AHEAD, RAMP_SAMPLES, RAMP_SHORTEST, RAMP_STEP, RAMP_STEPS_MAX, REST_PLACES,
};

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
    /// The stop of a chunk of a span whose predecessor brakes at `brake_after` (plan time, s; 0 for
    /// the first one): of the stops within the limits that end inside the chunk, the one that
    /// begins last but not after that of the chunks that follow. `None` if there is none.
    pub fn stop(&self, span: usize, chunk: usize, brake_after: f64) -> Option<Stop> {
        let mut following = [(span, chunk); CHUNKS_AHEAD + 1];
        let mut count = 1;
        while count <= CHUNKS_AHEAD {
            let Some(next) = self.chunk_after(following[count - 1]) else { break };
            following[count] = next;
            count += 1;
        }
        let mut latest = f64::INFINITY;
        for &(span, chunk) in following[1..count].iter().rev() {
            let times = self.span_times(span).chunk_times(chunk);
            latest = self.brake([0.0, latest], times).map_or(latest, |(brake_at, _)| brake_at);
        }
        let times = self.span_times(span).chunk_times(chunk);
        let (brake_at, brake_duration) = self.brake([brake_after, latest], times)?;
        let resume_duration = self.resume_duration(brake_at + 0.5 * brake_duration);
        Some(Stop { brake_at, brake_duration, resume_duration })
    }

    /// The span and the chunk after a chunk.
    fn chunk_after(&self, (span, chunk): (usize, usize)) -> Option<(usize, usize)> {
        if chunk + 1 < self.span_times(span).chunks() {
            return Some((span, chunk + 1));
        }
        (span + 1 < self.spans()).then_some((span + 1, 0))
    }

    /// Beginning and duration (s) of the latest ramp within the limits that begins between these
    /// times and ends between `begin` and `end`.
    fn brake(&self, [after, before]: [f64; 2], [begin, end]: [f64; 2]) -> Option<(f64, f64)> {
        if self.law().at(end).speed <= REST_SPEED {
            return Some((end, 0.0));
        }
        let mut best: Option<(f64, f64)> = None;
        for part in 0..REST_PLACES {
            let rest = end - (end - begin) * part as f64 / REST_PLACES as f64;
            let mut seconds = RAMP_SHORTEST.max(2.0 * (rest - before));
            for _ in 0..RAMP_STEPS_MAX {
                let brake_at = rest - 0.5 * seconds;
                if brake_at < after || best.is_some_and(|(latest, _)| brake_at <= latest) {
                    break;
                }
                if self.ramp_holds(brake_at, Ramp::Brake { seconds }) {
                    best = Some((brake_at, seconds));
                    break;
                }
                seconds *= RAMP_STEP;
            }
        }
        best
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

    /// Whether a ramp that begins at plan time `begin` (s) takes no more of the rates around than
    /// they allow, or than the motion at full speed takes.
    fn ramp_holds(&self, begin: f64, ramp: Ramp) -> bool {
        (0..=RAMP_SAMPLES).all(|sample| {
            let at = ramp.at(ramp.seconds() * sample as f64 / RAMP_SAMPLES as f64);
            let time = (begin + at.elapsed).min(self.law().end());
            let share = self.share_at(time, at.rate, at.rate_change);
            share <= 1.0 || share <= self.share_at(time, 1.0, 0.0)
        })
    }
}

/// Speed along the path below which it rests.
const REST_SPEED: f64 = 1e-9;
