//! The timing of a path, piece by piece: rates at its points, the time-optimal profile, its
//! rounding, and the check of the rounded motion, which slows it down where it is beyond a limit.
//!
//! Points come in pieces. Each call of [`PathTiming::solve`] ends the path known so far at rest and
//! fixes the profile up to the touch-down before the last two pieces; so a fixed profile can always
//! come to rest within the known path. The rest of the path is timed anew when more of it is known.

use glam::DVec2;
use surefoot_shared_types::base::limits::{CHUNK_WAYPOINTS_MAX, JOINTS_MAX};
use surefoot_shared_types::message::{Interpolation, Waypoint};

use crate::base::arena::reserve;
use crate::base::capacity::ArenaFull;
use crate::timing::contact_rates::ContactRates;
use crate::timing::limits::Level;
use crate::timing::load_sharing::LoadSchedule;
use crate::timing::path_point::{PathPoint, PathSpan};
use crate::timing::profile::{Node, controllable, fastest};
use crate::timing::time_law::{PathRates, TimeLaw};
use crate::timing::timed_robot::TimedRobot;
use crate::timing::tuning::{
    INTERVAL_MAX, RATES_SHARE_MAX, ROUNDING_TIME, ROUNDS_MAX, SLOW_DOWN, SLOW_DOWNS_MAX, SLOWER,
};

/// A path: its points, and its spans in order.
#[derive(Debug, Clone, Copy)]
pub struct Path<'a> {
    /// The points.
    pub points: &'a [PathPoint],
    /// The spans known so far.
    pub spans: &'a [PathSpan],
}

/// What happened while a path was timed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TimingStats {
    /// Rests between the ends of the path.
    pub rests: u64,
    /// Rounds in which the profile was slowed down.
    pub rounds: u64,
    /// Points at which the robot cannot stand within the full margins, but within smaller ones.
    pub relaxed: u64,
    /// Profiles that no slowing down brought within the limits.
    pub beyond: u64,
}

/// The timing of one path.
#[derive(Debug)]
pub struct PathTiming {
    robot: TimedRobot,
    contact_rates: ContactRates,
    nodes: Vec<Node>,
    /// First node of each span, and the position less the parameter there.
    starts: Vec<(usize, f64)>,
    profile: Profile,
    law: TimeLaw,
    stats: TimingStats,
}

/// Squared speeds at the nodes.
#[derive(Debug)]
struct Profile {
    ceilings: Vec<f64>,
    speeds: Vec<f64>,
    /// The speeds of the last profile within the limits, which ends at rest.
    accepted: Vec<f64>,
    /// By node: the factor by which the present round slows it down.
    slower: Vec<f64>,
    /// Number of nodes whose speeds are fixed.
    fixed: usize,
    /// Number of spans known in the last search.
    solved_spans: usize,
}

/// The times of a span: its beginning, its end (s), and the number of its intervals.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpanTimes {
    /// Its beginning, s.
    pub begin: f64,
    /// Its end, s.
    pub end: f64,
    /// Number of equal intervals between its waypoints.
    pub intervals: usize,
}

impl PathTiming {
    /// Reserves memory for paths of `points_max` points.
    pub fn new(robot: TimedRobot, points_max: usize) -> Self {
        let nodes_max = 2 * points_max;
        Self {
            robot,
            contact_rates: ContactRates::default(),
            nodes: reserve(nodes_max),
            starts: reserve(points_max),
            profile: Profile {
                ceilings: reserve(nodes_max),
                speeds: reserve(nodes_max),
                accepted: reserve(nodes_max),
                slower: reserve(nodes_max),
                fixed: 0,
                solved_spans: 0,
            },
            law: TimeLaw::new(nodes_max),
            stats: TimingStats::default(),
        }
    }

    /// Begins a path.
    pub fn begin(&mut self) {
        self.nodes.clear();
        self.starts.clear();
        self.law.rebuild(0, &[], &[]);
        let profile = &mut self.profile;
        for list in
            [&mut profile.ceilings, &mut profile.speeds, &mut profile.accepted, &mut profile.slower]
        {
            list.clear();
        }
        (profile.fixed, profile.solved_spans) = (0, 0);
        self.stats = TimingStats::default();
    }

