//! The time of a plan while its chunks come late: the robot walks at full speed, brakes along its
//! path, stands, and goes on.

use surefoot_shared_types::message::PlanChunk;
use surefoot_shared_types::message::chunk::FLAG_LAST;

use crate::check::course::{PlanRate, Stop};

/// The time of the plan that a robot walks, and how fast it passes.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanClock {
    pace: Pace,
    /// The stops of the accepted chunks.
    stops: Vec<Stop>,
    /// The end of the plan (s), once its last chunk is accepted.
    end: Option<f64>,
}

/// How plan time passes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Pace {
    /// At full speed, at a plan time (s).
    Walking(f64),
    /// The robot brakes for a time (s) as the stop of a chunk says.
    Braking(usize, f64),
    /// The robot stands where it has braked for a chunk.
    AtRest(usize),
    /// The robot has been going on for a time (s) after the stop of a chunk.
    GoingOn(usize, f64),
}

/// Plan time at an instant.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanInstant {
    /// Plan time, s.
    pub time: f64,
    /// Seconds of the plan a second, 0 to 1.
    pub rate: f64,
    /// The change of the rate, 1/s.
    pub rate_change: f64,
}

impl PlanClock {
    /// A robot that stands at the beginning (s) of a plan, of which it has no chunk.
    pub fn new(begin: f64) -> Self {
        let start = Stop { brake_at: begin, seconds: 0.0, resume_seconds: 0.0 };
        Self { pace: Pace::AtRest(0), stops: vec![start], end: None }
    }

    /// The robot has accepted the next chunk.
    pub fn accept(&mut self, chunk: &PlanChunk) {
        self.stops.push(Stop::of_chunk(chunk));
        if chunk.flags & FLAG_LAST != 0 {
            self.end = chunk.waypoints().last().map(|last| last.time);
        }
    }

    /// How plan time passes.
    pub fn pace(&self) -> Pace {
        self.pace
    }

    /// Whether the robot has arrived at the end of the plan.
    pub fn is_finished(&self) -> bool {
        self.end.is_some_and(|end| self.now().time >= end)
    }

    /// Plan time at this instant. A plan rests at its end.
    pub fn now(&self) -> PlanInstant {
        let still = |time: f64| PlanInstant { time, rate: 0.0, rate_change: 0.0 };
        let on_ramp = |begin: f64, after: f64, seconds: f64, brakes: bool| {
            let ramp = PlanRate::of_ramp(after / seconds, seconds, brakes);
            PlanInstant { time: begin + ramp.elapsed, rate: ramp.rate, rate_change: ramp.change }
        };
        let instant = match self.pace {
            Pace::Walking(time) => PlanInstant { time, rate: 1.0, rate_change: 0.0 },
            Pace::AtRest(chunk) => still(self.stops[chunk].rest_at()),
            Pace::Braking(chunk, after) => {
                let stop = &self.stops[chunk];
                on_ramp(stop.brake_at, after, stop.seconds, true)
            }
            Pace::GoingOn(chunk, after) => {
                let stop = &self.stops[chunk];
                on_ramp(stop.rest_at(), after, stop.resume_seconds, false)
            }
        };
        self.end.filter(|end| instant.time >= *end).map_or(instant, still)
    }

    /// Lets `seconds` pass.
    pub fn advance(&mut self, seconds: f64) {
        let mut left = seconds;
        // Each change of pace takes a part of the time; a stop without ramps takes none.
        for _ in 0..=2 * self.stops.len() {
            let (next, used) = self.next_pace(left);
            let is_over = used >= left;
            (self.pace, left) = (next, left - used);
            if is_over || matches!(self.pace, Pace::AtRest(_)) && !self.may_go_on() {
                return;
            }
        }
    }

    /// The pace after at most `left` s, and the time that this takes.
    fn next_pace(&self, left: f64) -> (Pace, f64) {
        let last = self.stops.len() - 1;
        match self.pace {
            Pace::Walking(time) => {
                let brakes = (self.end.is_none()).then_some(self.stops[last].brake_at);
                let until = brakes.map_or(left, |at| (at - time).max(0.0));
                if until >= left {
                    return (Pace::Walking(time + left), left);
                }
                (self.braking(last, 0.0), until)
            }
            Pace::Braking(chunk, after) => {
                let until = self.stops[chunk].seconds - after;
                if until > left {
                    return (Pace::Braking(chunk, after + left), left);
                }
                (Pace::AtRest(chunk), until)
            }
            Pace::AtRest(chunk) if self.may_go_on() => (self.going_on(chunk, 0.0), 0.0),
            Pace::AtRest(chunk) => (Pace::AtRest(chunk), left),
            Pace::GoingOn(chunk, after) => {
                let stop = &self.stops[chunk];
                let until = stop.resume_seconds - after;
                if until > left {
                    return (Pace::GoingOn(chunk, after + left), left);
                }
                (Pace::Walking(stop.rest_at() + 0.5 * stop.resume_seconds), until)
            }
        }
    }

    fn braking(&self, chunk: usize, after: f64) -> Pace {
        let has_ramp = self.stops[chunk].seconds > 0.0;
        if has_ramp { Pace::Braking(chunk, after) } else { Pace::AtRest(chunk) }
    }

    fn going_on(&self, chunk: usize, after: f64) -> Pace {
        let stop = &self.stops[chunk];
        let has_ramp = stop.resume_seconds > 0.0;
        if has_ramp { Pace::GoingOn(chunk, after) } else { Pace::Walking(stop.rest_at()) }
    }

    /// Whether a robot at rest is at full speed again before it may have to brake: a stop begins
    /// at full speed.
    fn may_go_on(&self) -> bool {
        let Pace::AtRest(chunk) = self.pace else { return false };
        let (stop, last) = (&self.stops[chunk], self.stops.len() - 1);
        let full_speed = stop.rest_at() + 0.5 * stop.resume_seconds;
        let has_way = last > chunk && full_speed <= self.stops[last].brake_at;
        has_way || self.end.is_some_and(|end| stop.rest_at() < end)
    }
}
