//! A robot that walks accepted chunks in its own time: it brakes along its path where the next
//! chunk is not there, stands, and goes on.

use std::collections::VecDeque;

use bytemuck::Zeroable;
use surefoot_shared_types::message::{PlanChunk, RecordedPace, WalkRecord, Waypoint};

use crate::check::course::at_rate;
use crate::execution::executed_motion::{ExecutedMotion, PlanWalk};
use crate::execution::plan_clock::{Pace, PlanClock, StopCounts};
use crate::execution::plan_motion::planned_in;

/// The walk of one plan after the other.
#[derive(Debug, Default)]
pub struct ChunkWalk {
    /// The clock of the plan in execution.
    clock: Option<PlanClock>,
    /// Its accepted chunks; without a record, those that the robot has not passed.
    chunks: VecDeque<PlanChunk>,
    /// The stops during the plans before.
    counts: StopCounts,
    record: Option<ExecutedMotion>,
}

impl ChunkWalk {
    /// A walk whose motion is recorded as executed.
    pub fn recorded() -> Self {
        Self { record: Some(ExecutedMotion::default()), ..Self::default() }
    }

    /// The robot has accepted the next chunk. The first chunk of a plan begins where it stands.
    pub fn accept(&mut self, chunk: &PlanChunk) {
        if chunk.waypoints().is_empty() {
            return;
        }
        if chunk.sequence == 0 || self.clock.is_none() {
            self.end_plan();
            self.clock = PlanClock::before(chunk);
        }
        if let Some(clock) = &mut self.clock {
            clock.accept(chunk);
            self.chunks.push_back(*chunk);
        }
    }

    /// Takes over a robot that has accepted `chunks`, the last ones of its plan, and was where
    /// `record` says. Without a record of this plan it stands at the plan's beginning; where the
    /// chunks do not reach back to there, it rests where it stops without a further chunk. Returns
    /// whether it was recorded.
    pub fn take_over(&mut self, chunks: &[PlanChunk], record: Option<&WalkRecord>) -> bool {
        let Some(last) = chunks.last() else { return false };
        let plan = (last.plan_id, last.epoch);
        let record = record.filter(|record| (record.plan_id, record.epoch) == plan);
        let pace = record.and_then(recorded_pace).unwrap_or(Pace::AtRest(0));
        let clock = PlanClock::at(chunks, pace);
        let is_recorded = record.is_some() && clock.is_some();
        self.clock =
            clock.or_else(|| PlanClock::at(chunks, Pace::AtRest(last.sequence as usize + 1)));
        self.chunks = chunks.to_vec().into();
        self.advance(0.0);
        is_recorded
    }

    /// Where in its chunks the robot is, for the controller that takes it over. Neither the number
    /// of the record nor the instant is set.
    pub fn record(&self) -> Option<WalkRecord> {
        let (clock, last) = (self.clock.as_ref()?, self.chunks.back()?);
        let (pace, stop, time) = match clock.pace() {
            Pace::Walking(time) => (RecordedPace::Walking, 0, time),
            Pace::AtRest(stop) => (RecordedPace::AtRest, stop, 0.0),
            Pace::Braking(stop, after) => (RecordedPace::Braking, stop, after),
            Pace::GoingOn(stop, after) => (RecordedPace::GoingOn, stop, after),
        };
        let StopCounts { brakes, stood } = self.counts();
        Some(WalkRecord {
            plan_id: last.plan_id,
            epoch: last.epoch,
            pace: pace as u64,
            stop: stop as u64,
            time,
            brakes,
            stood,
            ..WalkRecord::zeroed()
        })
    }

    /// The clock of the plan in execution, if there is one.
    pub fn clock(&self) -> Option<&PlanClock> {
        self.clock.as_ref()
    }

    /// The accepted chunks of that plan that the robot has not passed; with a record, all of them.
    pub fn chunks(&self) -> &VecDeque<PlanChunk> {
        &self.chunks
    }

    /// Number of accepted chunks that the robot has not passed.
    pub fn chunks_ahead(&self) -> usize {
        let now = self.clock.as_ref().map_or(0.0, |clock| clock.now().time);
        self.chunks.iter().rev().take_while(|chunk| !is_passed(chunk, now)).count()
    }

    /// Lets `seconds` pass.
    pub fn advance(&mut self, seconds: f64) {
        let Some(clock) = &mut self.clock else { return };
        clock.advance(seconds);
        let now = clock.now().time;
        while self.record.is_none() && self.chunks.len() > 1 && is_passed(&self.chunks[0], now) {
            self.chunks.pop_front();
        }
    }

    /// The chunk in which the robot is, and its motion at this instant.
    pub fn now(&self) -> Option<(&PlanChunk, Waypoint)> {
        let now = self.clock.as_ref()?.now();
        let is_passed = |chunk: &PlanChunk| is_passed(chunk, now.time);
        let at = self.chunks.partition_point(is_passed).min(self.chunks.len().checked_sub(1)?);
        let chunk = self.chunks.get(at)?;
        Some((chunk, at_rate(planned_in(chunk, now.time), now.rate, now.rate_change)))
    }

    /// Whether the robot stands and stays there without a further chunk.
    pub fn is_at_rest(&self) -> bool {
        self.clock.as_ref().is_none_or(PlanClock::is_at_rest)
    }

    /// Whether the robot has arrived at the end of its plan.
    pub fn is_finished(&self) -> bool {
        self.clock.as_ref().is_some_and(PlanClock::is_finished)
    }

    /// How long the robot walks from here at most before it has to brake for want of a chunk, s; 0
    /// without a plan.
    pub fn seconds_to_brake(&self) -> f64 {
        self.clock.as_ref().map_or(0.0, PlanClock::seconds_to_brake)
    }

    /// The stops so far.
    pub fn counts(&self) -> StopCounts {
        self.counts.plus(self.clock.as_ref().map(PlanClock::counts).unwrap_or_default())
    }

    /// The motion as executed so far, in chunks; nothing if it is not recorded.
    pub fn executed(&self) -> Vec<PlanChunk> {
        let Some(mut motion) = self.record.clone() else { return Vec::new() };
        if let Some(clock) = &self.clock {
            motion.add(&PlanWalk { chunks: &Vec::from(self.chunks.clone()), clock });
        }
        motion.finish()
    }

    /// Ends the plan in execution.
    fn end_plan(&mut self) {
        let Some(clock) = self.clock.take() else { return };
        self.counts = self.counts.plus(clock.counts());
        let chunks = std::mem::take(&mut self.chunks);
        if let Some(record) = &mut self.record {
            record.add(&PlanWalk { chunks: &Vec::from(chunks), clock: &clock });
        }
    }
}

/// Whether a chunk ends before a plan time (s).
fn is_passed(chunk: &PlanChunk, now: f64) -> bool {
    chunk.waypoints().last().is_some_and(|waypoint| waypoint.time < now)
}

/// The pace of a record.
fn recorded_pace(record: &WalkRecord) -> Option<Pace> {
    let stop = usize::try_from(record.stop).ok()?;
    let time = record.time;
    Some(match RecordedPace::from_wire(record.pace)? {
        RecordedPace::Walking => Pace::Walking(time),
        _ if time < 0.0 => return None,
        RecordedPace::AtRest => Pace::AtRest(stop),
        RecordedPace::Braking => Pace::Braking(stop, time),
        RecordedPace::GoingOn => Pace::GoingOn(stop, time),
    })
}
