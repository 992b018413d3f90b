//! Multi-modal PRM over the modes of Gamma_M (Hauser, Latombe 2010) [Grey 5.3]: the cheapest
//! sequence of transitions, configurations for them, a motion within every mode; a failure makes
//! the sequence cost more, and the next one differs.

use surefoot_shared_types::message::SupportMode;

use crate::base::arena::{filled, reserve};
use crate::base::capacity::ArenaFull;
use crate::methods::workbench::{MethodEvent, Workbench};
use crate::motion::ids::{GOAL, START, TransitionId, boundary_node};
use crate::motion::roadmap::{Roadmap, RouteSegment};
use crate::motion::sequence_search::SequenceSearch;
use crate::motion::transition_sequence::{Objective, SequenceProblem};

/// What follows next.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Task {
    /// Begin to search a sequence.
    Seek(Objective),
    /// Search it.
    Search(Objective),
    /// Sample configurations from transition `next` on. `failed`: some before have none.
    Sample { next: usize, failed: bool },
    /// Plan motions from edge `next` on. `failed`: some before have none.
    Move { next: usize, failed: bool },
}

/// What an advance came to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Progress {
    /// There is more to do.
    Working,
    /// The sequence has all its motions.
    Complete,
    /// A sequence could not be completed; the next advance tries another one.
    Failed,
    /// No sequence leads from start to goal.
    Disconnected,
}

/// The search, allocated once.
#[derive(Debug)]
pub(crate) struct MultiModalPrm {
    search: SequenceSearch,
    sequence: Vec<TransitionId>,
    task: Task,
    /// Whether the sequence is given, so that no other one is tried.
    is_given: bool,
    objective: Objective,
    starts: heapless::Vec<TransitionId, 2>,
    /// All footholds may be used: the vertex nearest to each is the same.
    vertices: Vec<u32>,
}

impl MultiModalPrm {
    /// Reserves memory.
    pub fn new(footholds_max: usize, transitions_max: usize, sequence_max: usize) -> Self {
        Self {
            search: SequenceSearch::new(footholds_max, transitions_max),
            sequence: reserve(sequence_max),
            task: Task::Seek(Objective::Feasible),
            is_given: false,
            objective: Objective::Feasible,
            starts: heapless::Vec::new(),
            vertices: filled(0, footholds_max),
        }
    }

    /// The transitions from start to goal, once complete.
    pub fn sequence(&self) -> &[TransitionId] {
        &self.sequence
    }

    /// Begins with the cheapest sequence.
    pub fn begin(&mut self) {
        (self.task, self.is_given) = (Task::Seek(Objective::Feasible), false);
    }

    /// Begins with a given sequence.
    ///
    /// # Errors
    /// It has more transitions than may have configurations.
    pub fn begin_with(
        &mut self,
        sequence: impl Iterator<Item = TransitionId>,
    ) -> Result<(), ArenaFull> {
        self.sequence.clear();
        for id in sequence {
            self.push(id)?;
        }
        (self.task, self.is_given) = (Task::Sample { next: 0, failed: false }, true);
        Ok(())
    }

    fn push(&mut self, id: TransitionId) -> Result<(), ArenaFull> {
        if self.sequence.len() == self.sequence.capacity() {
            return Err(ArenaFull::Configurations);
        }
        self.sequence.push(id);
        Ok(())
    }

    /// Advances by at most `budget` units of work.
    ///
    /// # Errors
    /// An arena is full.
    pub fn advance(
        &mut self,
        bench: &mut Workbench<'_>,
        budget: u64,
    ) -> Result<Progress, ArenaFull> {
        match self.task {
            Task::Seek(objective) => {
                self.seek(bench, objective);
                Ok(Progress::Working)
            }
            Task::Search(objective) => self.search(bench, objective, budget),
            Task::Sample { next, failed } => self.sample(bench, (next, failed), budget),
            Task::Move { next, failed } => self.plan_motions(bench, (next, failed), budget),
        }
    }

    /// Advances a given sequence by at most `budget` units of work. Where it fails, the method's
    /// `task` becomes `again`.
    ///
    /// # Errors
    /// An arena is full.
    pub fn complete<T>(
        &mut self,
        bench: &mut Workbench<'_>,
        budget: u64,
        (task, again): (&mut T, T),
    ) -> Result<MethodEvent, ArenaFull> {
        match self.advance(bench, budget)? {
            Progress::Complete => return Ok(MethodEvent::Found),
            Progress::Working => {}
            Progress::Failed | Progress::Disconnected => *task = again,
        }
        Ok(MethodEvent::Continue)
    }

    /// Begins to search a sequence.
    fn seek(&mut self, bench: &mut Workbench<'_>, objective: Objective) {
        bench.counts.sequence += 1;
        let ends = [START, GOAL].map(boundary_node);
        if objective == Objective::ConnectModes {
            bench.roadmap.costs.update_connections(&bench.roadmap.graph, ends);
        }
        let [left, right] = bench.roadmap.boundary(START).footholds;
        let graph = &bench.roadmap.graph;
        let starts = [graph.find(left, right), graph.find(right, left)];
        self.starts = starts.into_iter().flatten().collect();
        self.task = Task::Search(objective);
        let Self { search, starts, vertices, .. } = self;
        search.begin(&problem(bench.roadmap, objective, starts, vertices));
    }

