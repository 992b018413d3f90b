//! A timed path: its nodes, the rounded time law over them, and the motion that follows.

use glam::DVec2;
use surefoot_shared_types::base::limits::{CHUNK_WAYPOINTS_MAX, JOINTS_MAX};
use surefoot_shared_types::message::Waypoint;
use surefoot_shared_types::message::interpolation::quintic_motion;

use crate::base::arena::reserve;
use crate::timing::path_point::{Path, PathPoint};
use crate::timing::profile::Node;
use crate::timing::time_law::{PathRates, TimeLaw};
use crate::timing::tuning::{INTERVAL_MAX, ROUNDING_TIME};

/// The nodes of a path with a time law.
#[derive(Debug)]
pub struct TimedPath {
    /// The points of all spans, one after the other.
    pub nodes: Vec<Node>,
    /// First node of each span, and the position less the parameter there.
    pub starts: Vec<(usize, f64)>,
    /// The rounded time law.
    pub law: TimeLaw,
    /// When the rounded law is at the first node of each span, s; not yet computed for those that
    /// are added after the law.
    begins: Vec<f64>,
}

/// The times of a span.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct SpanTimes {
    /// Its beginning, s.
    pub begin: f64,
    /// Its end, s.
    pub end: f64,
    /// Number of equal intervals between its waypoints.
    pub intervals: usize,
}

impl TimedPath {
    /// Reserves memory for paths of `points_max` points.
    pub fn new(points_max: usize) -> Self {
        let nodes_max = 2 * points_max;
        Self {
            nodes: reserve(nodes_max),
            starts: reserve(points_max),
            law: TimeLaw::new(nodes_max),
            begins: reserve(points_max),
        }
    }

    /// Begins a path.
    pub fn begin(&mut self) {
        self.nodes.clear();
        self.starts.clear();
        self.begins.clear();
        self.law.rebuild(0, &[], &[]);
    }

    /// Keeps the first nodes and spans. The law is to be computed anew.
    pub fn truncate(&mut self, nodes: usize, spans: usize) {
        self.nodes.truncate(nodes);
        self.starts.truncate(spans);
        self.begins.truncate(spans);
    }

    /// Computes the time law from a node on, for squared speeds at the nodes. Times of spans up to
    /// `ROUNDING_TIME` before that node change, too.
    pub fn rebuild_law(&mut self, first: usize, speeds: &[f64]) {
        let Self { nodes, starts, law, begins } = self;
        law.rebuild(first, nodes, speeds);
        let changes_from = law.time_of_node(first.saturating_sub(1)) - 2.0 * ROUNDING_TIME;
        let is_kept = |(node, _): &(usize, f64)| law.time_of_node(*node) < changes_from;
        begins.truncate(starts.partition_point(is_kept));
        for (node, _) in &starts[begins.len()..] {
            begins.push(if *node == 0 { 0.0 } else { law.rounded_time_of_node(*node, nodes) });
        }
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.nodes.capacity() * size_of::<Node>()
            + self.starts.capacity() * size_of::<(usize, f64)>()
            + self.law.bytes()
            + self.begins.capacity() * size_of::<f64>()
    }

    /// The first node of a span; that after the last one of the path for a span that is not known.
    pub fn first_node(&self, span: usize) -> usize {
        self.starts.get(span).map_or(self.nodes.len(), |(node, _)| *node)
    }

    /// Number of spans known so far.
    pub fn spans(&self) -> usize {
        self.starts.len()
    }

    /// The times of a span.
    pub fn span_times(&self, span: usize) -> SpanTimes {
        let begin = self.begins[span];
        let end = self.begins.get(span + 1).copied().unwrap_or_else(|| self.law.end());
        let intervals = libm::ceil((end - begin) / INTERVAL_MAX - 1e-9).max(1.0) as usize;
        SpanTimes { begin, end, intervals }
    }

