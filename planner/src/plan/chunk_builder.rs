//! Splits a walk into plan chunks at waypoints, which are all statically stable, computes their
//! times and finalizes them.

use bytemuck::Zeroable;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::base::limits::{CHUNK_BINDINGS_MAX, CHUNK_WAYPOINTS_MAX};
use surefoot_shared_types::config::scenario::StancePose;
use surefoot_shared_types::message::chunk::{CHUNK_SCHEMA, FLAG_FIRST, FLAG_LAST};
use surefoot_shared_types::message::{
    ChunkBinding, Contact, Interpolation, PlanChunk, SupportMode, Waypoint,
};

use crate::base::arena::zeroed;
use crate::base::capacity::ArenaFull;
use crate::base::threads::Threads;
use crate::constraints::foothold::Foothold;
use crate::plan::time_parameterization::{TimeParameterization, accumulate};
use crate::robot::configuration::Configuration;
use crate::timing::ground::Ground;
use crate::timing::path_point::PathSpan;
use crate::timing::stops::Stop;

/// Most waypoints of a chunk after its first one.
const STEPS_MAX: usize = CHUNK_WAYPOINTS_MAX - 1;

/// The inputs of a plan, as every chunk names them.
#[derive(Debug, Clone, Copy)]
pub struct Provenance {
    /// Digest of the robot.
    pub robot: Digest,
    /// Digest of the world.
    pub world: Digest,
    /// Digest of the scenario.
    pub config: Digest,
    /// Number of joints in use.
    pub joints_len: usize,
    /// The goal that the plan was asked for.
    pub goal: StancePose,
}

/// Most motions that are written in parallel.
pub const PARALLEL_MOTIONS_MAX: usize = 32;

/// A motion within one mode.
#[derive(Debug, Clone)]
pub struct ModeMotion<'a> {
    /// The supporting feet.
    pub support: SupportMode,
    /// The footholds of the feet that stand.
    pub stance: heapless::Vec<&'a Foothold, 2>,
    /// Its first configuration.
    pub first: Configuration,
    /// The configurations after that.
    pub path: &'a [Configuration],
}

impl ModeMotion<'_> {
    /// The number of its chunks.
    fn chunks(&self) -> usize {
        self.path.len().div_ceil(STEPS_MAX)
    }
}

/// Builds a plan's chunks into an arena allocated once.
#[derive(Debug)]
pub struct ChunkBuilder {
    /// All chunks; those that are not written are zero.
    chunks: Vec<PlanChunk>,
    written: usize,
    waypoints_max: u64,
    provenance: Provenance,
    timing: TimeParameterization,
    waypoints: u64,
    /// Number of chunks that retrace, before those of the walk.
    retraced: usize,
    /// The last waypoint of a smooth path so far: of a timed one in the path's time.
    last_timed: Option<Waypoint>,
    finalized: FinalizedStream,
}

/// A part of a timed path that becomes one chunk.
#[derive(Debug, Clone, Copy)]
pub struct TimedPart<'a> {
    /// The span that it is part of.
    pub span: &'a PathSpan,
    /// How the robot stops in it.
    pub stop: Stop,
    /// What binds it.
    pub binding: [ChunkBinding; CHUNK_BINDINGS_MAX],
}

/// State of the stream after the finalized chunks.
#[derive(Debug)]
struct FinalizedStream {
    plan_id: u64,
    epoch: u64,
    /// Number of finalized chunks.
    count: usize,
    /// The time at which they end, s.
    time: f64,
    /// By chunk: whether it rests at every waypoint.
    is_resting: Vec<bool>,
    /// The time at which the timed path begins that is finalized, s.
    path_begin: Option<f64>,
    /// Digest of the stream up to their end.
    stream: Digest,
}

/// Independent work on chunks.
enum Task<'a> {
    Finalize { chunks: &'a mut [PlanChunk], finalized: &'a mut FinalizedStream },
    Write { chunks: &'a mut [PlanChunk], motion: &'a ModeMotion<'a> },
}

impl ChunkBuilder {
    /// Reserves memory for plans of `waypoints_max` waypoints.
    pub fn new(waypoints_max: usize, provenance: Provenance, timing: TimeParameterization) -> Self {
        let chunks_max = waypoints_max.div_ceil(STEPS_MAX) + waypoints_max / 16;
        Self {
            chunks: zeroed(chunks_max),
            written: 0,
            waypoints_max: waypoints_max as u64,
            provenance,
            timing,
            waypoints: 0,
            retraced: 0,
            last_timed: None,
            finalized: FinalizedStream {
                plan_id: 1,
                epoch: 0,
                count: 0,
                time: 0.0,
                is_resting: vec![false; chunks_max],
                path_begin: None,
                stream: Digest::default(),
            },
        }
    }

