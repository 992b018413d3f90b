//! Plays the accepted chunks of plans in plan time: at full speed, braking where no chunk follows,
//! and standing.

use std::collections::{BTreeMap, VecDeque};

use bytemuck::Zeroable;
use surefoot_controller_sim::{ChunkWalk, Pace, PlanInstant};
use surefoot_shared_types::message::ramp::PlanTime;
use surefoot_shared_types::message::set_point::{
    FLAG_FINISHED, FLAG_MISSED, FLAG_STARVED, SET_POINT_SCHEMA,
};
use surefoot_shared_types::message::{Feedback, Interpolation, PlanChunk, SetPoint, Waypoint};

use crate::commands::sample::foot_schedule;

/// Largest distance of a plan's beginning from where the robot stands, rad or m.
const START_DISTANCE_MAX: f64 = 1e-6;

/// A plan and its epoch.
type PlanKey = (u64, u64);

/// The chunks that a sampler has received, and how far they are played.
#[derive(Default)]
pub(crate) struct Playback {
    /// Received and not accepted yet.
    waiting: BTreeMap<(PlanKey, u64), Box<PlanChunk>>,
    /// Accepted and not begun, in order.
    upcoming: VecDeque<Box<PlanChunk>>,
    /// The number of upcoming chunks that are announced.
    announced: usize,
    /// The plan whose acceptance is followed, and the sequence number accepted next.
    accepted: Option<(PlanKey, u64)>,
    current: Option<CurrentPlan>,
    /// The accepted chunks that were not received.
    missed: u64,
    /// Whether the rest of the plan cannot be played.
    is_broken: bool,
    ticks: u64,
    starved_ticks: u64,
}

/// The plan that is played.
struct CurrentPlan {
    key: PlanKey,
    walk: ChunkWalk,
}

/// What a playback has done.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct PlaybackCounts {
    /// Set-points.
    pub(crate) ticks: u64,
    /// Those while no chunk followed in time.
    pub(crate) starved_ticks: u64,
    /// Accepted chunks that were not received.
    pub(crate) missed: u64,
}

impl Playback {
    /// Keeps a received chunk until it is accepted. A repeated one replaces the one before.
    pub(crate) fn receive(&mut self, chunk: &PlanChunk) {
        let key = (chunk.plan_id, chunk.epoch);
        let is_over = self
            .accepted
            .is_some_and(|(plan, next)| key < plan || key == plan && chunk.sequence < next);
        if !is_over {
            self.waiting.insert((key, chunk.sequence), Box::new(*chunk));
        }
    }

    /// Takes over the chunks that a feedback accepts.
    pub(crate) fn accept(&mut self, feedback: &Feedback) {
        let key = (feedback.plan_id, feedback.epoch);
        let is_next = self.accepted.is_none_or(|(plan, _)| key > plan);
        let next = match self.accepted {
            Some((plan, next)) if plan == key => next,
            _ if is_next && feedback.next_sequence > 0 => 0,
            _ => return,
        };
        if is_next {
            self.is_broken = false;
        }
        for sequence in next..feedback.next_sequence {
            match self.waiting.remove(&(key, sequence)) {
                Some(chunk) if !self.is_broken => self.upcoming.push_back(chunk),
                Some(_) => {}
                None => {
                    self.missed += 1;
                    self.is_broken = true;
                }
            }
        }
        self.accepted = Some((key, feedback.next_sequence.max(next)));
        // The chunks of earlier plans are not accepted any more.
        self.waiting = self.waiting.split_off(&(key, 0));
    }

    /// The set-point after `seconds` more; `None` before the first plan.
    pub(crate) fn advance(&mut self, sampler_id: u64, seconds: f64) -> Option<SetPoint> {
        self.take_upcoming();
        let current = self.current.as_mut()?;
        current.walk.advance(seconds);
        let clock = current.walk.clock()?;
        let mut flags = 0;
        if clock.is_finished() {
            flags |= FLAG_FINISHED;
        } else if matches!(clock.pace(), Pace::Braking(..) | Pace::AtRest(_)) {
            flags |= FLAG_STARVED;
            self.starved_ticks += 1;
        }
        if self.is_broken {
            flags |= FLAG_MISSED;
        }
        self.ticks += 1;
        let point = current.set_point()?;
        Some(SetPoint { sampler_id, tick: self.ticks, flags, ..point })
    }

