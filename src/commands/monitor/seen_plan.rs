//! What a monitor has seen of a plan: the walk, and what binds its motion.

use std::collections::BTreeMap;

use glam::DVec3;
use surefoot_shared_types::message::{Description, LimitKind, PlanChunk, SupportMode};

use crate::report::binding::{BindingShare, shares_of};
use crate::report::walk_facts::{WalkFacts, add_place};

/// The chunks of one plan and epoch, each once.
#[derive(Debug, Default)]
pub(crate) struct SeenPlan {
    /// The sequence number after the last chunk. Chunks before it are repeated ones.
    next: u64,
    /// Times (s) and places (m) of the root.
    root: Vec<(f64, DVec3)>,
    /// The places of each foot, m.
    feet: [Vec<DVec3>; 2],
    modes: Vec<SupportMode>,
    /// How long each limit binds, by the wire value of its kind and by joint, s.
    binding: BTreeMap<(u32, Option<usize>), f64>,
}

impl SeenPlan {
    /// Takes in a chunk.
    pub(crate) fn record(&mut self, chunk: &PlanChunk) {
        if chunk.sequence < self.next {
            return;
        }
        self.next = chunk.sequence + 1;
        let places = chunk.waypoints().iter().map(|at| (at.time, at.root_position.into()));
        self.root.extend(places);
        self.modes.extend(SupportMode::from_wire(chunk.mode));
        for contact in chunk.contacts() {
            if let Some(foot) = self.feet.get_mut(contact.limb as usize) {
                add_place(foot, contact.position.into());
            }
        }
        for (kind, joint, seconds) in chunk.binding.iter().filter_map(|entry| entry.known()) {
            *self.binding.entry((kind as u32, joint)).or_default() += seconds;
        }
    }

    /// The walk so far.
    pub(crate) fn walk(&self) -> WalkFacts {
        let Self { root, feet, modes, .. } = self;
        WalkFacts::new(root.iter().copied(), feet.clone(), modes.iter().copied())
    }

    /// What binds it, the longest first, with the names of the joints in a description.
    pub(crate) fn binding(&self, names: Option<&Description>) -> Vec<BindingShare> {
        let times = self.binding.iter().filter_map(|(&(kind, joint), &seconds)| {
            Some((LimitKind::from_wire(kind)?, joint, seconds))
        });
        shares_of(times, |joint| Some(names?.joints().get(joint)?.name.text()?.to_owned()))
    }
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;
    use surefoot_shared_types::message::{ChunkBinding, Waypoint};

    use super::*;
    use crate::report::binding::describe;

    fn chunk(sequence: u64, mode: SupportMode, binding: ChunkBinding) -> PlanChunk {
        let mut chunk = PlanChunk { sequence, mode: mode as u32, ..PlanChunk::zeroed() };
        let at = |time: f64| Waypoint {
            time,
            root_position: [0.5 * time, 0.0, 1.0],
            ..Waypoint::zeroed()
        };
        chunk.waypoints[..2].copy_from_slice(&[at(sequence as f64), at(sequence as f64 + 1.0)]);
        (chunk.waypoints_len, chunk.binding[0]) = (2, binding);
        chunk
    }

    #[test]
    fn a_repeated_chunk_counts_once() {
        let mut plan = SeenPlan::default();
        let torque = ChunkBinding::new(LimitKind::Torque, Some(4), 3.0);
        let friction = ChunkBinding::new(LimitKind::Friction, None, 1.0);
        let chunks = [
            chunk(0, SupportMode::Left, torque),
            chunk(1, SupportMode::Double, friction),
            chunk(0, SupportMode::Left, torque),
            chunk(1, SupportMode::Double, friction),
            chunk(2, SupportMode::Right, ChunkBinding::zeroed()),
        ];
        chunks.iter().for_each(|chunk| plan.record(chunk));
        assert_eq!(describe(&plan.binding(None)), "torque of joint 4 75 %, friction 25 %");
        let walk = plan.walk();
        assert_eq!((walk.seconds, walk.metres, walk.steps), (3.0, 1.5, 1));
    }
}
