//! The rounded motion of a timed path: its spans in time, and its waypoints.

use surefoot_shared_types::base::limits::{CHUNK_WAYPOINTS_MAX, JOINTS_MAX};
use surefoot_shared_types::message::{Interpolation, Waypoint};

use crate::timing::load_sharing::LoadSchedule;
use crate::timing::path_point::{PathPoint, PathSpan};
use crate::timing::path_timing::{Path, PathTiming};
use crate::timing::time_law::PathRates;

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
    /// A waypoint of a span without its torques.
    pub(super) fn state(
        &self,
        path: Path<'_>,
        span: usize,
        times: &SpanTimes,
        index: usize,
    ) -> Waypoint {
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

/// The path at a parameter among the points of a span, as a waypoint whose time is the parameter.
pub(super) fn state_at(points: &[PathPoint], parameter: f64) -> Waypoint {
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
