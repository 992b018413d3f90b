//! The motion of a robot as it was executed, with its stops: chunks like those of a plan, in the
//! robot's own time.

use surefoot_shared_types::base::limits::CHUNK_WAYPOINTS_MAX;
use surefoot_shared_types::message::{PlanChunk, Waypoint, WithCrc};

use crate::check::course::{PlanRate, at_rate};
use crate::execution::plan_clock::{Pace, PlanClock};
use crate::execution::plan_motion::planned_in;
use crate::execution::tuning::{RAMP_INTERVAL, STANDING_INTERVAL_MAX};

/// Instants nearer than this are one, s.
const SAME_INSTANT: f64 = 1e-6;
/// Halvings of a ramp's duration that locate an instant of plan time within it.
const HALVINGS: usize = 60;

/// The motion of one plan after the other.
#[derive(Debug, Clone, Default)]
pub struct ExecutedMotion {
    chunks: Vec<PlanChunk>,
    /// When the last plan ended, s.
    seconds: f64,
}

/// A plan, as far as it was executed.
pub(crate) struct PlanWalk<'a> {
    /// Its accepted chunks.
    pub(crate) chunks: &'a [PlanChunk],
    /// Its clock at the end.
    pub(crate) clock: &'a PlanClock,
}

/// An instant of a walk.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Instant {
    /// The robot's own time, s.
    at: f64,
    /// Plan time, s.
    planned: f64,
    /// Seconds of the plan a second, and the change of that a second.
    rates: [f64; 2],
}

impl ExecutedMotion {
    /// Adds a plan.
    pub(crate) fn add(&mut self, walk: &PlanWalk<'_>) {
        let instants = walk.instants();
        let begin = instants.first().map_or(0.0, |first| first.at);
        let mut next = 0;
        for chunk in walk.chunks {
            let Some([from, to]) = ends_of(chunk) else { continue };
            let first = (next..instants.len()).find(|&at| instants[at].planned >= from);
            let Some(first) = first.filter(|&at| instants[at].planned <= to) else { continue };
            let last = (first..instants.len()).take_while(|&at| instants[at].planned <= to).last();
            next = last.unwrap_or(first);
            let motion: Vec<Waypoint> = instants[first..=next]
                .iter()
                .map(|instant| instant.waypoint(chunk, self.seconds - begin))
                .collect();
            self.add_pieces(chunk, &motion);
        }
        self.seconds += instants.last().map_or(0.0, |last| last.at - begin);
    }

    /// All of it.
    pub fn finish(self) -> Vec<PlanChunk> {
        self.chunks
    }

    /// Adds the executed motion of a chunk, in pieces that share their ends.
    fn add_pieces(&mut self, chunk: &PlanChunk, motion: &[Waypoint]) {
        let mut first = 0;
        loop {
            let last = (first + CHUNK_WAYPOINTS_MAX - 1).min(motion.len() - 1);
            let mut piece = PlanChunk { sequence: self.chunks.len() as u64, ..*chunk };
            piece.waypoints = bytemuck::Zeroable::zeroed();
            piece.waypoints[..=last - first].copy_from_slice(&motion[first..=last]);
            piece.waypoints_len = (last - first + 1) as u32;
            (piece.brake_at, piece.brake_duration) = (motion[last].time, 0.0);
            piece.resume_duration = 0.0;
            piece.write_crc();
            self.chunks.push(piece);
            if last + 1 == motion.len() {
                return;
            }
            first = last;
        }
    }
}

fn ends_of(chunk: &PlanChunk) -> Option<[f64; 2]> {
    Some([chunk.waypoints().first()?.time, chunk.waypoints().last()?.time])
}

impl Instant {
    /// The robot, with `later` (s) added to its time.
    fn waypoint(&self, chunk: &PlanChunk, later: f64) -> Waypoint {
        let [rate, change] = self.rates;
        let waypoint = at_rate(planned_in(chunk, self.planned), rate, change);
        Waypoint { time: self.at + later, ..waypoint }
    }
}

