//! Whether the rounded motion of a profile is within the limits, and where it has to be slower.

use glam::DVec3;
use surefoot_shared_types::message::{Interpolation, Waypoint};

use crate::timing::motion_changes::{Checked, MotionChanges};
use crate::timing::path_point::Path;
use crate::timing::slow_downs::SlowDowns;
use crate::timing::timed_path::{SpanTimes, TimedPath};
use crate::timing::timed_robot::{SpanContacts, TimedRobot, TimingMemory};
use crate::timing::tuning::{
    COP_MARGIN_BETWEEN, INTERVAL_MAX, RATES_SHARE_MAX, ROUNDING_TIME, SLOWER,
};

/// Rounding of shares of limits.
const SHARE_TOLERANCE: f64 = 1e-9;
/// Changes of the root's acceleration (m/s2), of its angular acceleration (rad/s2) and of a joint's
/// acceleration (rad/s2 or m/s2) between two waypoints up to which the middle between them is
/// checked alone.
const STEADY_MAX: [f64; 3] = [0.5, 0.5, 5.0];
/// The parts into which the curve between other waypoints is divided.
const PARTS_WHERE_UNSTEADY: usize = 8;

/// Compares a motion with the limits. Spans that are unchanged since they were within the limits
/// are not compared again.
#[derive(Debug)]
pub(super) struct ProfileCheck<'a> {
    pub robot: &'a TimedRobot,
    pub memory: &'a mut TimingMemory,
    pub path: Path<'a>,
    pub timed: &'a TimedPath,
    pub slow_downs: &'a mut SlowDowns,
    pub changes: &'a mut MotionChanges,
}

impl ProfileCheck<'_> {
    /// A span before which all end by a time (s). The rounded law passes a node at most half of
    /// `ROUNDING_TIME` after the unrounded one.
    fn first_span(&self, from: f64) -> usize {
        let law = &self.timed.law;
        let begins_before =
            |(node, _): &(usize, f64)| law.time_of_node(*node) + ROUNDING_TIME <= from;
        self.timed.starts.partition_point(begins_before).saturating_sub(1)
    }

    /// Compares the rounded rates after a time (s) with those of the nodes around.
    pub fn rates_are_within(&mut self, from: f64) -> bool {
        let mut is_within = true;
        for span in self.first_span(from)..self.timed.spans() {
            if self.changes.is_checked(Checked::Rates, span) {
                continue;
            }
            let times = self.timed.span_times(span);
            let count = 2 * times.intervals;
            let mut span_is_within = true;
            for sample in 0..=count {
                let time = times.at(sample, count);
                if time >= from && times.end > from {
                    span_is_within &= self.rate_is_within(span, time);
                }
            }
            if span_is_within {
                self.changes.mark(Checked::Rates, span);
            }
            is_within &= span_is_within;
        }
        is_within
    }

    fn rate_is_within(&mut self, span: usize, time: f64) -> bool {
        let rates = self.timed.law.at(time);
        let share = self.timed.share_of(span, &rates);
        if share > RATES_SHARE_MAX {
            self.slow_downs.ask_near(self.timed, rates.position, rates.speed, SLOWER / share);
        }
        share <= RATES_SHARE_MAX
    }

    /// Checks the motion after a time (s) as it is emitted.
    pub fn motion_is_within(&mut self, from: f64) -> bool {
        let mut is_within = true;
        for span in self.first_span(from)..self.timed.spans() {
            if self.changes.is_checked(Checked::Motion, span) {
                continue;
            }
            let times = self.timed.span_times(span);
            let span_is_within = times.end <= from || self.span_is_within(span, &times, from);
            if span_is_within {
                self.changes.mark(Checked::Motion, span);
            }
            is_within &= span_is_within;
        }
        is_within
    }

    /// Checks every waypoint and the curves between them.
    fn span_is_within(&mut self, span: usize, times: &SpanTimes, from: f64) -> bool {
        let mut is_within = true;
        let contacts = &self.robot.span_contacts(&self.path.spans[span], COP_MARGIN_BETWEEN);
        let mut here = self.timed.state(self.path, span, times, 0);
        for index in 0..=times.intervals {
            if here.time >= from {
                is_within &= self.sample_is_within((span, contacts), &here);
            }
            if index < times.intervals {
                let next = self.timed.state(self.path, span, times, index + 1);
                if here.time + 0.5 * INTERVAL_MAX >= from {
                    is_within &= self.curve_is_within((span, contacts), [&here, &next]);
                }
                here = next;
            }
        }
        is_within
    }

    /// Checks instants between two waypoints: the middle, and more where an acceleration changes
    /// much.
    fn curve_is_within(
        &mut self,
        on: (usize, &SpanContacts<'_>),
        [here, next]: [&Waypoint; 2],
    ) -> bool {
        let parts = if is_steady(here, next) { 2 } else { PARTS_WHERE_UNSTEADY };
        let mut is_within = true;
        for part in 1..parts {
            let time = here.time + (next.time - here.time) * part as f64 / parts as f64;
            let sample = Interpolation::Quintic.between(here, next, time);
            is_within &= self.sample_is_within(on, &sample);
        }
        is_within
    }

    /// Compares a sample with the first level, from those of the nodes around it on, within which
    /// the robot can stand there.
    fn sample_is_within(
        &mut self,
        (span, contacts): (usize, &SpanContacts<'_>),
        sample: &Waypoint,
    ) -> bool {
        let Self { robot, memory, timed, slow_downs, .. } = self;
        let rates = timed.law.at(sample.time);
        let (node, _) = timed.node_before(span, rates.position);
        let mut level = timed.nodes[node].level.max(timed.nodes[node + 1].level);
        loop {
            let mut load = |at: &Waypoint| robot.load(memory, contacts, level, at);
            let moving = load(sample);
            if moving <= 1.0 + SHARE_TOLERANCE {
                return true;
            }
            let standing = load(&sample.rested());
            let next = level.next().filter(|_| standing >= 1.0);
            if let Some(next) = next {
                level = next;
                continue;
            }
            let slower = SLOWER * (1.0 - standing).max(0.0) / (moving - standing);
            slow_downs.ask_near(timed, rates.position, rates.speed, slower);
            return false;
        }
    }
}

/// Whether no acceleration changes much between two waypoints.
pub(super) fn is_steady(here: &Waypoint, next: &Waypoint) -> bool {
    let [[from, turn_from], [to, turn_to]] = [here, next].map(|waypoint| {
        let (linear, angular) = waypoint.root_acceleration.split_at(3);
        [linear, angular].map(DVec3::from_slice)
    });
    let joints = here.joint_acceleration.iter().zip(&next.joint_acceleration);
    let joint = joints.map(|(from, to)| (from - to).abs()).fold(0.0, f64::max);
    let changes = [from.distance(to), turn_from.distance(turn_to), joint];
    changes.iter().zip(STEADY_MAX).all(|(change, most)| *change <= most)
}