    /// What happened so far.
    pub fn stats(&self) -> TimingStats {
        self.stats
    }

    /// The unrounded profile: position, squared speed and rates of each node.
    pub fn nodes(&self) -> impl Iterator<Item = (&Node, f64)> {
        self.nodes.iter().zip(self.profile.speeds.iter().copied())
    }

    /// The rounded time law.
    pub fn law(&self) -> &TimeLaw {
        &self.law
    }

    /// Adds the next span of a path: the rates at its points.
    ///
    /// # Errors
    /// The memory for nodes is used up.
    pub fn add_span(&mut self, path: Path<'_>) -> Result<(), ArenaFull> {
        let index = self.starts.len();
        let span = &path.spans[index];
        let points = &path.points[span.first..=span.last];
        let has_one_cell = points.len() == 2;
        let count = points.len() + usize::from(has_one_cell);
        if self.nodes.len() + count > self.nodes.capacity() {
            return Err(ArenaFull::Waypoints);
        }
        let position = self.nodes.last().map_or(0.0, |last| last.position);
        let offset = position - points[0].parameter;
        self.starts.push((self.nodes.len(), offset));
        for at in 0..count {
            let middle = 0.5 * (points[0].parameter + points[points.len() - 1].parameter);
            let parameter = match (has_one_cell, at) {
                (true, 1) => middle,
                (true, 2) => points[1].parameter,
                _ => points[at].parameter,
            };
            let state = state_at(points, parameter);
            let is_last = at + 1 == count;
            let lands = is_last && span.contacts.len() == 1;
            let (rates, level) = self.robot.rates(&mut self.contact_rates, span, &state, lands);
            self.stats.relaxed += u64::from(level != Level::Full);
            self.nodes.push(Node {
                position: parameter + offset,
                rests: at == 0 && (span.starts_at_rest || index == 0),
                ends_span: is_last,
                rates,
                factor: 1.0,
                level,
            });
            for list in [&mut self.profile.ceilings, &mut self.profile.speeds] {
                list.push(0.0);
            }
            self.profile.slower.push(1.0);
        }
        if index > 0 && span.starts_at_rest {
            self.stats.rests += 1;
        }
        Ok(())
    }

    /// Times the path known so far, at rest at its end, and fixes the profile of the first
    /// `fixed_spans` spans. Bounded: at most `ROUNDS_MAX + SLOW_DOWNS_MAX` rounds, twice. Returns
    /// `false` where the path cannot be walked within the limits, however slowly.
    pub fn solve(&mut self, path: Path<'_>, fixed_spans: usize) -> bool {
        let is_within =
            self.search(path) || self.rest_where_the_last_one_ends() && self.search(path);
        self.stats.beyond += u64::from(!is_within);
        self.profile.accepted.clear();
        self.profile.accepted.extend_from_slice(&self.profile.speeds);
        let fixed = self.starts.get(fixed_spans).map_or(self.nodes.len(), |(node, _)| *node);
        self.profile.fixed = fixed.max(self.profile.fixed);
        is_within
    }

    /// Slows the open part down until its rounded motion is within the limits. Returns whether it
    /// is.
    fn search(&mut self, path: Path<'_>) -> bool {
        self.forget_the_last_end();
        for round in 0..ROUNDS_MAX + SLOW_DOWNS_MAX {
            let could = self.profile_round();
            if could && !self.is_beyond(path) {
                return true;
            }
            if self.profile.fixed > 0 && (!could || round >= ROUNDS_MAX) {
                return false;
            }
            self.stats.rounds += 1;
            self.slow_down(!could || round >= ROUNDS_MAX);
        }
        false
    }

    /// Allows the whole rates again in the last two spans of the search before: there they were
    /// shrunk for the rest at their end.
    fn forget_the_last_end(&mut self) {
        let span = self.profile.solved_spans.saturating_sub(2);
        let node = self.starts.get(span).map_or(0, |(node, _)| *node).max(self.profile.fixed);
        self.nodes[node..].iter_mut().for_each(|node| node.factor = 1.0);
        self.profile.solved_spans = self.starts.len();
    }

