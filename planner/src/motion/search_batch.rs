//! Batches of searches in parallel.
//!
//! A batch hands one search to each of its entries, advances all of them by a unit of work at a
//! time, as far as a budget allows, and once all have ended merges the results in order. The
//! partition depends on nothing but the sequences, and no search sees what another of its batch
//! found, so neither the number of threads nor the size of budgets can matter. Segments that are
//! planned side by side share a batch, each in a segment search of its own.

use crate::base::arena::ArenaSlice;
use crate::base::capacity::ArenaFull;
use crate::base::random::{Random, Stream};
use crate::base::threads::Threads;
use crate::base::work_budget;
use crate::base::work_budget::{BudgetedTask, WorkBudget};
use crate::constraints::rejection::Rejection;
use crate::motion::mode_graph::ModeGraph;
use crate::motion::roadmap::{ModeEdge, Roadmap, RouteSegment, TREE_NODES_MAX};
use crate::motion::shortcut::{Pass, Shortcutting};
use crate::motion::single_mode::{SingleModeProblem, SingleModeSearch};
use crate::motion::transition_sampling::TransitionSampling;
use crate::motion::workspace::{Workspace, push};
use crate::preparation::planning_context::PlanningContext;
use crate::primitives::PrimitiveTrajectory;
use crate::robot::configuration::Configuration;

/// Segments that are planned in parallel.
pub const SEGMENT_SEARCHES_MAX: usize = 4;
/// Searches that run in parallel in one batch.
const SEARCHES_MAX: usize = 32;
/// Most waypoints of one single-mode motion.
const PATH_WAYPOINTS_MAX: usize = 1024;
/// Units of work that may go into shortening a motion, for each of its waypoints.
const SHORTCUT_WORK: u64 = 2;

/// What a batch did.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct BatchStats {
    /// Lanes that had searches in it.
    pub segment_searches: u64,
    /// Searches that failed, by segment search.
    pub failures: [u32; SEGMENT_SEARCHES_MAX],
    /// Searches that found something.
    pub found: u32,
    /// What was rejected.
    pub rejections: [u64; Rejection::COUNT],
}

/// The searches of a batch, allocated once.
#[derive(Debug)]
pub struct SearchBatch {
    entries: Vec<BatchEntry>,
    /// How many of the entries have a search.
    count: usize,
    is_running: bool,
}

#[derive(Debug)]
struct BatchEntry {
    /// Whose search it is.
    segment_search: usize,
    task: BatchTask,
    workspace: Workspace,
    /// Where the trees of the workspace belong.
    lent: [Option<usize>; 2],
    work_budget: WorkBudget,
}

#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "a box would allocate during the search")]
enum BatchTask {
    Idle,
    Sample(TransitionSampling),
    Move { edge: ModeEdge, search: SingleModeSearch, found: Option<bool> },
    Shorten { edge: ModeEdge, shortcutting: Shortcutting },
    Primitive { edge: ModeEdge, trajectory: PrimitiveTrajectory, has_failed: bool },
}

impl Default for SearchBatch {
    /// Slots with empty workspaces.
    fn default() -> Self {
        let entry = |_| BatchEntry {
            segment_search: 0,
            task: BatchTask::Idle,
            workspace: Workspace::new(PATH_WAYPOINTS_MAX, TREE_NODES_MAX),
            lent: [None; 2],
            work_budget: WorkBudget::default(),
        };
        Self { entries: (0..SEARCHES_MAX).map(entry).collect(), count: 0, is_running: false }
    }
}

impl SearchBatch {
    /// Whether a batch has begun and not been merged.
    pub fn is_running(&self) -> bool {
        self.is_running
    }

    /// Begins a batch that has no search yet.
    pub fn begin(&mut self) {
        (self.count, self.is_running) = (0, true);
    }

    /// Adds searches for configurations of the transitions of a segment search's sequence that have
    /// none, from `next` on. Answers where the segment search's next batch goes on: where the
    /// entries are used up, or another segment search is at the same transition.
    pub fn add_sampling(
        &mut self,
        segment_search: usize,
        roadmap: &Roadmap,
        segment: RouteSegment<'_>,
        next: usize,
    ) -> usize {
        for (index, &id) in segment.sequence.iter().enumerate().skip(next) {
            if roadmap.graph.transitions()[id as usize].is_found() {
                continue;
            }
            match self.segment_search_of(
                |task| matches!(task, BatchTask::Sample(sampling) if sampling.id == id),
            ) {
                Some(other) if other != segment_search => return index,
                Some(_) => {}
                None if self.add_task(
                    segment_search,
                    BatchTask::Sample(TransitionSampling::new(&roadmap.graph, id)),
                ) => {}
                None => return index,
            }
        }
        segment.sequence.len()
    }