    /// Sets the plan's number in its session and its epoch, the number of replans. Both are 1 and 0
    /// at first. Must be called before any chunk is finalized.
    pub fn set_plan_id(&mut self, plan_id: u64, epoch: u64) {
        (self.finalized.plan_id, self.finalized.epoch) = (plan_id, epoch);
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.chunks.len() * (size_of::<PlanChunk>() + size_of::<bool>())
    }

    /// The chunks built so far.
    pub fn chunks(&self) -> &[PlanChunk] {
        &self.chunks[..self.written]
    }

    /// The chunks that are finalized.
    pub fn finalized(&self) -> &[PlanChunk] {
        &self.chunks[..self.finalized.count]
    }

    /// Number of waypoints of the plan. A waypoint that two chunks share counts once.
    pub fn waypoints(&self) -> u64 {
        self.waypoints
    }

    /// The contacts on which the robot stands at the end of the chunks that retrace; none where
    /// there are no such chunks.
    pub fn stance_retraced_to(&self) -> &[Contact] {
        self.chunks[..self.retraced].last().map_or(&[], PlanChunk::contacts)
    }

    /// Appends the motion of an executed chunk in reverse: from `end` through `before`, the
    /// waypoints before it, the last one first. With `rests` it rests at every waypoint, as a plan
    /// that consists of polynomials states it, with the feed-forward torques at rest.
    ///
    /// # Errors
    /// The arena is full.
    pub fn append_reversed<'a>(
        &mut self,
        executed: &PlanChunk,
        (end, before): (&'a Waypoint, impl Iterator<Item = &'a Waypoint> + Clone),
        rests: bool,
    ) -> Result<(), ArenaFull> {
        let at = self.written;
        self.reserve(before.clone().count(), 1)?;
        self.retraced = self.written;
        let (chunk, contacts) = (&mut self.chunks[at], executed.contacts());
        let rested = if rests { standing } else { Waypoint::rested };
        let waypoints = std::iter::once(end).chain(before).map(rested);
        let ground = Ground::under(contacts);
        let inputs = (&self.provenance, &self.timing);
        write(chunk, inputs, executed.mode, (contacts, &ground), waypoints);
        if rests {
            chunk.interpolation = Interpolation::Quintic as u64;
            self.rest_at_waypoints(at, &ground);
            self.last_timed = self.chunks[at].waypoints().last().copied();
        }
        Ok(())
    }

    /// Times a chunk whose robot rests at every waypoint.
    fn rest_at_waypoints(&mut self, at: usize, ground: &Ground) {
        let chunk = &mut self.chunks[at];
        let used = chunk.waypoints_len as usize;
        self.timing.set_intervals_between_rests(&mut chunk.waypoints[..used], ground);
        self.finalized.is_resting[at] = true;
    }

    /// Reserves the chunk of a part of a path, and writes all but its times. Returns its index.
    fn write_part(
        &mut self,
        span: &PathSpan,
        waypoints: impl ExactSizeIterator<Item = Waypoint>,
    ) -> Result<usize, ArenaFull> {
        let at = self.written;
        self.reserve(waypoints.len() - 1, 1)?;
        let chunk = &mut self.chunks[at];
        write_header(chunk, &self.provenance, span.support as u32, &span.contacts);
        chunk.interpolation = Interpolation::Quintic as u64;
        write_waypoints(chunk, waypoints);
        Ok(at)
    }

    /// Appends a part of a path without a timing: the robot rests at every waypoint. The first one
    /// is replaced by the last one before.
    ///
    /// # Errors
    /// The arena is full.
    pub fn append_resting(
        &mut self,
        span: &PathSpan,
        waypoints: impl ExactSizeIterator<Item = Waypoint>,
    ) -> Result<(), ArenaFull> {
        let at = self.write_part(span, waypoints)?;
        let first = &mut self.chunks[at].waypoints[0];
        *first = Waypoint { time: 0.0, ..self.last_timed.unwrap_or(*first) };
        self.rest_at_waypoints(at, &Ground::under(&span.contacts));
        self.last_timed = self.chunks[at].waypoints().last().copied();
        Ok(())
    }

    /// Appends motions and finalizes at most `finalized_max` of the chunks before them: times, plan
    /// id, sequence number, flags and digest. The last chunk is finalized by
    /// [`ChunkBuilder::finalize_last`]. Returns the number of finalized chunks.
    ///
    /// # Errors
    /// The arena is full.
    pub fn append(
        &mut self,
        motions: &[ModeMotion<'_>],
        finalized_max: usize,
        threads: &Threads,
    ) -> Result<usize, ArenaFull> {
        let (finalized, before) = (self.finalized.count, self.written);
        for motion in motions {
            self.reserve(motion.path.len(), motion.chunks())?;
        }
        let finalized_max = finalized_max.min(before.saturating_sub(finalized + 1));
        let (old, mut new) = self.chunks.split_at_mut(before);
        let mut tasks = heapless::Vec::<Task<'_>, { PARALLEL_MOTIONS_MAX + 1 }>::new();
        let _first = tasks.push(Task::Finalize {
            chunks: &mut old[finalized..finalized + finalized_max],
            finalized: &mut self.finalized,
        });
        for motion in motions {
            let (chunks, rest) = new.split_at_mut(motion.chunks());
            new = rest;
            let _fits = tasks.push(Task::Write { chunks, motion });
        }
        let inputs = (&self.provenance, &self.timing);
        threads.for_each(&mut tasks, |task| task.run(inputs));
        Ok(finalized_max)
    }

    /// Appends a part of a timed path, whose waypoints carry the path's time. Its first waypoint is
    /// replaced by the last one of the part before.
    ///
    /// # Errors
    /// The arena is full.
    pub fn append_timed(
        &mut self,
        part: TimedPart<'_>,
        waypoints: impl ExactSizeIterator<Item = Waypoint>,
    ) -> Result<(), ArenaFull> {
        let at = self.write_part(part.span, waypoints)?;
        let chunk = &mut self.chunks[at];
        chunk.brake_at = part.stop.brake_at;
        chunk.brake_duration = part.stop.brake_duration;
        chunk.resume_duration = part.stop.resume_duration;
        chunk.binding = part.binding;
        if let Some(last) = self.last_timed {
            let follows_rests = at > 0 && self.finalized.is_resting[at - 1];
            let time = if follows_rests { chunk.waypoints[0].time } else { last.time };
            chunk.waypoints[0] = Waypoint { time, ..last };
        }
        self.last_timed = chunk.waypoints().last().copied();
        Ok(())
    }

    /// Finalizes the chunks before the last one, at most `finalized_max`. Returns their number.
    pub fn finalize(&mut self, finalized_max: usize) -> usize {
        let count = finalized_max.min(self.unfinalized().saturating_sub(1));
        let first = self.finalized.count;
        for chunk in &mut self.chunks[first..first + count] {
            self.finalized.finalize(chunk);
        }
        count
    }

    /// Finalizes the last chunk of a complete plan. Returns the digest of the plan.
    pub fn finalize_last(&mut self) -> Digest {
        if let Some(last) = self.chunks[self.finalized.count..self.written].last_mut() {
            last.flags = FLAG_LAST;
            self.finalized.finalize(last);
        }
        self.finalized.stream
    }

    /// When the finalized chunks end, s.
    pub fn end(&self) -> f64 {
        self.finalized.time
    }

    /// Begins another plan for what `other` holds a plan for: with its chunks that retrace.
    pub fn begin_like(&mut self, other: &Self) {
        self.chunks[..self.written].fill(PlanChunk::zeroed());
        let retraced = &other.chunks[..other.retraced];
        self.chunks[..retraced.len()].copy_from_slice(retraced);
        (self.written, self.retraced) = (retraced.len(), retraced.len());
        self.last_timed = last_of_resting(retraced);
        let used = |chunk: &PlanChunk| u64::from(chunk.waypoints_len) - 1;
        let steps: u64 = retraced.iter().map(used).sum();
        self.waypoints = if retraced.is_empty() { 0 } else { 1 + steps };
        let last = retraced.last();
        let FinalizedStream { plan_id, epoch, .. } = other.finalized;
        let finalized = &mut self.finalized;
        (finalized.plan_id, finalized.epoch, finalized.count) = (plan_id, epoch, retraced.len());
        finalized.time =
            last.and_then(|chunk| chunk.waypoints().last()).map_or(0.0, |waypoint| waypoint.time);
        finalized.stream = last.map_or(Digest::default(), PlanChunk::stream_after);
        finalized.path_begin = None;
        finalized.is_resting.fill(false);
        finalized.is_resting[..retraced.len()]
            .copy_from_slice(&other.finalized.is_resting[..retraced.len()]);
    }

    /// Number of chunks that are not finalized.
    pub fn unfinalized(&self) -> usize {
        self.written - self.finalized.count
    }

    /// Reserves waypoints, without the first one, and chunks.
    fn reserve(&mut self, waypoints: usize, chunks: usize) -> Result<(), ArenaFull> {
        self.waypoints = self.waypoints.max(1) + waypoints as u64;
        self.written += chunks;
        if self.waypoints > self.waypoints_max || self.written > self.chunks.len() {
            self.written -= chunks;
            return Err(ArenaFull::Waypoints);
        }
        Ok(())
    }
}

