//! Cuts a walk into plan chunks at waypoints, all of which are statically stable, and times and seals them.

use surefoot_shared_types::digest::Digest;
use surefoot_shared_types::message::chunk::{CHUNK_SCHEMA, FLAG_FIRST, FLAG_LAST};
use surefoot_shared_types::message::limits::CHUNK_WAYPOINTS_MAX;
use surefoot_shared_types::message::{Contact, PlanChunk, SupportMode, Waypoint};

use crate::arena::reserve;
use crate::body::Configuration;
use crate::motion::foothold::Foothold;
use crate::motion::graph::ArenaFull;
use crate::timing::Timing;

/// What a plan was made for: goes into every chunk.
#[derive(Debug, Clone, Copy)]
pub struct Provenance {
    /// Digest of the robot.
    pub robot: Digest,
    /// Digest of the world.
    pub world: Digest,
    /// Digest of the scenario.
    pub config: Digest,
    /// Joints in use.
    pub joints_len: usize,
}

/// Builds a plan's chunks into an arena allocated once.
#[derive(Debug)]
pub struct ChunkBuilder {
    chunks: Vec<PlanChunk>,
    waypoints_max: u64,
    provenance: Provenance,
    timing: Timing,
    plan_id: u64,
    epoch: u64,
    waypoints: u64,
    /// When the chunks that are sealed end, s.
    time: f64,
    /// The digest of the chunks that are sealed.
    stream: Digest,
    sealed: usize,
}

impl ChunkBuilder {
    /// An arena for plans of `waypoints_max` waypoints.
    pub fn new(waypoints_max: usize, provenance: Provenance, timing: Timing) -> Self {
        let chunks_max = waypoints_max.div_ceil(CHUNK_WAYPOINTS_MAX - 1) + waypoints_max / 16;
        Self {
            chunks: reserve(chunks_max),
            waypoints_max: waypoints_max as u64,
            provenance,
            timing,
            plan_id: 1,
            epoch: 0,
            waypoints: 0,
            time: 0.0,
            stream: Digest::default(),
            sealed: 0,
        }
    }

    /// Sets which plan of its session the chunks belong to, and how often it was planned again; at first plan 1, epoch 0.
    pub fn name_plan(&mut self, plan_id: u64, epoch: u64) {
        (self.plan_id, self.epoch) = (plan_id, epoch);
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.chunks.capacity() * size_of::<PlanChunk>()
    }

    /// The chunks built so far.
    pub fn chunks(&self) -> &[PlanChunk] {
        &self.chunks
    }

    /// Waypoints of the plan, those shared by two chunks counted once.
    pub fn waypoints(&self) -> u64 {
        self.waypoints
    }

    /// Appends a motion within one mode: from `first` over all of `track`.
    ///
    /// # Errors
    /// The arena is full.
    pub fn append(
        &mut self,
        support: SupportMode,
        stance: &[&Foothold],
        first: &Configuration,
        track: &[Configuration],
    ) -> Result<(), ArenaFull> {
        self.waypoints = self.waypoints.max(1) + track.len() as u64;
        let mut from = first;
        for piece in track.chunks(CHUNK_WAYPOINTS_MAX - 1) {
            let contacts = stance.iter().map(|foothold| contact_of(foothold));
            self.push_chunk(support as u32, contacts, [from].into_iter().chain(piece).map(waypoint))?;
            from = &piece[piece.len() - 1];
        }
        Ok(())
    }

    /// Appends a chunk of an earlier plan, walked backwards.
    ///
    /// # Errors
    /// The arena is full.
    pub fn append_backwards(&mut self, walked: &PlanChunk) -> Result<(), ArenaFull> {
        self.waypoints = self.waypoints.max(1) + walked.waypoints().len() as u64 - 1;
        self.push_chunk(walked.mode, walked.contacts().iter().copied(), walked.waypoints().iter().rev().copied())
    }

    /// Seals the next chunk of a plan that is complete: times, name, sequence number, flags and digest. Answers the digest of the whole
    /// after the last one.
    pub fn seal(&mut self) -> Option<Digest> {
        let (index, count) = (self.sealed, self.chunks.len());
        if let Some(chunk) = self.chunks.get_mut(index) {
            let used = chunk.waypoints_len as usize;
            self.time = self.timing.set_times(&mut chunk.waypoints[..used], self.time);
            (chunk.plan_id, chunk.epoch, chunk.sequence) = (self.plan_id, self.epoch, index as u64);
            chunk.flags = if index == 0 { FLAG_FIRST } else { 0 } | if index + 1 == count { FLAG_LAST } else { 0 };
            chunk.stream = self.stream;
            self.stream = chunk.stream_after();
            self.sealed += 1;
        }
        (self.sealed == count).then_some(self.stream)
    }

    fn push_chunk(
        &mut self,
        mode: u32,
        contacts: impl Iterator<Item = Contact>,
        waypoints: impl Iterator<Item = Waypoint>,
    ) -> Result<(), ArenaFull> {
        if self.waypoints > self.waypoints_max || self.chunks.len() == self.chunks.capacity() {
            return Err(ArenaFull::Waypoints);
        }
        let at = self.chunks.len();
        self.chunks.push(bytemuck::Zeroable::zeroed());
        let chunk = &mut self.chunks[at];
        chunk.schema = CHUNK_SCHEMA;
        chunk.mode = mode;
        chunk.joints_len = self.provenance.joints_len as u32;
        (chunk.robot, chunk.world, chunk.config) = (self.provenance.robot, self.provenance.world, self.provenance.config);
        for (slot, contact) in chunk.contacts.iter_mut().zip(contacts) {
            *slot = contact;
            chunk.contacts_len += 1;
        }
        for (slot, waypoint) in chunk.waypoints.iter_mut().zip(waypoints) {
            *slot = waypoint;
            chunk.waypoints_len += 1;
        }
        Ok(())
    }
}

/// Its time is not known before the chunk is sealed.
fn waypoint(configuration: &Configuration) -> Waypoint {
    let pose = &configuration.world_from_root;
    Waypoint { time: 0.0, root_position: pose.translation.to_array(), root_rotation: pose.rotation.to_array(), q: configuration.q }
}

fn contact_of(foothold: &Foothold) -> Contact {
    let mut contact: Contact = bytemuck::Zeroable::zeroed();
    contact.limb = foothold.limb as u32;
    contact.polygon_len = foothold.support.len() as u32;
    contact.position = foothold.world_from_sole.translation.to_array();
    contact.rotation = foothold.world_from_sole.rotation.to_array();
    for (slot, vertex) in contact.polygon.iter_mut().zip(&foothold.support) {
        *slot = vertex.to_array();
    }
    contact
}
