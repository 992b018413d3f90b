//! Rounds of searches side by side.
//!
//! A round hands one search to each of its slots, advances all of them by a unit of work at a time,
//! as far as a budget allows, and once all have ended merges the results in order. The partition
//! depends on nothing but the sequences, and no search sees what another of its round found, so
//! neither the number of threads nor the size of budgets can matter. Segments that are planned side
//! by side share a round, each in a lane of its own.

use crate::allowance::{self, Allowance, Piece};
use crate::arena::Place;
use crate::body::Configuration;
use crate::constraint::Rejection;
use crate::motion::graph::{ArenaFull, Graph};
use crate::motion::primitive::Emission;
use crate::motion::roadmap::{Hop, Roadmap, Segment, TREE_NODES_MAX};
use crate::motion::sampling::Sampling;
use crate::motion::shortcut::{Goal, Shortcutting};
use crate::motion::single_mode::{Problem, Search};
use crate::motion::workspace::{Workspace, push};
use crate::random::{Random, Stream};
use crate::shared::Shared;
use crate::threads::Threads;

/// Segments that are planned side by side.
pub const LANES_MAX: usize = 4;
/// Searches that run side by side in one round.
const SLOTS: usize = 32;
/// Most waypoints of one single-mode motion.
const TRACK_MAX: usize = 1024;
/// Units of work that may go into shortening a motion, for each of its waypoints.
const SHORTCUT_WORK: u64 = 2;

/// What a round did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RoundTally {
    /// Lanes that had searches in it.
    pub lanes: u64,
    /// Searches that failed, by lane.
    pub failures: [u32; LANES_MAX],
    /// Searches that found something.
    pub found: u32,
    /// What was turned down.
    pub rejections: [u64; Rejection::COUNT],
}

/// The searches of a round, allocated once.
#[derive(Debug)]
pub struct Round {
    slots: Vec<Slot>,
    /// How many of the slots have a search.
    count: usize,
    is_running: bool,
}

#[derive(Debug)]
struct Slot {
    /// Whose search it is.
    lane: usize,
    task: Task,
    workspace: Workspace,
    /// Where the trees of the workspace belong.
    lent: [Option<usize>; 2],
    allowance: Allowance,
}

#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "a box would allocate during the search")]
enum Task {
    Idle,
    Sample(Sampling),
    Move { hop: Hop, search: Search, found: Option<bool> },
    Shorten { hop: Hop, shortcutting: Shortcutting },
    Emit { hop: Hop, emission: Emission, has_failed: bool },
}

impl Default for Round {
    /// Slots with empty workspaces.
    fn default() -> Self {
        let slot = |_| Slot {
            lane: 0,
            task: Task::Idle,
            workspace: Workspace::new(TRACK_MAX, TREE_NODES_MAX),
            lent: [None; 2],
            allowance: Allowance::default(),
        };
        Self { slots: (0..SLOTS).map(slot).collect(), count: 0, is_running: false }
    }
}

impl Round {
    /// Whether a round has begun and not been merged.
    pub fn is_running(&self) -> bool {
        self.is_running
    }

    /// Begins a round that has no search yet.
    pub fn begin(&mut self) {
        (self.count, self.is_running) = (0, true);
    }

    /// Adds searches for configurations of the transitions of a lane's sequence that have none,
    /// from `next` on. Answers where the lane's next round goes on: where the slots are used up, or
    /// another lane is at the same transition.
    pub fn add_sampling(
        &mut self,
        lane: usize,
        roadmap: &Roadmap,
        segment: Segment<'_>,
        next: usize,
    ) -> usize {
        for (index, &id) in segment.sequence.iter().enumerate().skip(next) {
            if roadmap.graph.transitions()[id as usize].is_found() {
                continue;
            }
            match self.lane_of(|task| matches!(task, Task::Sample(sampling) if sampling.id == id)) {
                Some(other) if other != lane => return index,
                Some(_) => {}
                None if self.give(lane, Task::Sample(Sampling::new(&roadmap.graph, id))) => {}
                None => return index,
            }
        }
        segment.sequence.len()
    }

