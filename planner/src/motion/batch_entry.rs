//! An entry of a search batch: one search, its memory, and how its result enters the roadmap.

use crate::base::arena::ArenaSlice;
use crate::base::capacity::ArenaFull;
use crate::base::work_budget::{BudgetedTask, WorkBudget};
use crate::motion::mode_graph::ModeGraph;
use crate::motion::roadmap::{ModeEdge, Roadmap};
use crate::motion::shortcut::Shortcutting;
use crate::motion::single_mode::SingleModeSearch;
use crate::motion::transition_sampling::TransitionSampling;
use crate::motion::workspace::{Workspace, push};
use crate::preparation::planning_context::PlanningContext;
use crate::primitives::PrimitiveTrajectory;
use crate::robot::configuration::Configuration;

/// An entry of a batch: a task and its memory.
#[derive(Debug)]
pub(crate) struct BatchEntry {
    /// Index of the segment search that it belongs to.
    pub(crate) segment_search: usize,
    pub(crate) task: BatchTask,
    pub(crate) workspace: Workspace,
    /// Slots of the tree pool from which the trees of the workspace are lent.
    pub(crate) lent: [Option<usize>; 2],
    pub(crate) work_budget: WorkBudget,
}

/// The search of an entry.
#[derive(Debug)]
#[allow(clippy::large_enum_variant, reason = "a box would allocate during the search")]
pub(crate) enum BatchTask {
    /// No search.
    Idle,
    /// Sampling of a transition.
    Sample(TransitionSampling),
    /// Search for the motion of an edge; `found` is its result.
    Move { edge: ModeEdge, search: SingleModeSearch, found: Option<bool> },
    /// Shortcuts of the motion of an edge.
    Shorten { edge: ModeEdge, shortcutting: Shortcutting },
    /// Computation of a motion of pi_S.
    Primitive { edge: ModeEdge, trajectory: PrimitiveTrajectory, has_failed: bool },
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
    /// Spends one work unit.
    pub(crate) fn advance(&mut self, context: &PlanningContext, graph: &ModeGraph) {
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

    /// Borrows the trees of both ends of an edge from the pool.
    pub(crate) fn borrow_trees(&mut self, roadmap: &mut Roadmap, edge: ModeEdge) {
        let keys = roadmap.tree_keys(edge);
        for ((lent, tree), key) in self.lent.iter_mut().zip(&mut self.workspace.trees).zip(keys) {
            *lent = roadmap.trees.lend(key, tree);
        }
    }

    /// Returns the borrowed trees to the pool.
    pub(crate) fn return_trees(&mut self, roadmap: &mut Roadmap) {
        for (lent, tree) in self.lent.iter_mut().zip(&mut self.workspace.trees) {
            if let Some(index) = lent.take() {
                roadmap.trees.return_tree(index, tree);
            }
        }
    }

    /// The path that the search found; empty if it is not to be stored.
    pub(crate) fn path(&self) -> &[Configuration] {
        match &self.task {
            BatchTask::Sample(sampling) if sampling.found().is_some() => {
                &self.workspace.lift_offs[0]
            }
            BatchTask::Move { found: Some(true), .. }
            | BatchTask::Primitive { has_failed: false, .. } => &self.workspace.path,
            _ => &[],
        }
    }

    /// Records the result of the search, whose path is stored at `path`. Returns whether it
    /// succeeded.
    pub(crate) fn merge(&self, roadmap: &mut Roadmap, path: ArenaSlice) -> Result<bool, ArenaFull> {
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