    /// Computes the profile and its time law. Returns whether the open part can go on from the
    /// fixed one.
    fn profile_round(&mut self) -> bool {
        let first = self.profile.fixed.saturating_sub(1);
        let nodes = &self.nodes[first..];
        controllable(nodes, &mut self.profile.ceilings[first..]);
        let could =
            fastest(nodes, &self.profile.ceilings[first..], &mut self.profile.speeds[first..]);
        self.law.rebuild(first, &self.nodes, &self.profile.speeds);
        could
    }

    /// Takes the last profile within the limits up to the rest at its end. Returns whether that is
    /// beyond the fixed part.
    fn rest_where_the_last_one_ends(&mut self) -> bool {
        let end = self.profile.accepted.len();
        if self.profile.fixed == 0 || end <= self.profile.fixed || end >= self.nodes.len() {
            return false;
        }
        self.profile.speeds[..end].copy_from_slice(&self.profile.accepted);
        self.nodes[end].rests = true;
        self.nodes[end..].iter_mut().for_each(|node| node.factor = 1.0);
        self.profile.fixed = end;
        self.profile.speeds[end] = 0.0;
        self.law.rebuild(end.saturating_sub(1), &self.nodes[..], &self.profile.speeds);
        self.stats.rests += 1;
        true
    }

    /// Shrinks the rates of the open nodes: where the last check asks for it, or all of them.
    fn slow_down(&mut self, everywhere: bool) {
        let first = self.profile.fixed.saturating_sub(1);
        for (node, slower) in self.nodes[first..].iter_mut().zip(&mut self.profile.slower[first..])
        {
            node.factor *= if everywhere { SLOW_DOWN } else { *slower };
            *slower = 1.0;
        }
    }

