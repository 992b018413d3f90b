//! The load on the ground of a timed motion at places between its waypoints, as far as the
//! zero-moment point needs it, at any rate of plan time: what braking ramps are tested with.

use surefoot_shared_types::message::{Interpolation, Waypoint};

use crate::robot::inverse_dynamics::LinkFrames;
use crate::timing::motion_changes::MotionChanges;
use crate::timing::path_point::Path;
use crate::timing::profile_check::is_steady;
use crate::timing::timed_path::{SpanTimes, TimedPath};
use crate::timing::timed_robot::TimedRobot;
use crate::timing::zero_moment::{BalanceBasis, ContactGround};

/// Intervals between waypoints of which the table knows the load.
const ENTRIES: usize = 2048;
/// Most parts of an interval.
const PARTS_MAX: usize = 4;
/// Parts of an interval in which the acceleration changes little.
const PARTS_WHERE_STEADY: usize = 2;
/// Spreads the intervals of neighbouring spans over the table.
const SPAN_STEP: usize = 97;

/// The load in one interval.
#[derive(Debug, Clone, Copy, Default)]
struct Entry {
    span: usize,
    interval: usize,
    /// The version of the span; 0 where the entry is empty.
    version: u32,
    parts: usize,
    loads: [BalanceBasis; PARTS_MAX + 1],
}

/// The table. An entry replaces another one at the same place; missing ones are computed.
#[derive(Debug)]
pub struct BalanceTable {
    entries: Vec<Entry>,
    /// Memory for the frames of one configuration.
    frames: LinkFrames,
}

/// A span of a motion.
#[derive(Debug)]
pub(super) struct SampledSpan {
    pub span: usize,
    pub times: SpanTimes,
    pub contact_ground: ContactGround,
}

/// A motion whose loads are looked up.
#[derive(Debug, Clone, Copy)]
pub(super) struct BalanceSource<'a> {
    pub robot: &'a TimedRobot,
    pub path: Path<'a>,
    pub timed: &'a TimedPath,
    pub changes: &'a MotionChanges,
}

impl Default for BalanceTable {
    fn default() -> Self {
        Self { entries: vec![Entry::default(); ENTRIES], frames: LinkFrames::default() }
    }
}

impl BalanceTable {
    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.entries.capacity() * size_of::<Entry>()
    }

    /// Begins a path.
    pub fn begin(&mut self) {
        self.entries.iter_mut().for_each(|entry| entry.version = 0);
    }

    /// The load at a time (s) within a span, between those of the places around it.
    pub(super) fn at(
        &mut self,
        source: &BalanceSource<'_>,
        sampled: &SampledSpan,
        time: f64,
    ) -> BalanceBasis {
        let (times, span) = (&sampled.times, sampled.span);
        let along = (time - times.begin) / (times.end - times.begin) * times.intervals as f64;
        let interval = (along.max(0.0) as usize).min(times.intervals - 1);
        let version = source.changes.version(span);
        let entry = &mut self.entries[(span * SPAN_STEP + interval) % ENTRIES];
        if (entry.span, entry.interval, entry.version) != (span, interval, version) {
            source.fill(entry, sampled, interval, &mut self.frames);
            (entry.span, entry.interval, entry.version) = (span, interval, version);
        }
        let place = ((along - interval as f64) * entry.parts as f64).clamp(0.0, entry.parts as f64);
        let before = (place as usize).min(entry.parts - 1);
        entry.loads[before].lerp(&entry.loads[before + 1], place - before as f64)
    }
}

impl BalanceSource<'_> {
    /// Computes the loads of an interval.
    fn fill(
        &self,
        entry: &mut Entry,
        sampled: &SampledSpan,
        interval: usize,
        frames: &mut LinkFrames,
    ) {
        let [here, next] = [interval, interval + 1]
            .map(|index| self.timed.state(self.path, sampled.span, &sampled.times, index));
        entry.parts = if is_steady(&here, &next) { PARTS_WHERE_STEADY } else { PARTS_MAX };
        for part in 0..=entry.parts {
            let share = part as f64 / entry.parts as f64;
            let mut load = |at: &Waypoint| self.robot.balance(&sampled.contact_ground, at, frames);
            entry.loads[part] = match part {
                0 => load(&here),
                _ if part == entry.parts => load(&next),
                _ => {
                    let time = here.time + (next.time - here.time) * share;
                    load(&Interpolation::Quintic.between(&here, &next, time))
                }
            };
        }
    }
}