impl PlanWalk<'_> {
    /// The instants of the walk: every waypoint of the plan that the robot passes, the beginning
    /// and the end of each pace, and instants in between where it brakes, stands and goes on.
    fn instants(&self) -> Vec<Instant> {
        let changes = self.clock.history();
        let mut instants: Vec<Instant> = Vec::new();
        for (index, change) in changes.iter().enumerate() {
            let end = changes.get(index + 1).map_or(self.clock.seconds(), |next| next.at);
            let waits = change.pace == Pace::AtRest(0);
            let found = if waits { Vec::new() } else { self.piece(change.pace, change.at, end) };
            for instant in found {
                let is_new = instants.last().is_none_or(|last| instant.at > last.at + SAME_INSTANT);
                // A transition between two modes is an instant of both.
                let is_end = self.is_end(instant.planned);
                match instants.last_mut() {
                    Some(last) if !is_new && is_end => *last = Instant { at: last.at, ..instant },
                    _ if is_new => instants.push(instant),
                    _ => {}
                }
            }
        }
        instants
    }

    /// Whether a chunk ends at a plan time (s).
    fn is_end(&self, planned: f64) -> bool {
        self.chunks.iter().filter_map(ends_of).any(|[_, end]| end == planned)
    }

    /// The instants of a pace between two times (s) of the robot.
    fn piece(&self, pace: Pace, begin: f64, end: f64) -> Vec<Instant> {
        let stops = self.clock.stops();
        match pace {
            Pace::Walking(from) => {
                let limit = self.end_of_plan();
                let to = (from + end - begin).min(limit);
                let at_full_speed = |planned: f64| {
                    let rates = [if planned < limit { 1.0 } else { 0.0 }, 0.0];
                    Instant { at: begin + planned - from, planned, rates }
                };
                let inside = self.waypoints_between(from, to).map(at_full_speed);
                [at_full_speed(from)].into_iter().chain(inside).chain([at_full_speed(to)]).collect()
            }
            Pace::AtRest(chunk) => {
                let planned = stops[chunk].rest_at();
                let count = ((end - begin) / STANDING_INTERVAL_MAX).ceil().max(1.0) as usize;
                let at = |index: usize| begin + (end - begin) * index as f64 / count as f64;
                let stands = |index| Instant { at: at(index), planned, rates: [0.0; 2] };
                (0..=count).map(stands).collect()
            }
            Pace::Braking(chunk, _) => {
                let stop = &stops[chunk];
                let ramp = Ramp { planned: stop.brake_at, seconds: stop.seconds, brakes: true };
                self.ramp(&ramp, begin, end)
            }
            Pace::GoingOn(chunk, _) => {
                let stop = &stops[chunk];
                let (planned, seconds) = (stop.rest_at(), stop.resume_seconds);
                self.ramp(&Ramp { planned, seconds, brakes: false }, begin, end)
            }
        }
    }

    fn ramp(&self, ramp: &Ramp, begin: f64, end: f64) -> Vec<Instant> {
        let limit = self.end_of_plan();
        let count = ((end - begin) / RAMP_INTERVAL).ceil().max(1.0) as usize;
        let on_grid = (0..=count).map(|index| (end - begin) * index as f64 / count as f64);
        let [first, last] = [0.0, end - begin].map(|after| ramp.at(after).planned);
        let passed =
            self.waypoints_between(first, last).map(|planned| (planned, ramp.when(planned)));
        let at_waypoint =
            |(planned, after): (f64, f64)| Instant { at: begin + after, planned, ..ramp.at(after) };
        let mut found: Vec<Instant> = on_grid
            .map(|after| Instant { at: begin + after, ..ramp.at(after) })
            .chain(passed.map(at_waypoint))
            .filter(|instant| instant.planned <= limit)
            .collect();
        found.sort_by(|a, b| a.at.total_cmp(&b.at));
        found
    }

    /// The times (s) of the plan's waypoints between two plan times.
    fn waypoints_between(&self, from: f64, to: f64) -> impl Iterator<Item = f64> {
        let times = self.chunks.iter().flat_map(PlanChunk::waypoints).map(|waypoint| waypoint.time);
        times.filter(move |time| (from..=to).contains(time))
    }

    fn end_of_plan(&self) -> f64 {
        self.chunks.iter().filter_map(ends_of).map(|[_, end]| end).fold(f64::NEG_INFINITY, f64::max)
    }
}

/// A ramp of plan time.
struct Ramp {
    /// Plan time at its beginning, s.
    planned: f64,
    seconds: f64,
    brakes: bool,
}

impl Ramp {
    /// The plan `after` s from the ramp's beginning on, in which the robot's own time is not set.
    fn at(&self, after: f64) -> Instant {
        let PlanRate { elapsed, rate, change } =
            PlanRate::of_ramp((after / self.seconds).min(1.0), self.seconds, self.brakes);
        Instant { at: 0.0, planned: self.planned + elapsed, rates: [rate, change] }
    }

    /// When the ramp reaches a plan time, s from its beginning on.
    fn when(&self, planned: f64) -> f64 {
        let (mut low, mut high) = (0.0, self.seconds);
        for _ in 0..HALVINGS {
            let middle = 0.5 * (low + high);
            if self.at(middle).planned < planned { low = middle } else { high = middle }
        }
        high
    }
}