    /// Whether the rounded motion is beyond a limit anywhere, and notes where to slow down.
    fn is_beyond(&mut self, path: Path<'_>) -> bool {
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
        if is_beyond {
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
    fn node_before(&self, span: usize, position: f64) -> (usize, f64) {
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

    /// Number of spans known so far.
    pub fn spans(&self) -> usize {
        self.starts.len()
    }

    /// The times of a span.
    pub fn span_times(&self, span: usize) -> SpanTimes {
        let node = |span: usize| self.starts.get(span).map_or(self.nodes.len() - 1, |(at, _)| *at);
        let begin =
            if span == 0 { 0.0 } else { self.law.rounded_time_of_node(node(span), &self.nodes) };
        let end = self.law.rounded_time_of_node(node(span + 1), &self.nodes);
        let intervals = libm::ceil((end - begin) / INTERVAL_MAX - 1e-9).max(1.0) as usize;
        SpanTimes { begin, end, intervals }
    }

    /// The number of spans whose motion does not change any more; `is_complete`: whether the path
    /// is.
    pub fn final_spans(&self, is_complete: bool) -> usize {
        if is_complete {
            return self.starts.len();
        }
        let Some(last) = self.profile.fixed.checked_sub(1) else { return 0 };
        let fixed = self.law.time_of_node(last) - 0.5 * ROUNDING_TIME;
        let ends = |span: &usize| self.span_times(*span).end <= fixed;
        (0..self.starts.len()).take_while(ends).count()
    }

    /// A waypoint of a span without its torques.
    fn state(&self, path: Path<'_>, span: usize, times: &SpanTimes, index: usize) -> Waypoint {
        let time = times.at(index, times.intervals);
        let known = &path.spans[span];
        let points = &path.points[known.first..=known.last];
        let mut rates = self.law.at(time);
        let next_rests = self.starts.get(span + 1).is_none_or(|(node, _)| self.nodes[*node].rests);
        let (first, offset) = self.starts[span];
        let is_rest =
            index == 0 && self.nodes[first].rests || index == times.intervals && next_rests;
        if is_rest {
            (rates.speed, rates.acceleration) = (0.0, 0.0);
        }
        let parameter = match index {
            0 => points[0].parameter,
            _ if index == times.intervals => points[points.len() - 1].parameter,
            _ => rates.position - offset,
        };
        timed(&state_at(points, parameter), &rates, time)
    }

    /// A waypoint of a span with its feed-forward torques.
    pub fn waypoint(
        &self,
        path: Path<'_>,
        span: usize,
        times: &SpanTimes,
        index: usize,
    ) -> Waypoint {
        let mut waypoint = self.state(path, span, times, index);
        let (node, _) = self.node_before(span, self.law.at(waypoint.time).position);
        let schedule = schedule(path.spans, span);
        let progress = index as f64 / times.intervals as f64;
        let level = self.nodes[node].level;
        let within = (level, &schedule, progress);
        self.robot.write_torques(&path.spans[span], within, &mut waypoint);
        waypoint
    }
}

impl SpanTimes {
    /// Number of chunks of the span.
    pub fn chunks(&self) -> usize {
        self.intervals.div_ceil(CHUNK_WAYPOINTS_MAX - 1)
    }

    /// The waypoints of a chunk, the first and the last one: all chunks are about equally long.
    pub fn chunk(&self, chunk: usize) -> [usize; 2] {
        [chunk, chunk + 1].map(|at| self.intervals * at / self.chunks())
    }

    /// Beginning and end of a chunk, s.
    pub fn chunk_times(&self, chunk: usize) -> [f64; 2] {
        self.chunk(chunk).map(|index| self.at(index, self.intervals))
    }

    /// The time of an instant of which there are `count` after the first one, s.
    pub fn at(&self, index: usize, count: usize) -> f64 {
        if index == count {
            return self.end;
        }
        self.begin + (self.end - self.begin) * index as f64 / count as f64
    }
}

/// Rounding of shares of limits.
const SHARE_TOLERANCE: f64 = 1e-9;

/// The path at a parameter among the points of a span, as a waypoint whose time is the parameter.
fn state_at(points: &[PathPoint], parameter: f64) -> Waypoint {
    let after = points.partition_point(|point| point.parameter <= parameter);
    let before = after.saturating_sub(1).min(points.len() - 2);
    let (a, b) = (waypoint_of(&points[before]), waypoint_of(&points[before + 1]));
    if parameter <= a.time {
        return a;
    }
    if parameter >= b.time { b } else { Interpolation::Quintic.between(&a, &b, parameter) }
}

fn waypoint_of(point: &PathPoint) -> Waypoint {
    let mut waypoint = Waypoint::at_rest(point.parameter, &point.world_from_root, &point.q);
    waypoint.root_velocity.copy_from_slice(&point.first[..6]);
    waypoint.joint_velocity.copy_from_slice(&point.first[6..]);
    waypoint.root_acceleration.copy_from_slice(&point.second[..6]);
    waypoint.joint_acceleration.copy_from_slice(&point.second[6..]);
    waypoint
}

/// A state of the path, walked at these rates.
fn timed(state: &Waypoint, rates: &PathRates, time: f64) -> Waypoint {
    let mut waypoint = Waypoint { time, ..*state };
    let (x, u) = (rates.speed * rates.speed, rates.acceleration);
    for index in 0..6 {
        let (first, second) = (state.root_velocity[index], state.root_acceleration[index]);
        waypoint.root_velocity[index] = rates.speed * first;
        waypoint.root_acceleration[index] = x * second + u * first;
    }
    for index in 0..JOINTS_MAX {
        let (first, second) = (state.joint_velocity[index], state.joint_acceleration[index]);
        waypoint.joint_velocity[index] = rates.speed * first;
        waypoint.joint_acceleration[index] = x * second + u * first;
    }
    waypoint
}

/// How a double support takes over the load: none on a foot that has just landed or will lift off.
fn schedule(spans: &[PathSpan], span: usize) -> LoadSchedule {
    let share_beside = |span: Option<&PathSpan>| {
        let single = span.filter(|span| span.contacts.len() == 1)?;
        Some(f64::from(single.contacts[0].limb))
    };
    LoadSchedule {
        start: share_beside(span.checked_sub(1).and_then(|before| spans.get(before))),
        end: share_beside(spans.get(span + 1)),
    }
}
