//! The timing of a path, piece by piece: rates at its points, the time-optimal profile, its
//! rounding, and the check of the rounded motion, which slows it down where it is beyond a limit.
//!
//! Points come in pieces. Each call of [`PathTiming::solve`] ends the path known so far at rest and
//! fixes the profile up to the touch-down before the last piece; so a fixed profile can always come
//! to rest within the known path. The rest of the path is timed anew when more of it is known.

use surefoot_shared_types::message::Waypoint;

use crate::base::arena::reserve;
use crate::base::capacity::ArenaFull;
use crate::timing::limit::BindingTimes;
use crate::timing::limits::Level;
use crate::timing::load_sharing::LoadSchedule;
use crate::timing::motion_changes::MotionChanges;
use crate::timing::path_point::Path;
use crate::timing::profile::{Node, binding, controllable, fastest};
use crate::timing::profile_check::ProfileCheck;
use crate::timing::slow_downs::SlowDowns;
use crate::timing::stops::{Stop, StopTable};
use crate::timing::time_law::TimeLaw;
use crate::timing::timed_motion::TimedMotion;
use crate::timing::timed_path::{SpanTimes, TimedPath, state_at};
use crate::timing::timed_robot::{PointLimits, TimedRobot, TimingMemory};
use crate::timing::tuning::{
    COP_MARGIN_EXTRA, INCLINED_RATES_PART, ROUNDING_TIME, ROUNDS_MAX, SLOW_DOWN, SLOW_DOWNS_MAX,
};

/// What happened while a path was timed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct TimingStats {
    /// Rests between the ends of the path.
    pub rests: u64,
    /// Points at which the robot cannot stand within the full margins, but within smaller ones.
    pub relaxed: u64,
    /// Points at which no contact forces within the limits hold the robot. It passes them slowly.
    pub unsupported: u64,
    /// Profiles that no slowing down brought within the limits.
    pub beyond: u64,
}

impl TimingStats {
    /// The sum of both.
    pub fn plus(&self, other: &Self) -> Self {
        Self {
            rests: self.rests + other.rests,
            relaxed: self.relaxed + other.relaxed,
            unsupported: self.unsupported + other.unsupported,
            beyond: self.beyond + other.beyond,
        }
    }
}

/// The timing of one path.
#[derive(Debug)]
pub struct PathTiming {
    robot: TimedRobot,
    memory: Box<TimingMemory>,
    timed: TimedPath,
    profile: Profile,
    slow_downs: SlowDowns,
    changes: MotionChanges,
    stops: StopTable,
    stats: TimingStats,
}

/// Squared speeds at the nodes.
#[derive(Debug)]
struct Profile {
    ceilings: Vec<f64>,
    speeds: Vec<f64>,
    /// The speeds of the last profile within the limits, which ends at rest.
    accepted: Vec<f64>,
    /// Number of spans of that profile.
    accepted_spans: usize,
    /// Number of nodes whose speeds are fixed.
    fixed: usize,
    /// Number of spans known in the last search.
    solved_spans: usize,
}

impl PathTiming {
    /// Reserves memory for paths of `points_max` points.
    pub fn new(robot: TimedRobot, points_max: usize) -> Self {
        let timed = TimedPath::new(points_max);
        let nodes_max = timed.nodes.capacity();
        Self {
            robot,
            memory: Box::default(),
            timed,
            profile: Profile {
                ceilings: reserve(nodes_max),
                speeds: reserve(nodes_max),
                accepted: reserve(nodes_max),
                accepted_spans: 0,
                fixed: 0,
                solved_spans: 0,
            },
            slow_downs: SlowDowns::new(nodes_max),
            changes: MotionChanges::new(nodes_max, points_max),
            stops: StopTable::new(nodes_max),
            stats: TimingStats::default(),
        }
    }

    /// Begins a path.
    pub fn begin(&mut self) {
        self.timed.begin();
        let profile = &mut self.profile;
        for list in [&mut profile.ceilings, &mut profile.speeds, &mut profile.accepted] {
            list.clear();
        }
        (profile.accepted_spans, profile.fixed, profile.solved_spans) = (0, 0, 0);
        self.slow_downs.begin();
        self.changes.begin();
        self.stops.begin();
        self.stats = TimingStats::default();
    }

