//! Gamma_M: all that stage M has found [Grey 3.2, 4.4], and the rounds that add to it.
//!
//! A round hands one search to each workspace, runs them side by side and merges the results in order; the partition
//! depends on nothing but the sequence, so the number of threads cannot matter.

use rayon::prelude::*;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::message::SupportMode;

use crate::body::Configuration;
use crate::chunking::ChunkBuilder;
use crate::constraint::{Constraints, Mode, Rejection};
use crate::motion::edges::{EdgeRecord, EdgeTable};
use crate::motion::foothold::{Foothold, double_mode, single_mode};
use crate::motion::graph::{ArenaFull, BOUNDARIES_MAX, FootholdId, Graph, START, TransitionId, boundary_of};
use crate::motion::single_mode::{self, Problem};
use crate::motion::track::State;
use crate::motion::transition::{self, TransitionPair};
use crate::motion::workspace::Workspace;

/// Searches that run side by side in one round.
const WORKSPACES: usize = 16;
/// Most waypoints of one single-mode motion.
const TRACK_MAX: usize = 1024;
/// Most nodes of one tree.
const TREE_NODES_MAX: usize = 1536;
/// Attempts at one transition in one round.
const ATTEMPTS_PER_ROUND: u32 = 24;

/// What all searches read.
#[derive(Debug)]
pub struct Shared {
    /// The conditions.
    pub constraints: Constraints,
    /// Whether searches may run side by side; then the caller is inside a thread pool.
    pub parallel: bool,
    /// The seed of all streams.
    pub seed: u64,
}

/// The roadmap and the memory of its searches, allocated once.
#[derive(Debug)]
pub struct Roadmap {
    /// Modes and transitions.
    pub graph: Graph,
    /// What is known of the motions between transitions.
    pub edges: EdgeTable,
    boundaries: Vec<Boundary>,
    waypoints: Vec<Configuration>,
    workspaces: Vec<Workspace>,
}

/// What a round did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct RoundTally {
    /// Where the next round goes on in the sequence.
    pub next: usize,
    /// Searches that failed.
    pub failures: u32,
    /// Searches that found something.
    pub found: u32,
    /// Work units spent.
    pub work: u64,
    /// What was turned down.
    pub rejections: [u64; Rejection::COUNT],
}

/// One search of a round.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "a box would allocate during the search")]
enum Outcome {
    Idle,
    Transition { id: TransitionId, failed_attempts: u32, found: Option<Configuration> },
    Motion { from: TransitionId, to: TransitionId, failures: u32, found: bool },
}

/// Where two segments meet: the robot standing on two placements; also the start and the goal.
#[derive(Debug, Clone)]
pub struct Boundary {
    /// The placements, left and right.
    pub footholds: [FootholdId; 2],
    /// The robot on them.
    pub state: State,
    /// Which of them carry it.
    pub support: SupportMode,
}

/// The sequence of a segment and the nodes of the boundaries at both its ends.
#[derive(Debug, Clone, Copy)]
pub struct Segment<'a> {
    /// The transitions.
    pub sequence: &'a [TransitionId],
    /// The nodes before and after them.
    pub ends: [TransitionId; 2],
}

impl Segment<'_> {
    /// Hop `index`: hop 0 leads to the first transition.
    fn hop(&self, index: usize) -> Hop {
        let from = if index == 0 { self.ends[0] } else { self.sequence[index - 1] };
        Hop { from, to: self.sequence.get(index).copied().unwrap_or(self.ends[1]) }
    }
}

/// A pair of neighbours in the sequence, ends included.
#[derive(Debug, Clone, Copy)]
struct Hop {
    from: TransitionId,
    to: TransitionId,
}

impl Roadmap {
    /// Arenas of these capacities.
    pub fn new(config: &PlannerConfig) -> Self {
        let [footholds_max, transitions_max] = [config.footholds_max, config.transitions_max].map(|count| count as usize);
        let [configurations_max, waypoints_max] = [config.configurations_max, config.waypoints_max].map(|count| count as usize);
        Self {
            graph: Graph::new(footholds_max, transitions_max, configurations_max),
            edges: EdgeTable::new(4 * configurations_max),
            boundaries: Vec::with_capacity(BOUNDARIES_MAX),
            waypoints: Vec::with_capacity(waypoints_max),
            workspaces: (0..WORKSPACES).map(|_| Workspace::new(TRACK_MAX, TREE_NODES_MAX)).collect(),
        }
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.graph.bytes()
            + self.edges.bytes()
            + self.boundaries.capacity() * size_of::<Boundary>()
            + self.waypoints.capacity() * size_of::<Configuration>()
            + self.workspaces.iter().map(Workspace::bytes).sum::<usize>()
    }