    /// Adds searches for the motions of a segment search's segment that are missing, from edge
    /// `next` on (edge 0 leads from the boundary before it to the first transition, the last one
    /// from the last transition to the boundary after it). Answers where the segment search's next
    /// batch goes on, like [`SearchBatch::add_sampling`].
    pub fn add_motions(
        &mut self,
        segment_search: usize,
        context: &PlanningContext,
        roadmap: &mut Roadmap,
        segment: RouteSegment<'_>,
        next: usize,
    ) -> usize {
        for index in next..=segment.sequence.len() {
            let edge = segment.edge(index);
            let record = roadmap.edges.get(edge.from, edge.to);
            if record.motion.is_some() {
                continue;
            }
            let others = self.segment_search_of(
                |task| matches!(task, BatchTask::Move { edge: begun, .. } if *begun == edge),
            );
            if others.is_some_and(|other| other != segment_search) {
                return index;
            }
            let problem = SingleModeProblem {
                mode: roadmap.mode(edge),
                from: roadmap.state(edge.from),
                to: roadmap.state(edge.to),
                random: (context.seed, u64::from(edge.from) << 32 | u64::from(edge.to)),
                failures: record.failures,
            };
            let lifted = roadmap.lifted(edge);
            let search =
                SingleModeSearch::new(problem, lifted.map(|known| known.map(|(state, _)| state)));
            if !self.add_task(segment_search, BatchTask::Move { edge, search, found: None }) {
                return index;
            }
            let entry = &mut self.entries[self.count - 1];
            for (waypoints, known) in entry.workspace.lift_offs.iter_mut().zip(lifted) {
                waypoints.extend_from_slice(known.map_or(&[], |(_, path)| path));
            }
            entry.borrow_trees(roadmap, edge);
        }
        segment.sequence.len() + 1
    }

    /// Adds a motion that pi_S gives. There must be room for it, see [`SearchBatch::is_full`].
    pub fn add_primitive(&mut self, edge: ModeEdge, trajectory: PrimitiveTrajectory) {
        self.add_task(0, BatchTask::Primitive { edge, trajectory, has_failed: false });
    }

    /// Begins to shorten the next motions, which may spend `work_max` units together.
    pub fn begin_shortcuts(
        &mut self,
        context: &PlanningContext,
        roadmap: &Roadmap,
        edges: impl Iterator<Item = ModeEdge>,
        (pass, work_max): (Pass, u64),
    ) {
        self.begin();
        let mut left = work_max;
        for edge in edges.take(SEARCHES_MAX) {
            let Some(path) = roadmap.motion(edge).filter(|path| path.len() < PATH_WAYPOINTS_MAX)
            else {
                continue;
            };
            let work = left.min(SHORTCUT_WORK * path.len() as u64);
            let random = Random::new(
                context.seed,
                Stream::Shortcut,
                u64::from(edge.from) << 32 | u64::from(edge.to),
                0,
            );
            let shortcutting = Shortcutting::new(pass, roadmap.mode(edge), random, work);
            if work == 0 || !self.add_task(0, BatchTask::Shorten { edge, shortcutting }) {
                break;
            }
            left -= work;
            let copy = &mut self.entries[self.count - 1].workspace.path;
            copy.push(roadmap.state(edge.from).configuration);
            copy.extend_from_slice(path);
        }
    }

    /// Whether the batch has no search at all.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Whether all entries have a search.
    pub fn is_full(&self) -> bool {
        self.count == self.entries.len()
    }