    /// What happened so far.
    pub fn stats(&self) -> TimingStats {
        self.stats
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        let nodes_max = self.timed.nodes.capacity();
        let tables = self.changes.bytes() + self.stops.bytes();
        self.timed.bytes() + tables + 4 * nodes_max * size_of::<f64>()
    }

    /// The unrounded profile: the nodes with their squared speeds.
    pub fn nodes(&self) -> impl Iterator<Item = (&Node, f64)> {
        self.timed.nodes.iter().zip(self.profile.speeds.iter().copied())
    }

    /// The rounded time law.
    pub fn law(&self) -> &TimeLaw {
        &self.timed.law
    }

    /// Adds the next span of a path: the rates at its points.
    ///
    /// # Errors
    /// The memory for nodes is used up.
    pub fn add_span(&mut self, path: Path<'_>) -> Result<(), ArenaFull> {
        let index = self.timed.spans();
        let span = &path.spans[index];
        let points = &path.points[span.first..=span.last];
        let has_one_cell = points.len() == 2;
        let count = points.len() + usize::from(has_one_cell);
        if self.timed.nodes.len() + count > self.timed.nodes.capacity() {
            return Err(ArenaFull::Waypoints);
        }
        let position = self.timed.nodes.last().map_or(0.0, |last| last.position);
        let offset = position - points[0].parameter;
        self.timed.starts.push((self.timed.nodes.len(), offset));
        self.changes.push_span();
        let contacts = self.robot.span_contacts(span, COP_MARGIN_EXTRA);
        let landing = self.robot.landing(&contacts, &points[points.len() - 1]);
        let part = if contacts.is_inclined { INCLINED_RATES_PART } else { 1.0 };
        let parameter_of = |at: usize| match (has_one_cell, at) {
            (true, 1) => 0.5 * (points[0].parameter + points[1].parameter),
            (true, 2) => points[1].parameter,
            _ => points[at].parameter,
        };
        for at in 0..count {
            let parameter = parameter_of(at);
            let state = state_at(points, parameter);
            let next = parameter_of((at + 1).min(count - 1));
            let inner = [1.0, 2.0].map(|part| {
                let state = state_at(points, parameter + part / 3.0 * (next - parameter));
                self.robot.load_by_speed(&mut self.memory, &contacts.ground, &state)
            });
            let landing = (landing.as_ref(), at + 1 == count);
            let PointLimits { rates, level, balance } =
                self.robot.rates(&mut self.memory, &contacts, &state, landing);
            self.stats.relaxed += u64::from(level > Level::Full);
            self.stats.unsupported += u64::from(level == Level::Unsupported);
            self.timed.nodes.push(Node {
                position: parameter + offset,
                rests: at == 0 && (span.starts_at_rest || index == 0),
                rates,
                part,
                factor: part,
                level,
                balance,
                inner,
            });
            self.profile.ceilings.push(0.0);
            self.profile.speeds.push(0.0);
            self.slow_downs.push();
            self.changes.push_node();
        }
        self.stats.rests += u64::from(index > 0 && span.starts_at_rest);
        Ok(())
    }

    /// Times the path known so far, at rest at its end, and fixes the profile of the first
    /// `fixed_spans` spans; the motion of the first `written_spans` is written already. Every chunk
    /// has a stop. Bounded: at most `ROUNDS_MAX + SLOW_DOWNS_MAX` rounds, twice. Returns `false`
    /// where no profile is within the limits, however slow: then the path has to end at the last
    /// rest.
    pub fn solve(&mut self, path: Path<'_>, fixed_spans: usize, written_spans: usize) -> bool {
        self.stops.keep_from(written_spans);
        let is_within =
            self.search(path) || self.rest_where_the_last_one_ends() && self.search(path);
        if !is_within {
            self.stats.beyond += 1;
            return false;
        }
        self.profile.accepted.clear();
        self.profile.accepted.extend_from_slice(&self.profile.speeds);
        self.profile.accepted_spans = self.timed.spans();
        self.profile.fixed = self.timed.first_node(fixed_spans).max(self.profile.fixed);
        true
    }

    /// The duration (s) of the fastest profile of the path known so far, which begins anew: not
    /// rounded, and not checked as a motion. `None` where there is none.
    pub fn fastest_seconds(&mut self) -> Option<f64> {
        let last = self.spans().checked_sub(1)?;
        self.profile_round().then(|| self.span_times(last).end)
    }

