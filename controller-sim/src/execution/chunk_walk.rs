//! A robot that walks accepted chunks in its own time: it brakes along its path where the next
//! chunk is not there, stands, and goes on.

use std::collections::VecDeque;

use surefoot_shared_types::message::{PlanChunk, Waypoint};

use crate::check::course::at_rate;
use crate::execution::executed_motion::{ExecutedMotion, PlanWalk};
use crate::execution::plan_clock::{PlanClock, StopCounts};
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
        let Some(first) = chunk.waypoints().first() else { return };
        if chunk.sequence == 0 || self.clock.is_none() {
            self.end_plan();
            self.clock = Some(PlanClock::new(first.time));
        }
        if let Some(clock) = &mut self.clock {
            clock.accept(chunk);
            self.chunks.push_back(*chunk);
        }
    }

    /// Lets `seconds` pass.
    pub fn advance(&mut self, seconds: f64) {
        let Some(clock) = &mut self.clock else { return };
        clock.advance(seconds);
        let now = clock.now().time;
        let is_passed = |chunk: &PlanChunk| chunk.waypoints().last().is_some_and(|w| w.time < now);
        while self.record.is_none() && self.chunks.len() > 1 && is_passed(&self.chunks[0]) {
            self.chunks.pop_front();
        }
    }

    /// The chunk in which the robot is, and its motion at this instant.
    pub fn now(&self) -> Option<(&PlanChunk, Waypoint)> {
        let now = self.clock.as_ref()?.now();
        let ends_before = |chunk: &PlanChunk| {
            chunk.waypoints().last().is_some_and(|waypoint| waypoint.time < now.time)
        };
        let at = self.chunks.partition_point(ends_before).min(self.chunks.len().checked_sub(1)?);
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