    /// Spends at most so many units of work; answers how many it spent. Less than allowed means
    /// that all searches have ended.
    pub fn advance(&mut self, context: &PlanningContext, roadmap: &Roadmap, budget: u64) -> u64 {
        work_budget::advance(&mut self.entries[..self.count], budget, &context.threads, |entry| {
            entry.advance(context, &roadmap.graph)
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
    ) -> Result<BatchStats, ArenaFull> {
        let slices = self.store(threads, roadmap)?;
        let has_search = |segment_search: &usize| {
            self.entries[..self.count].iter().any(|entry| entry.segment_search == *segment_search)
        };
        let mut stats = BatchStats {
            segment_searches: (0..SEGMENT_SEARCHES_MAX).filter(has_search).count() as u64,
            ..BatchStats::default()
        };
        for (entry, path) in self.entries.iter_mut().zip(slices) {
            entry.return_trees(roadmap);
            let found = entry.merge(roadmap, path)?;
            if found {
                stats.found += 1
            } else {
                stats.failures[entry.segment_search] += 1
            }
            for (total, count) in stats.rejections.iter_mut().zip(&mut entry.workspace.rejections) {
                *total += std::mem::take(count);
            }
        }
        roadmap.trees.end_batch();
        self.is_running = false;
        Ok(stats)
    }

    /// Stores the paths that the searches found; answers where.
    fn store(
        &self,
        threads: &Threads,
        roadmap: &mut Roadmap,
    ) -> Result<heapless::Vec<ArenaSlice, SEARCHES_MAX>, ArenaFull> {
        let paths: heapless::Vec<&[Configuration], SEARCHES_MAX> =
            self.entries[..self.count].iter().map(BatchEntry::path).collect();
        roadmap.store(&paths, threads)
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.entries.iter().map(|entry| size_of::<BatchEntry>() + entry.workspace.bytes()).sum()
    }

    /// The segment search of the first search of this batch that is such a one.
    fn segment_search_of(&self, is_match: impl Fn(&BatchTask) -> bool) -> Option<usize> {
        self.entries[..self.count]
            .iter()
            .find(|entry| is_match(&entry.task))
            .map(|entry| entry.segment_search)
    }

    /// Gives a entry a segment search's search; `false` where all have one.
    fn add_task(&mut self, segment_search: usize, task: BatchTask) -> bool {
        let Some(entry) = self.entries.get_mut(self.count) else { return false };
        (entry.segment_search, entry.task) = (segment_search, task);
        entry.workspace.clear();
        self.count += 1;
        true
    }
}

impl BudgetedTask for BatchEntry {
    fn has_ended(&self) -> bool {
        match &self.task {
            BatchTask::Idle => true,
            BatchTask::Sample(sampling) => sampling.has_ended(),
            BatchTask::Move { found, .. } => found.is_some(),
            BatchTask::Shorten { shortcutting, .. } => shortcutting.has_ended(),
            BatchTask::Primitive { trajectory, has_failed, .. } => {
                *has_failed || trajectory.is_over()
            }
        }
    }

    fn work_budget(&mut self) -> &mut WorkBudget {
        &mut self.work_budget
    }
}

impl BatchEntry {
    /// One unit of its search.
    fn advance(&mut self, context: &PlanningContext, graph: &ModeGraph) {
        match &mut self.task {
            BatchTask::Idle => {}
            BatchTask::Sample(sampling) => {
                sampling.advance(&context.constraints, context.seed, graph, &mut self.workspace)
            }
            BatchTask::Move { search, found, .. } => {
                *found = search
                    .advance(&context.constraints, &mut self.workspace)
                    .map(|ended| ended.is_ok());
            }
            BatchTask::Shorten { shortcutting, .. } => {
                shortcutting.advance(&context.constraints, &mut self.workspace)
            }
            BatchTask::Primitive { trajectory, has_failed, .. } => {
                *has_failed = match trajectory.advance(&context.constraints) {
                    Ok(None) => false,
                    Ok(Some((state, _))) => {
                        push(&mut self.workspace.path, state.configuration).is_err()
                    }
                    Err(_) => true,
                }
            }
        }
    }

    fn borrow_trees(&mut self, roadmap: &mut Roadmap, edge: ModeEdge) {
        let keys = roadmap.tree_keys(edge);
        for ((lent, tree), key) in self.lent.iter_mut().zip(&mut self.workspace.trees).zip(keys) {
            *lent = roadmap.trees.lend(key, tree);
        }
    }

    fn return_trees(&mut self, roadmap: &mut Roadmap) {
        for (lent, tree) in self.lent.iter_mut().zip(&mut self.workspace.trees) {
            if let Some(index) = lent.take() {
                roadmap.trees.return_tree(index, tree);
            }
        }
    }

    /// The waypoints that the search has found, if they are new.
    fn path(&self) -> &[Configuration] {
        match &self.task {
            BatchTask::Sample(sampling) if sampling.found().is_some() => {
                &self.workspace.lift_offs[0]
            }
            BatchTask::Move { found: Some(true), .. }
            | BatchTask::Primitive { has_failed: false, .. } => &self.workspace.path,
            _ => &[],
        }
    }

    /// Records what the search found, its path stored there; answers whether that is anything.
    fn merge(&self, roadmap: &mut Roadmap, path: ArenaSlice) -> Result<bool, ArenaFull> {
        match &self.task {
            BatchTask::Idle => Ok(false),
            BatchTask::Sample(sampling) => {
                roadmap.record_sampling(sampling, path)?;
                Ok(sampling.found().is_some())
            }
            BatchTask::Move { edge, found: Some(true), .. } => {
                roadmap.record_motion(*edge, path)?;
                Ok(true)
            }
            BatchTask::Shorten { edge, .. } => {
                roadmap.shorten_motion(*edge, &self.workspace.path)?;
                Ok(true)
            }
            BatchTask::Primitive { has_failed: true, .. } => Ok(false),
            BatchTask::Primitive { edge, trajectory, .. } => {
                roadmap.record_primitive(*edge, trajectory.ends(), path)?;
                Ok(true)
            }
            BatchTask::Move { edge, search, .. } => {
                roadmap.record_failure(*edge, search.extensions())?;
                Ok(false)
            }
        }
    }
}
