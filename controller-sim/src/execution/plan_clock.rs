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
    /// Time since the robot has waited for the plan, s.
    seconds: f64,
    history: Vec<PaceChange>,
    counts: StopCounts,
}

/// How often a robot had to stop for want of a chunk.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct StopCounts {
    /// How often it began to brake, or had to stay at a rest of the plan.
    pub brakes: u64,
    /// How long it stood, s.
    pub stood: f64,
}

impl StopCounts {
    /// Those of two plans together.
    pub fn plus(self, other: Self) -> Self {
        Self { brakes: self.brakes + other.brakes, stood: self.stood + other.stood }
    }
}

/// A change of pace.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PaceChange {
    /// When it took place, s since the robot has waited for the plan.
    pub at: f64,
    /// The pace from there on, at its beginning.
    pub pace: Pace,
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
        let pace = Pace::AtRest(0);
        Self {
            pace,
            stops: vec![start],
            end: None,
            seconds: 0.0,
            history: vec![PaceChange { at: 0.0, pace }],
            counts: StopCounts::default(),
        }
    }

    /// A robot that stands at the beginning of a chunk, of whose plan it has no chunk.
    pub(crate) fn before(chunk: &PlanChunk) -> Option<Self> {
        let mut clock = Self::new(chunk.waypoints().first()?.time);
        clock.stops = vec![clock.stops[0]; usize::try_from(chunk.sequence).ok()? + 1];
        Some(clock)
    }

    /// A robot that has accepted `chunks`, consecutive ones of a plan, and passes them at this
    /// pace; nothing if it would be outside of them.
    pub(crate) fn at(chunks: &[PlanChunk], pace: Pace) -> Option<Self> {
        let first = chunks.first()?;
        let mut clock = Self::before(first)?;
        let before = clock.stops.len();
        chunks.iter().for_each(|chunk| clock.accept(chunk));
        let stop = |index: usize| {
            let is_known = (before..clock.stops.len()).contains(&index);
            clock.stops.get(index).filter(|_| is_known || index == 0 && before == 1)
        };
        let is_known = match pace {
            Pace::Walking(_) => true,
            Pace::AtRest(index) => stop(index).is_some(),
            Pace::Braking(index, after) => stop(index).is_some_and(|stop| after <= stop.seconds),
            Pace::GoingOn(index, after) => {
                stop(index).is_some_and(|stop| after <= stop.resume_seconds)
            }
        };
        if !is_known {
            return None;
        }
        (clock.pace, clock.history) = (pace, vec![PaceChange { at: 0.0, pace }]);
        let end = chunks.last()?.waypoints().last()?.time;
        (first.waypoints()[0].time..=end).contains(&clock.now().time).then_some(clock)
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

    /// The changes of pace so far, in their order; the first one is the wait for the plan.
    pub fn history(&self) -> &[PaceChange] {
        &self.history
    }

    /// The stops of the accepted chunks, by the index that a [`Pace`] names; the first one is the
    /// beginning of the plan.
    pub fn stops(&self) -> &[Stop] {
        &self.stops
    }

    /// Time since the robot has waited for the plan, s.
    pub fn seconds(&self) -> f64 {
        self.seconds
    }

    /// The stops so far.
    pub fn counts(&self) -> StopCounts {
        self.counts
    }

    /// Whether the robot stands and stays there without a further chunk.
    pub fn is_at_rest(&self) -> bool {
        self.is_finished() || matches!(self.pace, Pace::AtRest(_)) && !self.may_go_on()
    }

    /// How long the robot walks from here at most before it has to brake for want of a chunk, s;
    /// no limit once the last chunk of the plan is accepted.
    pub fn seconds_to_brake(&self) -> f64 {
        if self.end.is_some() {
            return f64::INFINITY;
        }
        let brake_at = self.stops[self.stops.len() - 1].brake_at;
        let after_ramp = |chunk: usize, after: f64| {
            let stop = &self.stops[chunk];
            stop.resume_seconds - after + brake_at - (stop.rest_at() + 0.5 * stop.resume_seconds)
        };
        match self.pace {
            Pace::Walking(time) => (brake_at - time).max(0.0),
            Pace::GoingOn(chunk, after) => after_ramp(chunk, after).max(0.0),
            Pace::AtRest(chunk) if self.may_go_on() => after_ramp(chunk, 0.0),
            Pace::AtRest(_) | Pace::Braking(..) => 0.0,
        }
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
        for _ in 0..=4 * self.stops.len() {
            let (next, used) = self.next_pace(left);
            let (before, is_over) = (self.pace, used >= left);
            if matches!(before, Pace::AtRest(chunk) if chunk > 0) {
                self.counts.stood += used;
            }
            (self.pace, self.seconds, left) = (next, self.seconds + used, left - used);
            self.record_change(before);
            if is_over {
                return;
            }
        }
    }

    /// Records a change from the pace before.
    fn record_change(&mut self, before: Pace) {
        let stands = |pace: Pace| matches!(pace, Pace::Braking(..) | Pace::AtRest(_));
        if std::mem::discriminant(&before) == std::mem::discriminant(&self.pace) {
            return;
        }
        self.counts.brakes += u64::from(!stands(before) && stands(self.pace));
        self.history.push(PaceChange { at: self.seconds, pace: self.pace });
    }

    /// The pace after at most `left` s, and the time that this takes.
    fn next_pace(&self, left: f64) -> (Pace, f64) {
        let last = self.stops.len() - 1;
        match self.pace {
            Pace::Walking(time) => {
                if let Some(end) = self.end {
                    return (Pace::Walking((time + left).min(end)), left);
                }
                let until = (self.stops[last].brake_at - time).max(0.0);
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