    /// Ends the path where the last profile within the limits ends, at rest, and takes that
    /// profile. Returns the number of its spans; 0 where there is none. `path` is the one of the
    /// last [`PathTiming::solve`].
    pub fn end_at_last_rest(&mut self, path: Path<'_>) -> usize {
        let Profile { accepted, accepted_spans, .. } = &self.profile;
        let (nodes, spans) = (accepted.len(), *accepted_spans);
        if spans == 0 {
            return 0;
        }
        self.timed.truncate(nodes, spans);
        self.profile.speeds.clear();
        self.profile.speeds.extend_from_slice(&self.profile.accepted);
        self.profile.ceilings.truncate(nodes);
        self.slow_downs.truncate(nodes);
        self.changes.truncate(nodes, spans);
        self.rebuild_law(0);
        self.profile.fixed = nodes;
        let _as_before = self.is_within(Path { spans: &path.spans[..spans], ..path });
        spans
    }

    /// Slows the open part down until its rounded motion is within the limits. Returns whether it
    /// is. An open part that begins in motion cannot be slowed down as a whole.
    fn search(&mut self, path: Path<'_>) -> bool {
        self.forget_the_last_end();
        let last = self.profile.fixed.checked_sub(1);
        self.slow_downs.keep_before(last.unwrap_or(0));
        let begins_at_rest = last.is_none_or(|node| self.profile.speeds[node] == 0.0);
        for round in 0..ROUNDS_MAX + SLOW_DOWNS_MAX {
            let could = self.profile_round();
            if could && self.is_within(path) {
                return true;
            }
            let everywhere = !could || round >= ROUNDS_MAX;
            if everywhere && !begins_at_rest {
                return false;
            }
            self.slow_down(everywhere);
        }
        false
    }

    /// Allows the whole rates again in the last two spans of the search before: there they were
    /// shrunk for the rest at their end.
    fn forget_the_last_end(&mut self) {
        let span = self.profile.solved_spans.saturating_sub(2);
        let node = self.timed.starts.get(span).map_or(0, |(node, _)| *node);
        let open = &mut self.timed.nodes[node.max(self.profile.fixed)..];
        open.iter_mut().for_each(|node| node.factor = node.part);
        self.profile.solved_spans = self.timed.spans();
    }

    /// Computes the profile and its time law. Returns whether the open part can go on from the
    /// fixed one.
    fn profile_round(&mut self) -> bool {
        let first = self.profile.fixed.saturating_sub(1);
        let nodes = &self.timed.nodes[first..];
        controllable(nodes, &mut self.profile.ceilings[first..]);
        let could =
            fastest(nodes, &self.profile.ceilings[first..], &mut self.profile.speeds[first..]);
        self.rebuild_law(first);
        could
    }

    /// Computes the time law from a node on.
    fn rebuild_law(&mut self, first: usize) {
        self.timed.rebuild_law(first, &self.profile.speeds);
        self.changes.note(first, &self.timed, &self.profile.speeds);
    }

    /// Takes the last profile within the limits up to the rest at its end. Returns whether that is
    /// beyond the fixed part.
    fn rest_where_the_last_one_ends(&mut self) -> bool {
        let end = self.profile.accepted.len();
        if self.profile.fixed == 0 || end <= self.profile.fixed || end >= self.timed.nodes.len() {
            return false;
        }
        self.profile.speeds[..end].copy_from_slice(&self.profile.accepted);
        self.timed.nodes[end].rests = true;
        self.changes.rest_at(end);
        self.timed.nodes[end..].iter_mut().for_each(|node| node.factor = node.part);
        self.profile.speeds[end] = 0.0;
        let first = self.profile.fixed.saturating_sub(1);
        self.rebuild_law(first);
        self.profile.fixed = end;
        self.stats.rests += 1;
        true
    }

    /// Shrinks the rates of the open nodes: where the last check asks for it, or all of them.
    fn slow_down(&mut self, everywhere: bool) {
        let first = self.profile.fixed.saturating_sub(1);
        for (node, slower) in self.timed.nodes[first..].iter_mut().zip(self.slow_downs.take()) {
            node.factor *= if everywhere { SLOW_DOWN } else { slower };
        }
    }