    /// The chunk that a set-point of the current plan lies in.
    pub(crate) fn chunk_of(&self, point: &SetPoint) -> Option<&PlanChunk> {
        let chunks = self.current.as_ref()?.walk.chunks();
        chunks.iter().find(|chunk| chunk.sequence == point.sequence)
    }

    /// Calls `announce` with each chunk that was accepted since the last call, and the seconds
    /// until it begins if the robot does not stop before.
    pub(crate) fn take_announced(&mut self, announce: &mut dyn FnMut(&PlanChunk, f64)) {
        let clock = self.current.as_ref().and_then(|current| current.walk.clock());
        let now = clock.map_or(0.0, |clock| clock.now().time);
        for chunk in self.upcoming.iter().skip(self.announced) {
            let begin = chunk.waypoints().first().map_or(now, |first| first.time);
            announce(chunk, begin - now);
        }
        self.announced = self.upcoming.len();
    }

    /// Whether all accepted chunks are played.
    pub(crate) fn is_idle(&self) -> bool {
        self.upcoming.is_empty()
            && self.current.as_ref().is_none_or(|current| current.walk.is_at_rest())
    }

    /// What the playback has done.
    pub(crate) fn counts(&self) -> PlaybackCounts {
        let Self { ticks, starved_ticks, missed, .. } = *self;
        PlaybackCounts { ticks, starved_ticks, missed }
    }

    /// Appends the accepted chunks of the current plan; begins the next plan once the robot stands.
    fn take_upcoming(&mut self) {
        while let Some(chunk) = self.upcoming.front() {
            let key = (chunk.plan_id, chunk.epoch);
            match &mut self.current {
                Some(current) if current.key == key => {}
                Some(current) if !current.walk.is_at_rest() => return,
                current => {
                    let begin = &chunk.waypoints()[0];
                    let held = current.as_ref().and_then(CurrentPlan::held);
                    if chunk.sequence != 0 || held.is_some_and(|held| is_apart(&held, begin)) {
                        self.is_broken = true;
                        self.pop_upcoming();
                        continue;
                    }
                    *current = Some(CurrentPlan { key, walk: ChunkWalk::default() });
                }
            }
            let chunk = self.pop_upcoming();
            let (Some(current), Some(chunk)) = (&mut self.current, chunk) else { return };
            current.walk.accept(&chunk);
        }
    }

    fn pop_upcoming(&mut self) -> Option<Box<PlanChunk>> {
        self.announced = self.announced.saturating_sub(1);
        self.upcoming.pop_front()
    }
}

impl CurrentPlan {
    /// Where the robot is.
    fn held(&self) -> Option<Waypoint> {
        self.set_point().map(|point| point.waypoint)
    }

    /// The set-point of this instant, without the sampler's own fields.
    fn set_point(&self) -> Option<SetPoint> {
        let PlanInstant { time, rate, rate_change } = self.walk.clock()?.now();
        let chunks = self.walk.chunks();
        let played = chunks.iter().find(|chunk| last_time(chunk) > time);
        let chunk = played.or(chunks.back())?;
        let interpolation = Interpolation::from_wire(chunk.interpolation)?;
        let planned = interpolation.sample(chunk.waypoints(), time);
        let waypoint = PlanTime { elapsed: time, rate, rate_change }.apply(&planned);
        Some(SetPoint {
            schema: SET_POINT_SCHEMA,
            session: chunk.session,
            plan_id: chunk.plan_id,
            epoch: chunk.epoch,
            sequence: chunk.sequence,
            mode: chunk.mode,
            rate,
            waypoint,
            feet: foot_schedule::schedule(chunk, chunks),
            ..SetPoint::zeroed()
        })
    }
}

fn last_time(chunk: &PlanChunk) -> f64 {
    chunk.waypoints().last().map_or(f64::NEG_INFINITY, |last| last.time)
}

/// Whether two waypoints are different configurations.
fn is_apart(a: &Waypoint, b: &Waypoint) -> bool {
    let numbers = |w: &Waypoint| w.root_position.into_iter().chain(w.root_rotation).chain(w.q);
    !numbers(a).zip(numbers(b)).all(|(a, b)| (a - b).abs() <= START_DISTANCE_MAX)
}

#[cfg(test)]
#[path = "playback_tests.rs"]
mod tests;