    /// Searches a sequence.
    fn search(
        &mut self,
        bench: &mut Workbench<'_>,
        objective: Objective,
        budget: u64,
    ) -> Result<Progress, ArenaFull> {
        let Self { search, starts, vertices, .. } = self;
        let spent = search.advance(&problem(bench.roadmap, objective, starts, vertices), budget);
        bench.counts.sequence += spent;
        if spent == budget {
            return Ok(Progress::Working);
        }
        bench.counts.sequence += 1;
        bench.counts.sequences += 1;
        self.objective = objective;
        if !self.search.has_found() {
            self.task = Task::Seek(Objective::Feasible);
            let is_first = objective == Objective::Feasible;
            return Ok(if is_first { Progress::Disconnected } else { Progress::Failed });
        }
        self.sequence.clear();
        for index in 0..self.search.sequence().len() {
            self.push(self.search.sequence()[index])?;
        }
        self.task = match objective {
            Objective::ConnectModes => Task::Move { next: 0, failed: false },
            _ => Task::Sample { next: 0, failed: false },
        };
        Ok(Progress::Working)
    }

    /// Samples configurations for the transitions of the sequence.
    fn sample(
        &mut self,
        bench: &mut Workbench<'_>,
        (next, failed): (usize, bool),
        budget: u64,
    ) -> Result<Progress, ArenaFull> {
        if !bench.batch.is_running() {
            bench.batch.begin();
            let segment = segment(&self.sequence);
            let next = bench.batch.add_sampling(0, bench.roadmap, segment, next);
            self.task = Task::Sample { next, failed };
        }
        let (spent, batch) = bench.advance_batch(budget)?;
        bench.counts.configurations += spent;
        let (Some(batch), Task::Sample { next, failed }) = (batch, self.task) else {
            return Ok(Progress::Working);
        };
        bench.counts.transitions_found += u64::from(batch.found);
        let failed = failed || batch.failures[0] > 0;
        if next < self.sequence.len() {
            self.task = Task::Sample { next, failed };
        } else if failed {
            self.task = Task::Seek(Objective::Feasible);
            return Ok(Progress::Failed);
        } else {
            self.objective = Objective::Feasible;
            self.task = Task::Move { next: 0, failed: false };
        }
        Ok(Progress::Working)
    }

    /// Plans motions along the sequence.
    fn plan_motions(
        &mut self,
        bench: &mut Workbench<'_>,
        (next, failed): (usize, bool),
        budget: u64,
    ) -> Result<Progress, ArenaFull> {
        if !bench.batch.is_running() {
            bench.batch.begin();
            let (segment, context) = (segment(&self.sequence), bench.context);
            let next = bench.batch.add_motions(0, context, bench.roadmap, segment, next);
            self.task = Task::Move { next, failed };
        }
        let (spent, batch) = bench.advance_batch(budget)?;
        bench.counts.motions += spent;
        let (Some(batch), Task::Move { next, failed }) = (batch, self.task) else {
            return Ok(Progress::Working);
        };
        bench.counts.motions_found += u64::from(batch.found);
        let failed = failed || batch.failures[0] > 0;
        if next <= self.sequence.len() {
            self.task = Task::Move { next, failed };
            return Ok(Progress::Working);
        }
        if !failed {
            return Ok(Progress::Complete);
        }
        if self.objective == Objective::Feasible && !self.is_given {
            self.task = Task::Seek(Objective::ConnectModes);
            return Ok(Progress::Working);
        }
        self.task = Task::Seek(Objective::Feasible);
        Ok(Progress::Failed)
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.search.bytes()
            + self.sequence.capacity() * size_of::<TransitionId>()
            + self.vertices.capacity() * size_of::<u32>()
    }
}

/// Whether the robot begins and ends on both feet.
pub(crate) fn are_ends_double(roadmap: &Roadmap) -> bool {
    [START, GOAL].iter().all(|&end| roadmap.boundary(end).support == SupportMode::Double)
}

/// A sequence from start to goal, as stage M takes it.
fn segment(sequence: &[TransitionId]) -> RouteSegment<'_> {
    RouteSegment { sequence, ends: [START, GOAL].map(boundary_node) }
}

fn problem<'a>(
    roadmap: &'a Roadmap,
    objective: Objective,
    starts: &'a [TransitionId],
    nearest_vertices: &'a [u32],
) -> SequenceProblem<'a> {
    SequenceProblem {
        graph: &roadmap.graph,
        edges: &roadmap.edges,
        modes: &roadmap.costs,
        objective,
        nearest_vertices,
        vertex_range: [0, 0],
        ends: [START, GOAL].map(boundary_node),
        starts,
        goal: roadmap.boundary(GOAL).footholds,
    }
}