impl FinalizedStream {
    /// Completes a chunk and its digest. A chunk without a timed path ends at rest.
    fn finalize(&mut self, chunk: &mut PlanChunk) {
        let used = chunk.waypoints_len as usize;
        if chunk.is_smooth() && !self.is_resting[self.count] {
            let begin = *self.path_begin.get_or_insert(self.time);
            chunk.waypoints[..used].iter_mut().for_each(|waypoint| waypoint.time += begin);
            chunk.brake_at += begin;
            self.time = chunk.waypoints[used - 1].time;
        } else {
            self.path_begin = None;
            self.time = accumulate(&mut chunk.waypoints[..used], self.time);
            chunk.brake_at = self.time;
        }
        (chunk.plan_id, chunk.epoch, chunk.sequence) =
            (self.plan_id, self.epoch, self.count as u64);
        chunk.flags |= if self.count == 0 { FLAG_FIRST } else { 0 };
        chunk.stream = self.stream;
        self.stream = chunk.stream_after();
        self.count += 1;
    }
}

impl Task<'_> {
    fn run(&mut self, inputs: (&Provenance, &TimeParameterization)) {
        match self {
            Self::Finalize { chunks, finalized } => {
                chunks.iter_mut().for_each(|chunk| finalized.finalize(chunk))
            }
            Self::Write { chunks, motion } => {
                let contacts: heapless::Vec<Contact, 2> =
                    motion.stance.iter().map(|foothold| contact_of(foothold)).collect();
                let ground = Ground::under(&contacts);
                let mut first = &motion.first;
                for (chunk, piece) in chunks.iter_mut().zip(motion.path.chunks(STEPS_MAX)) {
                    write(
                        chunk,
                        inputs,
                        motion.support as u32,
                        (&contacts, &ground),
                        [first].into_iter().chain(piece).map(waypoint),
                    );
                    first = &piece[piece.len() - 1];
                }
            }
        }
    }
}