    /// The share of the rates around a position that these take.
    pub fn share_of(&self, span: usize, at: &PathRates) -> f64 {
        let (before, part) = self.node_before(span, at.position);
        let rates = DVec2::new(at.speed * at.speed, at.acceleration);
        let share = |node: usize| self.nodes[node].rates.share_of(rates);
        share(before) * (1.0 - part) + share(before + 1) * part
    }

    /// The same at a time, at `rate` times the law's speed while that rate changes by `change`
    /// (1/s).
    pub fn share_at(&self, time: f64, rate: f64, change: f64) -> f64 {
        let (span, slowed) = self.slowed(time, rate, change);
        self.share_of(span, &slowed)
    }

    /// When the robot rests last up to the beginning of a span, s.
    pub fn last_rest(&self, span: usize) -> f64 {
        let spans = self.starts[..=span].iter().zip(&self.begins);
        let mut rests = spans.rev().filter(|((node, _), _)| self.nodes[*node].rests);
        rests.next().map_or(0.0, |(_, begin)| *begin)
    }

    /// The span in which a time is, as the emitted motion has it.
    pub fn span_at(&self, time: f64) -> usize {
        let (span, _) = self.slowed(time, 1.0, 0.0);
        let is_over = span + 1 < self.spans() && self.span_times(span).end <= time;
        span + usize::from(is_over)
    }

    /// The span at a time, and the rates along the path there at another speed.
    fn slowed(&self, time: f64, rate: f64, change: f64) -> (usize, PathRates) {
        let at = self.law.at(time);
        let slowed = PathRates {
            position: at.position,
            speed: rate * at.speed,
            acceleration: rate * rate * at.acceleration + change * at.speed,
        };
        let after =
            self.starts.partition_point(|(node, _)| self.nodes[*node].position <= at.position);
        (after.saturating_sub(1), slowed)
    }

    /// The node of a span before a position, and how far the position is on the way to the next.
    pub fn node_before(&self, span: usize, position: f64) -> (usize, f64) {
        let (first, _) = self.starts[span];
        let end = self.starts.get(span + 1).map_or(self.nodes.len(), |(node, _)| *node);
        let within = self.nodes[first..end].partition_point(|node| node.position <= position);
        let before = (first + within).saturating_sub(1).clamp(first, end - 2);
        let (a, b) = (self.nodes[before].position, self.nodes[before + 1].position);
        (before, ((position - a) / (b - a)).clamp(0.0, 1.0))
    }

    /// The rates at a waypoint of a span.
    pub fn rates_at(&self, span: usize, times: &SpanTimes, index: usize) -> PathRates {
        let mut rates = self.law.at(times.at(index, times.intervals));
        let next_rests = self.starts.get(span + 1).is_none_or(|(node, _)| self.nodes[*node].rests);
        let (first, _) = self.starts[span];
        let is_rest =
            index == 0 && self.nodes[first].rests || index == times.intervals && next_rests;
        if is_rest {
            (rates.speed, rates.acceleration) = (0.0, 0.0);
        }
        rates
    }

    /// A waypoint of a span without its torques.
    pub fn state(&self, path: Path<'_>, span: usize, times: &SpanTimes, index: usize) -> Waypoint {
        let known = &path.spans[span];
        let points = &path.points[known.first..=known.last];
        let rates = self.rates_at(span, times, index);
        let (_, offset) = self.starts[span];
        let parameter = match index {
            0 => points[0].parameter,
            _ if index == times.intervals => points[points.len() - 1].parameter,
            _ => rates.position - offset,
        };
        timed(&state_at(points, parameter), &rates, times.at(index, times.intervals))
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

/// The path at a parameter among the points of a span, as a waypoint whose time is the parameter.
pub fn state_at(points: &[PathPoint], parameter: f64) -> Waypoint {
    let after = points.partition_point(|point| point.parameter <= parameter);
    let before = after.saturating_sub(1).min(points.len() - 2);
    let (a, b) = (waypoint_of(&points[before]), waypoint_of(&points[before + 1]));
    if parameter <= a.time {
        return a;
    }
    if parameter >= b.time { b } else { quintic_motion(&a, &b, parameter) }
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
