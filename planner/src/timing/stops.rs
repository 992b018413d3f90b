//! Where and how a chunk brakes if the next one is not there, and how the robot goes on from there.
//!
//! The rate of plan time falls along a smooth ramp (`surefoot_shared_types::message::Ramp`) and the
//! robot comes to rest inside the chunk; the shortest ramp within the limits begins last. A ramp
//! may begin before a short chunk does, but not before the one of the chunk before it: until then
//! the robot does not brake. So stops are found from the last chunk known to the first. Nor does a
//! ramp begin before a rest of the plan that lies before its chunk: the chunk that ends there stops
//! there.

use surefoot_shared_types::message::{PlanTime, Ramp};

use crate::base::arena::reserve;
use crate::timing::slow_downs::SlowDowns;
use crate::timing::timed_motion::TimedMotion;
use crate::timing::tuning::{
    INTERVAL_MAX, RAMP_PARTS, RAMP_SAMPLES, RAMP_SHARE_MAX, RAMP_STEP, RAMP_STEPS_MAX,
    RATES_SHARE_MAX, REST_PLACES, SLOWER_BEFORE_STOP,
};

/// The braking ramp of a chunk, and the ramp with which the robot goes on after it.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Stop {
    /// The plan time at which the robot begins to brake, s.
    pub brake_at: f64,
    /// How long it brakes, s; 0 for a chunk that ends at rest.
    pub brake_duration: f64,
    /// How long it takes to go on at full speed, s.
    pub resume_duration: f64,
}

/// The brakes of the chunks that are not written.
#[derive(Debug)]
pub struct StopTable {
    /// The first span that is not written.
    first: usize,
    /// When the last chunk before it brakes, s.
    brake_after: f64,
    /// The last chunk first.
    brakes: Vec<Brake>,
}

/// The brake of a chunk.
#[derive(Debug, Clone, Copy)]
struct Brake {
    span: usize,
    chunk: usize,
    at: f64,
    duration: f64,
    /// How long the robot takes to go on, s; `None` where no ramp is within the limits.
    resume: Option<f64>,
}

impl StopTable {
    /// Reserves memory for this many chunks.
    pub fn new(chunks_max: usize) -> Self {
        Self { first: 0, brake_after: 0.0, brakes: reserve(chunks_max) }
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.brakes.capacity() * size_of::<Brake>()
    }

    /// Begins a path.
    pub fn begin(&mut self) {
        (self.first, self.brake_after) = (0, 0.0);
        self.brakes.clear();
    }

    /// The first span that is not written.
    pub fn first(&self) -> usize {
        self.first
    }

    /// The spans before `span` are written: their stops do not change any more.
    pub fn keep_from(&mut self, span: usize) {
        if let Some(last) = self.brakes.iter().find(|brake| brake.span < span) {
            self.brake_after = last.at;
        }
        self.first = span;
    }

    /// The stop of a chunk of a span that is not written, as the last profile has it. `None` where
    /// the profile has none, or the memory for stops is used up.
    pub(super) fn stop(&self, span: usize, chunk: usize) -> Option<Stop> {
        let is_after = |brake: &Brake| (brake.span, brake.chunk) > (span, chunk);
        let brake = self.brakes.get(self.brakes.partition_point(is_after))?;
        let Brake { at: brake_at, duration: brake_duration, resume, .. } = *brake;
        let is_found = (brake.span, brake.chunk) == (span, chunk);
        let resume_duration = resume.filter(|_| is_found)?;
        Some(Stop { brake_at, brake_duration, resume_duration })
    }

