//! Whether the rounded motion of a profile is within the limits, and where it has to be slower.

use glam::DVec2;
use surefoot_shared_types::message::{Interpolation, Waypoint};

use crate::timing::path_timing::{Path, PathTiming};
use crate::timing::time_law::PathRates;
use crate::timing::timed_motion::SpanTimes;
use crate::timing::tuning::{INTERVAL_MAX, RATES_SHARE_MAX, ROUNDING_TIME, SLOW_DOWN, SLOWER};

/// Rounding of shares of limits.
const SHARE_TOLERANCE: f64 = 1e-9;

impl PathTiming {
    /// Whether the rounded motion is beyond a limit anywhere, or a chunk without a stop, and notes
    /// where to slow down.
    pub(super) fn is_beyond(&mut self, path: Path<'_>) -> bool {
        let first = self.profile.fixed.saturating_sub(1);
        let open = if first > 0 { self.law.time_of_node(first) } else { 0.0 };
        let from = open - if first > 0 { ROUNDING_TIME } else { 0.0 };
        let mut is_beyond = false;
        for span in 0..self.starts.len() {
            let times = self.span_times(span);
            if times.end > open {
                is_beyond |= self.rates_are_beyond(span, &times, open);
            }
        }
        if is_beyond || !self.finds_stops() {
            return true;
        }
        for span in 0..self.starts.len() {
            let times = self.span_times(span);
            if times.end > from {
                is_beyond |= self.motion_is_beyond(path, span, &times, from);
            }
        }
        is_beyond
    }

    /// Compares the rounded rates with those of the nodes around.
    fn rates_are_beyond(&mut self, span: usize, times: &SpanTimes, from: f64) -> bool {
        let count = 2 * times.intervals;
        let mut is_beyond = false;
        for sample in 0..=count {
            let time = times.at(sample, count);
            if time >= from {
                let rates = self.law.at(time);
                let share = self.share_of(span, &rates);
                if share > RATES_SHARE_MAX {
                    self.ask_slower(rates.position, rates.speed, SLOWER / share);
                    is_beyond = true;
                }
            }
        }
        is_beyond
    }

    /// The share of the rates around a position that these take.
    fn share_of(&self, span: usize, at: &PathRates) -> f64 {
        let (before, part) = self.node_before(span, at.position);
        let rates = DVec2::new(at.speed * at.speed, at.acceleration);
        let share = |node: usize| self.nodes[node].rates.share_of(rates);
        share(before) * (1.0 - part) + share(before + 1) * part
    }

    /// The same at a time, at `rate` times the law's speed while that rate changes by `change`
    /// (1/s).
    pub(crate) fn share_at(&self, time: f64, rate: f64, change: f64) -> f64 {
        let at = self.law.at(time);
        let slowed = PathRates {
            position: at.position,
            speed: rate * at.speed,
            acceleration: rate * rate * at.acceleration + change * at.speed,
        };
        let after =
            self.starts.partition_point(|(node, _)| self.nodes[*node].position <= at.position);
        self.share_of(after.saturating_sub(1), &slowed)
    }

    /// The node of a span before a position, and how far the position is on the way to the next.
    pub(super) fn node_before(&self, span: usize, position: f64) -> (usize, f64) {
        let (first, _) = self.starts[span];
        let end = self.starts.get(span + 1).map_or(self.nodes.len(), |(node, _)| *node);
        let within = self.nodes[first..end].partition_point(|node| node.position <= position);
        let before = (first + within).saturating_sub(1).clamp(first, end - 2);
        let (a, b) = (self.nodes[before].position, self.nodes[before + 1].position);
        (before, ((position - a) / (b - a)).clamp(0.0, 1.0))
    }

    /// Notes that the nodes within the rounding of a position shall be slower by `factor`.
    fn ask_slower(&mut self, position: f64, speed: f64, factor: f64) {
        let reach = 0.5 * ROUNDING_TIME * speed;
        let first = self.profile.fixed.saturating_sub(1);
        let begin = self.nodes.partition_point(|node| node.position < position - reach);
        let end = self.nodes.partition_point(|node| node.position <= position + reach);
        let (begin, end) = (begin.saturating_sub(1).max(first), (end + 1).min(self.nodes.len()));
        for slower in self.profile.slower[..end].iter_mut().skip(begin) {
            *slower = slower.min(factor.max(SLOW_DOWN));
        }
    }

    /// Notes that the nodes between two times (s) shall be slower.
    pub(super) fn ask_slower_between(&mut self, begin: f64, end: f64) {
        let [begin, end] = [begin, end].map(|time| self.law.at(time).position);
        let first = self.profile.fixed.saturating_sub(1);
        for (node, slower) in self.nodes.iter().zip(&mut self.profile.slower).skip(first) {
            if (begin..=end).contains(&node.position) {
                *slower = slower.min(SLOW_DOWN);
            }
        }
    }

    /// Checks the motion as it is emitted: at every waypoint, or in the middle before it, by turns.
    /// Between two samples the rounded motion changes little.
    fn motion_is_beyond(
        &mut self,
        path: Path<'_>,
        span: usize,
        times: &SpanTimes,
        from: f64,
    ) -> bool {
        let mut is_beyond = false;
        for index in (0..=times.intervals).step_by(2) {
            let here = self.state(path, span, times, index);
            if here.time >= from {
                is_beyond |= self.sample_is_beyond(path, span, &here);
            }
            if index < times.intervals && here.time + 0.5 * INTERVAL_MAX >= from {
                let next = self.state(path, span, times, index + 1);
                let middle = 0.5 * (here.time + next.time);
                let sample = Interpolation::Quintic.between(&here, &next, middle);
                is_beyond |= self.sample_is_beyond(path, span, &sample);
            }
        }
        is_beyond
    }

    fn sample_is_beyond(&mut self, path: Path<'_>, span: usize, sample: &Waypoint) -> bool {
        let rates = self.law.at(sample.time);
        let (node, _) = self.node_before(span, rates.position);
        let level = self.nodes[node].level.max(self.nodes[node + 1].level);
        let load = self.robot.load(&mut self.contact_rates, &path.spans[span], level, sample);
        if load > 1.0 + SHARE_TOLERANCE {
            self.ask_slower(rates.position, rates.speed, SLOWER / load);
        }
        load > 1.0 + SHARE_TOLERANCE
    }
}