    /// Adds searches for the motions of a lane's segment that are missing, from hop `next` on (hop
    /// 0 leads from the boundary before it to the first transition, the last one from the last
    /// transition to the boundary after it). Answers where the lane's next round goes on, like
    /// [`Round::add_sampling`].
    pub fn add_motions(
        &mut self,
        lane: usize,
        shared: &Shared,
        roadmap: &mut Roadmap,
        segment: Segment<'_>,
        next: usize,
    ) -> usize {
        for index in next..=segment.sequence.len() {
            let hop = segment.hop(index);
            let record = roadmap.edges.get(hop.from, hop.to);
            if record.motion.is_some() {
                continue;
            }
            let others =
                self.lane_of(|task| matches!(task, Task::Move { hop: begun, .. } if *begun == hop));
            if others.is_some_and(|other| other != lane) {
                return index;
            }
            let problem = Problem {
                mode: roadmap.mode(hop),
                from: roadmap.state(hop.from),
                to: roadmap.state(hop.to),
                random: (shared.seed, u64::from(hop.from) << 32 | u64::from(hop.to)),
                failures: record.failures,
            };
            let lifted = roadmap.lifted(hop);
            let search = Search::new(problem, lifted.map(|known| known.map(|(state, _)| state)));
            if !self.give(lane, Task::Move { hop, search, found: None }) {
                return index;
            }
            let slot = &mut self.slots[self.count - 1];
            for (waypoints, known) in slot.workspace.lifts.iter_mut().zip(lifted) {
                waypoints.extend_from_slice(known.map_or(&[], |(_, way)| way));
            }
            slot.borrow_trees(roadmap, hop);
        }
        segment.sequence.len() + 1
    }

    /// Adds a motion that pi_S gives. There must be room for it, see [`Round::is_full`].
    pub fn add_primitive(&mut self, hop: Hop, emission: Emission) {
        self.give(0, Task::Emit { hop, emission, has_failed: false });
    }

    /// Begins to shorten the next motions, which may spend `work_max` units together.
    pub fn begin_shortcuts(
        &mut self,
        shared: &Shared,
        roadmap: &Roadmap,
        hops: impl Iterator<Item = Hop>,
        (goal, work_max): (Goal, u64),
    ) {
        self.begin();
        let mut left = work_max;
        for hop in hops.take(SLOTS) {
            let Some(track) = roadmap.motion(hop).filter(|track| track.len() < TRACK_MAX) else {
                continue;
            };
            let work = left.min(SHORTCUT_WORK * track.len() as u64);
            let random = Random::new(
                shared.seed,
                Stream::Shortcut,
                u64::from(hop.from) << 32 | u64::from(hop.to),
                0,
            );
            let shortcutting = Shortcutting::new(goal, roadmap.mode(hop), random, work);
            if work == 0 || !self.give(0, Task::Shorten { hop, shortcutting }) {
                break;
            }
            left -= work;
            let held = &mut self.slots[self.count - 1].workspace.track;
            held.push(roadmap.state(hop.from).configuration);
            held.extend_from_slice(track);
        }
    }

    /// Whether the round has no search at all.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Whether all slots have a search.
    pub fn is_full(&self) -> bool {
        self.count == self.slots.len()
    }

    /// Spends at most so many units of work; answers how many it spent. Less than allowed means
    /// that all searches have ended.
    pub fn advance(&mut self, shared: &Shared, roadmap: &Roadmap, budget: u64) -> u64 {
        allowance::advance(&mut self.slots[..self.count], budget, &shared.threads, |slot| {
            slot.advance(shared, &roadmap.graph)
        })
    }

    /// Merges what the searches found, in order.
    ///
    /// # Errors
    /// An arena is full.
    pub fn merge(
        &mut self,
        threads: &Threads,
        roadmap: &mut Roadmap,
    ) -> Result<RoundTally, ArenaFull> {
        let places = self.store(threads, roadmap)?;
        let has_search =
            |lane: &usize| self.slots[..self.count].iter().any(|slot| slot.lane == *lane);
        let mut tally = RoundTally {
            lanes: (0..LANES_MAX).filter(has_search).count() as u64,
            ..RoundTally::default()
        };
        for (slot, way) in self.slots.iter_mut().zip(places) {
            slot.return_trees(roadmap);
            let found = slot.merge(roadmap, way)?;
            if found {
                tally.found += 1
            } else {
                tally.failures[slot.lane] += 1
            }
            for (total, count) in tally.rejections.iter_mut().zip(&mut slot.workspace.rejections) {
                *total += std::mem::take(count);
            }
        }
        roadmap.trees.end_round();
        self.is_running = false;
        Ok(tally)
    }