    /// Samples configurations for the next transitions of the sequence that have none, from `next` on.
    ///
    /// # Errors
    /// An arena is full.
    pub fn sample_transitions(&mut self, shared: &Shared, segment: Segment<'_>, next: usize) -> Result<RoundTally, ArenaFull> {
        let mut batch: heapless::Vec<TransitionId, WORKSPACES> = heapless::Vec::new();
        let mut tally = RoundTally { next, ..RoundTally::default() };
        for &id in &segment.sequence[next..] {
            let wanted = !self.graph.transitions()[id as usize].is_found() && !batch.contains(&id);
            if wanted && batch.push(id).is_err() {
                break;
            }
            tally.next += 1;
        }
        let graph = &self.graph;
        let outcomes =
            run(shared, &mut self.workspaces, batch.len(), |index, workspace| sample_transition(shared, graph, batch[index], workspace));
        for outcome in outcomes {
            if let Outcome::Transition { id, failed_attempts, found } = outcome {
                tally.count(found.is_some());
                self.graph.record_attempts(id, failed_attempts, found)?;
            }
        }
        self.collect(&mut tally);
        Ok(tally)
    }

    /// Plans the next motions of the segment that are missing, from hop `next` on (hop 0 leads from the boundary before it to the
    /// first transition, the last one from the last transition to the boundary after it).
    ///
    /// # Errors
    /// An arena is full.
    pub fn plan_motions(&mut self, shared: &Shared, segment: Segment<'_>, next: usize) -> Result<RoundTally, ArenaFull> {
        let mut batch: heapless::Vec<Hop, WORKSPACES> = heapless::Vec::new();
        let mut tally = RoundTally { next, ..RoundTally::default() };
        for hop in (next..=segment.sequence.len()).map(|index| segment.hop(index)) {
            if self.edges.get(hop.from, hop.to).motion.is_none() && batch.push(hop).is_err() {
                break;
            }
            tally.next += 1;
        }
        let (graph, edges, boundaries) = (&self.graph, &self.edges, &self.boundaries);
        let outcomes = run(shared, &mut self.workspaces, batch.len(), |index, workspace| {
            plan_motion(shared, graph, edges, boundaries, batch[index], workspace)
        });
        for (index, outcome) in outcomes.into_iter().enumerate() {
            if let Outcome::Motion { from, to, failures, found } = outcome {
                let motion = if found { Some(self.store(index)?) } else { None };
                let failures = if found { failures } else { failures + 1 };
                self.edges.set(from, to, EdgeRecord { failures, motion })?;
                if !found && boundary_of(from).is_none() && boundary_of(to).is_none() && to != Graph::twin(from) {
                    self.graph.doubt(to);
                }
                tally.count(found);
            }
        }
        self.collect(&mut tally);
        Ok(tally)
    }

    /// Adds a boundary; answers its index.
    ///
    /// # Errors
    /// There are too many.
    pub fn add_boundary(&mut self, boundary: Boundary) -> Result<usize, ArenaFull> {
        if self.boundaries.len() == BOUNDARIES_MAX {
            return Err(ArenaFull::Boundaries);
        }
        self.boundaries.push(boundary);
        Ok(self.boundaries.len() - 1)
    }

    /// One of the boundaries.
    pub fn boundary(&self, index: usize) -> &Boundary {
        &self.boundaries[index]
    }

    /// Whether a transition of the segment has no configuration, or the motion to it has failed.
    pub fn is_unsolved(&self, segment: Segment<'_>, index: usize) -> bool {
        let Hop { from, to } = segment.hop(index);
        let record = self.edges.get(from, to);
        !self.graph.transitions()[to as usize].is_found() || record.motion.is_none() && record.failures > 0
    }

    /// Hands the motions along a complete walk to the chunk builder: transitions and the nodes of boundaries, in order.
    ///
    /// # Errors
    /// The chunk arena is full.
    pub fn assemble(&self, walk: &[TransitionId], chunks: &mut ChunkBuilder) -> Result<(), ArenaFull> {
        for hop in walk.windows(2).map(|pair| Hop { from: pair[0], to: pair[1] }) {
            let Some((first, count)) = self.edges.get(hop.from, hop.to).motion else { continue };
            let track = &self.waypoints[first as usize..(first + count) as usize];
            let from = state(&self.graph, &self.boundaries, hop.from);
            let (support, stance) = self.stance(hop);
            chunks.append(support, &stance, &from.configuration, track)?;
        }
        Ok(())
    }

    fn store(&mut self, workspace: usize) -> Result<(u32, u32), ArenaFull> {
        let track = &self.workspaces[workspace].track;
        if self.waypoints.len() + track.len() > self.waypoints.capacity() {
            return Err(ArenaFull::Waypoints);
        }
        let first = self.waypoints.len() as u32;
        self.waypoints.extend_from_slice(track);
        Ok((first, track.len() as u32))
    }