/// A waypoint's configuration at rest, with its feed-forward torques there.
fn standing(waypoint: &Waypoint) -> Waypoint {
    let rest_torque = waypoint.rest_torque;
    Waypoint { torque: rest_torque, rest_torque, ..waypoint.rested() }
}

/// The last waypoint of chunks that rest at every one; none after straight lines.
fn last_of_resting(chunks: &[PlanChunk]) -> Option<Waypoint> {
    chunks.last().filter(|last| last.is_smooth())?.waypoints().last().copied()
}

/// Writes a zeroed chunk without finalizing it; each waypoint's time is the interval since the one
/// before.
fn write(
    chunk: &mut PlanChunk,
    (provenance, timing): (&Provenance, &TimeParameterization),
    mode: u32,
    (contacts, ground): (&[Contact], &Ground),
    waypoints: impl Iterator<Item = Waypoint>,
) {
    write_header(chunk, provenance, mode, contacts);
    chunk.interpolation = Interpolation::Linear as u64;
    write_waypoints(chunk, waypoints);
    let used = chunk.waypoints_len as usize;
    timing.set_intervals(&mut chunk.waypoints[..used], ground);
}

/// Writes what a zeroed chunk names beside its waypoints.
fn write_header(chunk: &mut PlanChunk, provenance: &Provenance, mode: u32, contacts: &[Contact]) {
    (chunk.schema, chunk.mode, chunk.joints_len) =
        (CHUNK_SCHEMA, mode, provenance.joints_len as u32);
    (chunk.robot, chunk.world, chunk.config) =
        (provenance.robot, provenance.world, provenance.config);
    chunk.goal = provenance.goal.into();
    for (slot, contact) in chunk.contacts.iter_mut().zip(contacts) {
        *slot = *contact;
        chunk.contacts_len += 1;
    }
}

fn write_waypoints(chunk: &mut PlanChunk, waypoints: impl Iterator<Item = Waypoint>) {
    for (slot, waypoint) in chunk.waypoints.iter_mut().zip(waypoints) {
        *slot = waypoint;
        chunk.waypoints_len += 1;
    }
}

/// The waypoint of a configuration. Its time is set when the chunk is finalized.
fn waypoint(configuration: &Configuration) -> Waypoint {
    Waypoint::at_rest(0.0, &configuration.world_from_root, &configuration.q)
}

/// The contact of a foothold.
pub(crate) fn contact_of(foothold: &Foothold) -> Contact {
    let mut contact = Contact::zeroed();
    contact.limb = foothold.limb as u32;
    contact.polygon_len = foothold.support.len() as u32;
    contact.position = foothold.world_from_sole.translation.to_array();
    contact.rotation = foothold.world_from_sole.rotation.to_array();
    for (slot, vertex) in contact.polygon.iter_mut().zip(&foothold.support) {
        *slot = vertex.to_array();
    }
    contact
}
