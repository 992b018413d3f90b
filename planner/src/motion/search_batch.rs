//! Batches of searches in parallel.
//!
//! A batch assigns one search to each of its entries, advances all of them one work unit at a time
//! within a budget, and merges the results in order once all have ended. The assignment depends on
//! the sequences only, and no search uses the results of another one of its batch. So neither the
//! number of threads nor the budgets change the results. Route segments that are planned in
//! parallel share a batch.

use crate::base::arena::ArenaSlice;
use crate::base::capacity::ArenaFull;
use crate::base::random::{Random, Stream};
use crate::base::threads::Threads;
use crate::base::work_budget;
use crate::base::work_budget::WorkBudget;
use crate::constraints::rejection::Rejection;
use crate::motion::batch_entry::{BatchEntry, BatchTask};
use crate::motion::cbirrt::SingleModeProblem;
use crate::motion::roadmap::{ModeEdge, Roadmap, RouteSegment};
use crate::motion::shortcut::{Pass, Shortcutting};
use crate::motion::single_mode::SingleModeSearch;
use crate::motion::transition_sampling::TransitionSampling;
use crate::motion::tuning::{
    BATCH_SEARCHES_MAX, PATH_WAYPOINTS_MAX, SEGMENT_SEARCHES_MAX, SHORTCUT_WORK_PER_WAYPOINT,
    TREE_NODES_MAX,
};
use crate::motion::workspace::Workspace;
use crate::preparation::planning_context::PlanningContext;
use crate::primitives::PrimitiveTrajectory;
use crate::robot::configuration::Configuration;

/// Statistics of a batch.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct BatchStats {
    /// Number of segment searches with entries in it.
    pub segment_searches: u64,
    /// Failed searches of each segment search.
    pub failures: [u32; SEGMENT_SEARCHES_MAX],
    /// Successful searches.
    pub found: u32,
    /// Number of rejections of each kind.
    pub rejections: [u64; Rejection::COUNT],
}

/// The searches of a batch, allocated once.
#[derive(Debug)]
pub struct SearchBatch {
    entries: Vec<BatchEntry>,
    /// Number of entries with a search.
    count: usize,
    is_running: bool,
}

impl Default for SearchBatch {
    /// Idle entries with empty workspaces. Allocates.
    fn default() -> Self {
        let entry = |_| BatchEntry {
            segment_search: 0,
            task: BatchTask::Idle,
            workspace: Workspace::new(PATH_WAYPOINTS_MAX, TREE_NODES_MAX),
            lent: [None; 2],
            work_budget: WorkBudget::default(),
        };
        Self { entries: (0..BATCH_SEARCHES_MAX).map(entry).collect(), count: 0, is_running: false }
    }
}

impl SearchBatch {
    /// Whether a batch has begun and is not merged.
    pub fn is_running(&self) -> bool {
        self.is_running
    }

    /// Begins a batch without searches.
    pub fn begin(&mut self) {
        (self.count, self.is_running) = (0, true);
    }

    /// Adds searches for the missing configurations of a sequence, from transition `next` on.
    /// Returns the index at which the next batch of the segment search continues: where the entries
    /// are used up, or another segment search samples the same transition.
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

    /// Adds searches for the missing motions of a segment, from edge `next` on. Edge 0 leads from
    /// the boundary before the segment to the first transition, the last edge to the boundary after
    /// it. Returns the index at which the next batch continues, like [`SearchBatch::add_sampling`].
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

    /// Adds the computation of a motion of pi_S. The batch must not be full, see
    /// [`SearchBatch::is_full`].
    pub fn add_primitive(&mut self, edge: ModeEdge, trajectory: PrimitiveTrajectory) {
        self.add_task(0, BatchTask::Primitive { edge, trajectory, has_failed: false });
    }

    /// Begins a batch that shortens the next motions with at most `work_max` work units in total.
    pub fn begin_shortcuts(
        &mut self,
        context: &PlanningContext,
        roadmap: &Roadmap,
        edges: impl Iterator<Item = ModeEdge>,
        (pass, work_max): (Pass, u64),
    ) {
        self.begin();
        let mut left = work_max;
        for edge in edges.take(BATCH_SEARCHES_MAX) {
            let Some(path) = roadmap.motion(edge).filter(|path| path.len() < PATH_WAYPOINTS_MAX)
            else {
                continue;
            };
            let work = left.min(SHORTCUT_WORK_PER_WAYPOINT * path.len() as u64);
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

    /// Whether the batch has no search.
    pub fn is_empty(&self) -> bool {
        self.count == 0
    }

    /// Whether all entries have a search.
    pub fn is_full(&self) -> bool {
        self.count == self.entries.len()
    }

    /// Spends at most `budget` work units. Returns the units spent; fewer than the budget mean that
    /// all searches have ended.
    pub fn advance(&mut self, context: &PlanningContext, roadmap: &Roadmap, budget: u64) -> u64 {
        work_budget::advance(&mut self.entries[..self.count], budget, &context.threads, |entry| {
            entry.advance(context, &roadmap.graph)
        })
    }

    /// Merges the results of the searches into the roadmap, in order.
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

    /// Stores the paths found. Returns their slices of the waypoint arena.
    fn store(
        &self,
        threads: &Threads,
        roadmap: &mut Roadmap,
    ) -> Result<heapless::Vec<ArenaSlice, BATCH_SEARCHES_MAX>, ArenaFull> {
        let paths: heapless::Vec<&[Configuration], BATCH_SEARCHES_MAX> =
            self.entries[..self.count].iter().map(BatchEntry::path).collect();
        roadmap.store(&paths, threads)
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.entries.iter().map(|entry| size_of::<BatchEntry>() + entry.workspace.bytes()).sum()
    }

    /// The segment search of the first entry whose task matches.
    fn segment_search_of(&self, is_match: impl Fn(&BatchTask) -> bool) -> Option<usize> {
        self.entries[..self.count]
            .iter()
            .find(|entry| is_match(&entry.task))
            .map(|entry| entry.segment_search)
    }

    /// Assigns a task to the next entry. Returns `false` if all entries are used.
    fn add_task(&mut self, segment_search: usize, task: BatchTask) -> bool {
        let Some(entry) = self.entries.get_mut(self.count) else { return false };
        (entry.segment_search, entry.task) = (segment_search, task);
        entry.workspace.clear();
        self.count += 1;
        true
    }
}