    /// Stores the ways that the searches found; answers where.
    fn store(
        &self,
        threads: &Threads,
        roadmap: &mut Roadmap,
    ) -> Result<heapless::Vec<Place, SLOTS>, ArenaFull> {
        let ways: heapless::Vec<&[Configuration], SLOTS> =
            self.slots[..self.count].iter().map(Slot::way).collect();
        roadmap.store(&ways, threads)
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.slots.iter().map(|slot| size_of::<Slot>() + slot.workspace.bytes()).sum()
    }

    /// The lane of the first search of this round that is such a one.
    fn lane_of(&self, is_such: impl Fn(&Task) -> bool) -> Option<usize> {
        self.slots[..self.count].iter().find(|slot| is_such(&slot.task)).map(|slot| slot.lane)
    }

    /// Gives a slot a lane's search; `false` where all have one.
    fn give(&mut self, lane: usize, task: Task) -> bool {
        let Some(slot) = self.slots.get_mut(self.count) else { return false };
        (slot.lane, slot.task) = (lane, task);
        slot.workspace.clear();
        self.count += 1;
        true
    }
}

impl Piece for Slot {
    fn has_ended(&self) -> bool {
        match &self.task {
            Task::Idle => true,
            Task::Sample(sampling) => sampling.has_ended(),
            Task::Move { found, .. } => found.is_some(),
            Task::Shorten { shortcutting, .. } => shortcutting.has_ended(),
            Task::Emit { emission, has_failed, .. } => *has_failed || emission.is_over(),
        }
    }

    fn allowance(&mut self) -> &mut Allowance {
        &mut self.allowance
    }
}

impl Slot {
    /// One unit of its search.
    fn advance(&mut self, shared: &Shared, graph: &Graph) {
        match &mut self.task {
            Task::Idle => {}
            Task::Sample(sampling) => {
                sampling.advance(&shared.constraints, shared.seed, graph, &mut self.workspace)
            }
            Task::Move { search, found, .. } => {
                *found = search
                    .advance(&shared.constraints, &mut self.workspace)
                    .map(|ended| ended.is_ok());
            }
            Task::Shorten { shortcutting, .. } => {
                shortcutting.advance(&shared.constraints, &mut self.workspace)
            }
            Task::Emit { emission, has_failed, .. } => {
                *has_failed = match emission.advance(&shared.constraints) {
                    Ok(None) => false,
                    Ok(Some((state, _))) => {
                        push(&mut self.workspace.track, state.configuration).is_err()
                    }
                    Err(_) => true,
                }
            }
        }
    }

    fn borrow_trees(&mut self, roadmap: &mut Roadmap, hop: Hop) {
        let keys = roadmap.tree_keys(hop);
        for ((lent, tree), key) in self.lent.iter_mut().zip(&mut self.workspace.trees).zip(keys) {
            *lent = roadmap.trees.lend(key, tree);
        }
    }

    fn return_trees(&mut self, roadmap: &mut Roadmap) {
        for (lent, tree) in self.lent.iter_mut().zip(&mut self.workspace.trees) {
            if let Some(index) = lent.take() {
                roadmap.trees.give_back(index, tree);
            }
        }
    }

    /// The waypoints that the search has found, if they are new.
    fn way(&self) -> &[Configuration] {
        match &self.task {
            Task::Sample(sampling) if sampling.found().is_some() => &self.workspace.lifts[0],
            Task::Move { found: Some(true), .. } | Task::Emit { has_failed: false, .. } => {
                &self.workspace.track
            }
            _ => &[],
        }
    }

    /// Notes what the search found, its way stored there; answers whether that is anything.
    fn merge(&self, roadmap: &mut Roadmap, way: Place) -> Result<bool, ArenaFull> {
        match &self.task {
            Task::Idle => Ok(false),
            Task::Sample(sampling) => {
                roadmap.record_sampling(sampling, way)?;
                Ok(sampling.found().is_some())
            }
            Task::Move { hop, found: Some(true), .. } => {
                roadmap.record_motion(*hop, way)?;
                Ok(true)
            }
            Task::Shorten { hop, .. } => {
                roadmap.shorten_motion(*hop, &self.workspace.track)?;
                Ok(true)
            }
            Task::Emit { has_failed: true, .. } => Ok(false),
            Task::Emit { hop, emission, .. } => {
                roadmap.record_primitive(*hop, emission.ends(), way)?;
                Ok(true)
            }
            Task::Move { hop, search, .. } => {
                roadmap.record_failure(*hop, search.extensions())?;
                Ok(false)
            }
        }
    }
}