    fn collect(&mut self, tally: &mut RoundTally) {
        tally.work += 1;
        for workspace in &mut self.workspaces {
            tally.work += std::mem::take(&mut workspace.work);
            for (total, count) in tally.rejections.iter_mut().zip(&mut workspace.rejections) {
                *total += std::mem::take(count);
            }
        }
    }

    fn stance(&self, hop: Hop) -> (SupportMode, heapless::Vec<&Foothold, 2>) {
        let mut stance = heapless::Vec::new();
        let (mode, placements) = mode(&self.graph, &self.boundaries, hop);
        let limbs = (0..2).filter(|&limb| mode.stands(limb));
        stance.extend(limbs.filter_map(|limb| placements.iter().copied().find(|placement| placement.limb == limb)));
        (mode.support, stance)
    }
}

impl RoundTally {
    fn count(&mut self, found: bool) {
        if found { self.found += 1 } else { self.failures += 1 }
    }
}

/// Runs `search` for each index below `count`, each in a workspace of its own, and answers the outcomes in order.
fn run(
    shared: &Shared,
    workspaces: &mut [Workspace],
    count: usize,
    search: impl Fn(usize, &mut Workspace) -> Outcome + Sync,
) -> [Outcome; WORKSPACES] {
    let mut outcomes = [const { Outcome::Idle }; WORKSPACES];
    if shared.parallel && count > 1 {
        let slots = workspaces.par_iter_mut().zip(outcomes.par_iter_mut()).enumerate().with_max_len(1);
        slots.take(count).for_each(|(index, (workspace, outcome))| *outcome = search(index, workspace));
    } else {
        let slots = workspaces.iter_mut().zip(&mut outcomes).enumerate();
        slots.take(count).for_each(|(index, (workspace, outcome))| *outcome = search(index, workspace));
    }
    outcomes
}

fn sample_transition(shared: &Shared, graph: &Graph, id: TransitionId, workspace: &mut Workspace) -> Outcome {
    let (stance, other) = graph.pair(id);
    let mode = single_mode(stance);
    let before = graph.transitions()[id as usize].attempts - 1;
    for attempt in before..before + ATTEMPTS_PER_ROUND {
        let pair = TransitionPair { stance, other };
        let mut work = 0;
        let sampled = transition::sample(&shared.constraints, &mode, pair, (shared.seed, u64::from(id)), u64::from(attempt), &mut work);
        workspace.work += work;
        match sampled {
            Ok(found) => return Outcome::Transition { id, failed_attempts: attempt - before, found: Some(found) },
            Err(rejection) => workspace.count(rejection),
        }
    }
    Outcome::Transition { id, failed_attempts: ATTEMPTS_PER_ROUND, found: None }
}

fn plan_motion(shared: &Shared, graph: &Graph, edges: &EdgeTable, boundaries: &[Boundary], hop: Hop, workspace: &mut Workspace) -> Outcome {
    let failures = edges.get(hop.from, hop.to).failures;
    let problem = Problem {
        mode: mode(graph, boundaries, hop).0,
        from: state(graph, boundaries, hop.from),
        to: state(graph, boundaries, hop.to),
        random: (shared.seed, u64::from(hop.from) << 32 | u64::from(hop.to)),
        failures,
    };
    let found = single_mode::solve(&shared.constraints, &problem, workspace).is_ok();
    Outcome::Motion { from: hop.from, to: hop.to, failures, found }
}

/// The mode of a hop, and the placements that it touches.
fn mode<'a>(graph: &'a Graph, boundaries: &[Boundary], hop: Hop) -> (Mode, [&'a Foothold; 2]) {
    let before = boundary_of(hop.from).map(|index| &boundaries[index]);
    let (stance, other) = graph.pair(if before.is_some() { hop.to } else { hop.from });
    let starts_double = before.is_some_and(|boundary| boundary.support == SupportMode::Double);
    let is_double = starts_double || boundary_of(hop.to).is_some() || hop.to == Graph::twin(hop.from);
    let mode = if is_double { double_mode(stance, other) } else { single_mode(stance) };
    (mode, [stance, other])
}

fn state(graph: &Graph, boundaries: &[Boundary], node: TransitionId) -> State {
    if let Some(index) = boundary_of(node) {
        return boundaries[index].state;
    }
    let (stance, other) = graph.pair(node);
    let world_from_soles = transition::world_from_soles(TransitionPair { stance, other });
    let configuration = *graph.configuration(node).unwrap_or(&boundaries[START].state.configuration);
    State { configuration, world_from_soles }
}