    /// Finds a stop for every chunk that is not written: of the ramps within the limits that end
    /// inside the chunk, the one that begins last, but not after that of the next chunk. Where
    /// there is none, notes where to slow down, and returns `false`.
    pub(super) fn find(
        &mut self,
        motion: &mut TimedMotion<'_>,
        slow_downs: &mut SlowDowns,
    ) -> bool {
        let timed = motion.timed;
        self.brakes.clear();
        let (mut latest, mut finds_all) = (f64::INFINITY, true);
        for span in (self.first..timed.spans()).rev() {
            let times = timed.span_times(span);
            let after = self.brake_after.max(timed.last_rest(span));
            for chunk in (0..times.chunks()).rev() {
                let [begin, end] = times.chunk_times(chunk);
                let has_memory = self.brakes.len() < self.brakes.capacity();
                let found = brake(motion, [after, latest], [begin, end]);
                match found.filter(|_| has_memory) {
                    Some((at, duration, resume)) => {
                        self.brakes.push(Brake { span, chunk, at, duration, resume });
                        latest = at;
                    }
                    None => {
                        slow_downs.ask_between(timed, after.max(end - SLOWER_BEFORE_STOP), end);
                        latest = latest.min(begin);
                        finds_all = false;
                    }
                }
            }
        }
        finds_all
    }
}

/// Beginning and duration (s) of the latest ramp within the limits that begins between these
/// times and ends between `begin` and `end`, and how long (s) the robot takes to go on after it.
fn brake(
    motion: &mut TimedMotion<'_>,
    [after, before]: [f64; 2],
    [begin, end]: [f64; 2],
) -> Option<(f64, f64, Option<f64>)> {
    if motion.timed.law.at(end).speed <= REST_SPEED {
        return Some((end, 0.0, resume_duration(motion, end)));
    }
    let mut best: Option<(f64, f64, Option<f64>)> = None;
    for part in 0..REST_PLACES {
        let rest = end - (end - begin) * part as f64 / REST_PLACES as f64;
        let mut seconds = motion.ramp_seconds_min().max(2.0 * (rest - before));
        for _ in 0..RAMP_STEPS_MAX {
            let brake_at = rest - 0.5 * seconds;
            if brake_at < after || best.is_some_and(|(latest, ..)| brake_at <= latest) {
                break;
            }
            if ramp_holds(motion, brake_at, Ramp::Brake { seconds }) {
                let resume = resume_duration(motion, rest);
                best = resume.map(|_| (brake_at, seconds, resume)).or(best);
                break;
            }
            seconds *= RAMP_STEP;
        }
    }
    best
}

/// The shortest ramp within the limits of the path known so far, in the same steps, by which the
/// robot goes on after a rest at `time`.
fn resume_duration(motion: &mut TimedMotion<'_>, time: f64) -> Option<f64> {
    let durations =
        std::iter::successors(Some(motion.ramp_seconds_min()), |seconds| Some(seconds * RAMP_STEP));
    durations
        .take(RAMP_STEPS_MAX)
        .find(|&seconds| ramp_holds(motion, time, Ramp::Resume { seconds }))
}

/// Whether a ramp that begins at plan time `begin` (s) takes no more of the rates around than they
/// allow, or, within their distance to the limits, than the motion at full speed takes; and whether
/// the zero-moment point keeps the controller's margin and contact forces move the robot. All are
/// looked at [`RAMP_PARTS`] times between any two waypoints, because the acceleration of a motion
/// may change within that time, and before that at few places, where most ramps fail.
fn ramp_holds(motion: &mut TimedMotion<'_>, begin: f64, ramp: Ramp) -> bool {
    let timed = motion.timed;
    let samples = |count: usize| {
        (0..=count).map(move |sample| {
            let at = ramp.at(ramp.seconds() * sample as f64 / count as f64);
            ((begin + at.elapsed).min(timed.law.end()), at)
        })
    };
    let has_rates = |(time, at): (f64, PlanTime)| {
        let share = timed.share_at(time, at.rate, at.rate_change);
        share <= RAMP_SHARE_MAX
            || share <= RATES_SHARE_MAX && share <= timed.share_at(time, 1.0, 0.0)
    };
    let fine = RAMP_PARTS * libm::ceil(ramp.seconds() / INTERVAL_MAX) as usize;
    samples(RAMP_SAMPLES).all(has_rates)
        && samples(RAMP_SAMPLES.max(fine))
            .all(|(time, at)| has_rates((time, at)) && motion.holds(time, &at))
}

/// Speed along the path below which it rests.
const REST_SPEED: f64 = 1e-9;
