//! Shortens the motions of a complete plan: shortcuts and local optimisation within each mode
//! [Grey 4.4.6].

use surefoot_shared_types::base::limits::CHUNK_WAYPOINTS_MAX;

use crate::base::capacity::ArenaFull;
use crate::motion::ids::TransitionId;
use crate::motion::indexed_heap::IndexHeap;
use crate::motion::roadmap::{ModeEdge, Roadmap};
use crate::motion::shortcut::{Pass, distance, length};
use crate::pipeline::search::Search;
use crate::pipeline::stage::{Event, WorkCategory};
use crate::preparation::planning_context::PlanningContext;

/// A motion whose detour ratio, the straight distance relative to its length, is greater than this
/// gets no shortcuts.
const DETOUR_RATIO_MAX: f64 = 0.8;

/// What the stage does next.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Task {
    /// Begin with a new plan.
    Begin,
    /// Rank the motions of the plan from `next` on.
    Rank { next: usize },
    /// Apply shortcuts to motions in batches.
    Shortcut(Pass),
}

/// The motions that are to be shortened.
#[derive(Debug)]
struct ShortcutQueue {
    /// Edges of the plan by their detour ratio.
    ranked: IndexHeap,
    /// The next edge whose corners are cut.
    next_corner: usize,
}

impl ShortcutQueue {
    /// The next edge of a plan to shorten.
    fn pop(&mut self, plan: &[TransitionId], goal: Pass) -> Option<ModeEdge> {
        match goal {
            Pass::Shortcuts => {
                self.ranked.pop().and_then(|(index, ..)| edge_of(plan, index as usize))
            }
            Pass::Corners => {
                self.next_corner += 1;
                edge_of(plan, self.next_corner - 1)
            }
        }
    }
}

/// Ranks the motions of the plan by how much they deviate from a straight line, one per unit of
/// work; then tries shortcuts, the worst motions first; then optimises all motions in turn with
/// the work that is left. A shorter motion replaces the one in Gamma_M.
#[derive(Debug)]
pub(crate) struct ShortcutStage {
    task: Task,
    queue: ShortcutQueue,
    /// The stage ends when the search has spent this much work.
    work_end: u64,
}

impl ShortcutStage {
    /// Reserves memory for plans of `edges_max` motions.
    pub fn new(edges_max: usize) -> Self {
        let queue = ShortcutQueue { ranked: IndexHeap::new(edges_max), next_corner: 0 };
        Self { task: Task::Begin, queue, work_end: 0 }
    }

    /// Ranks a motion, or advances a batch.
    ///
    /// # Errors
    /// An arena is full.
    pub fn step(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        budget: u64,
    ) -> Result<Event, ArenaFull> {
        if self.task == Task::Begin {
            self.queue.ranked.clear();
            self.queue.next_corner = 0;
            self.work_end = shortcut_work_end(context, search);
            self.task = Task::Rank { next: 0 };
        }
        match self.task {
            Task::Shortcut(goal) => self.apply_shortcuts(context, search, goal, budget),
            Task::Rank { next } => Ok(self.rank(search, next)),
            Task::Begin => Ok(Event::Continue),
        }
    }

    /// Ranks one motion of the plan by its detour ratio.
    fn rank(&mut self, search: &mut Search, next: usize) -> Event {
        search.stats.work += 1;
        let Some(edge) = edge_of(search.segmentation.plan(), next) else {
            self.task = Task::Shortcut(Pass::Shortcuts);
            return Event::Continue;
        };
        let ratio = detour_ratio(&search.roadmap, edge);
        if let Some(ratio) = ratio.filter(|ratio| *ratio <= DETOUR_RATIO_MAX) {
            self.queue.ranked.push(next as u32, ratio, 0);
        }
        self.task = Task::Rank { next: next + 1 };
        Event::Continue
    }

    /// Applies shortcuts to motions of the plan, one batch after the other.
    fn apply_shortcuts(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        goal: Pass,
        budget: u64,
    ) -> Result<Event, ArenaFull> {
        if !search.batch.is_running() {
            let work = self.work_end.saturating_sub(search.stats.work + 1);
            let Search { batch, segmentation, roadmap, .. } = search;
            let edges = std::iter::from_fn(|| self.queue.pop(segmentation.plan(), goal));
            batch.begin_shortcuts(context, roadmap, edges, (goal, work));
        }
        let is_last = search.batch.is_empty();
        if search.advance_batch(context, budget)?.is_none() || !is_last {
            return Ok(Event::Continue);
        }
        if goal == Pass::Shortcuts {
            self.task = Task::Shortcut(Pass::Corners);
            return Ok(Event::Continue);
        }
        self.task = Task::Begin;
        Ok(Event::Done)
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.queue.ranked.bytes()
    }
}

/// The work at which the shortcuts of a complete plan end: a share of the work so far without that
/// of the relaxed problem, which makes nothing, and no more than leaves enough to rank its motions
/// and to write its chunks.
pub(crate) fn shortcut_work_end(context: &PlanningContext, search: &Search) -> u64 {
    let (edges, waypoints) = (search.segmentation.plan().len(), search.roadmap.waypoints_len());
    let chunks_work = (3 * edges + waypoints / (CHUNK_WAYPOINTS_MAX - 1) + 1) as u64;
    let work = search.stats.work;
    let counted = work - search.stats.work_by_category[WorkCategory::Relaxation as usize];
    let wanted = (context.constraints.config.shortcut_work_share * counted as f64) as u64;
    work.saturating_add(wanted).min(search.limits.work_max.saturating_sub(chunks_work))
}

/// An edge of a plan, between two of its transitions.
fn edge_of(plan: &[TransitionId], index: usize) -> Option<ModeEdge> {
    let pair = plan.get(index..index + 2)?;
    Some(ModeEdge { from: pair[0], to: pair[1] })
}

/// The straight distance of a motion relative to its length; `None` where there is no motion.
fn detour_ratio(roadmap: &Roadmap, edge: ModeEdge) -> Option<f64> {
    let (first, path) = (roadmap.state(edge.from).configuration, roadmap.motion(edge)?);
    let whole = distance(&first, path.first()?) + length(path);
    Some(distance(&first, path.last()?) / whole)
}