    /// Whether the rounded motion is within the limits and every chunk has a stop. Notes where to
    /// slow down if not.
    fn is_within(&mut self, path: Path<'_>) -> bool {
        let Self { robot, memory, timed, slow_downs, changes, stops, .. } = self;
        let first = self.profile.fixed.saturating_sub(1);
        let open = if first > 0 { timed.law.time_of_node(first) } else { 0.0 };
        // Before that the rounded motion depends on fixed nodes alone.
        let from = open - if first > 0 { 0.5 * ROUNDING_TIME } else { 0.0 };
        let mut check = ProfileCheck { robot, memory, path, timed, slow_downs, changes };
        if !(check.rates_are_within(open) && check.motion_is_within(from)) {
            return false;
        }
        stops.find(&mut TimedMotion::new(robot, memory, path, timed), slow_downs)
    }

    /// Number of spans known so far.
    pub fn spans(&self) -> usize {
        self.timed.spans()
    }

    /// How long each limit binds the unrounded motion of a chunk of a span. A cell counts for the
    /// chunk in which its middle is.
    pub fn binding_times(&self, span: usize, chunk: usize) -> BindingTimes {
        let Self { timed, profile, .. } = self;
        let known = timed.span_times(span);
        let end_of = |chunk: usize| known.chunk_times(chunk)[1];
        let from = chunk.checked_sub(1).map_or(f64::NEG_INFINITY, end_of);
        let until = if chunk + 1 < known.chunks() { end_of(chunk) } else { f64::INFINITY };
        let mut times = BindingTimes::default();
        let end = timed.first_node(span + 1).min(timed.nodes.len() - 1);
        for index in timed.first_node(span)..end {
            let [begin, end] = [index, index + 1].map(|at| timed.law.time_of_node(at));
            if (from..until).contains(&(0.5 * (begin + end))) {
                let [node, next] = [index, index + 1].map(|at| &timed.nodes[at]);
                let speeds = [index, index + 1].map(|at| profile.speeds[at]);
                let is_slowed = node.factor < node.part || next.factor < next.part;
                times.add(binding([node, next], speeds), end - begin, is_slowed);
            }
        }
        times
    }

    /// The times of a span.
    pub fn span_times(&self, span: usize) -> SpanTimes {
        self.timed.span_times(span)
    }

    /// A waypoint at rest on a span at a value of the path's parameter, with its feed-forward
    /// torques.
    pub fn resting_waypoint(
        &mut self,
        path: Path<'_>,
        span: usize,
        parameter: f64,
        schedule: &LoadSchedule,
    ) -> Waypoint {
        let known = &path.spans[span];
        let points = &path.points[known.first..=known.last];
        let [begin, end] = [&points[0], &points[points.len() - 1]].map(|point| point.parameter);
        let mut waypoint = state_at(points, parameter).rested();
        let progress = (parameter - begin) / (end - begin);
        let at = (schedule, progress);
        self.robot.write_torques(&mut self.memory, known, Level::Bare, at, &mut waypoint);
        waypoint
    }

    /// The number of spans whose motion does not change any more; `is_complete`: whether the path
    /// is. Written spans are among them.
    pub fn final_spans(&self, is_complete: bool) -> usize {
        if is_complete {
            return self.spans();
        }
        let Some(last) = self.profile.fixed.checked_sub(1) else { return 0 };
        let fixed = self.timed.law.time_of_node(last) - 0.5 * ROUNDING_TIME;
        let ends = |span: &usize| self.span_times(*span).end <= fixed;
        let written = self.stops.first();
        written + (written..self.spans()).take_while(ends).count()
    }

    /// The stop of a chunk of a span that is not written, as the last profile has it; `None` where
    /// that has none.
    pub fn stop(&self, span: usize, chunk: usize) -> Option<Stop> {
        self.stops.stop(span, chunk)
    }

    /// A waypoint of a span with its feed-forward torques.
    pub fn waypoint(
        &mut self,
        path: Path<'_>,
        span: usize,
        (times, index): (&SpanTimes, usize),
        schedule: &LoadSchedule,
    ) -> Waypoint {
        let mut waypoint = self.timed.state(path, span, times, index);
        let position = self.timed.law.at(waypoint.time).position;
        let (node, _) = self.timed.node_before(span, position);
        let progress = index as f64 / times.intervals as f64;
        let level = self.timed.nodes[node].level;
        let (known, at) = (&path.spans[span], (schedule, progress));
        self.robot.write_torques(&mut self.memory, known, level, at, &mut waypoint);
        waypoint
    }
}
