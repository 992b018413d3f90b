//! The planner: read this first.
//!
//! A search is a sequence of stages. Each stage advances by bounded pieces of work, until an event
//! leads to another stage, as the table in `stage_table.rs` says:
//!
//! | stage | makes | thesis |
//! | --- | --- | --- |
//! | Endpoints | the robot at the start and at the goal | 4.4.1 |
//! | Route | a guide route, with the crouch profile (stage P) | 3, 4.1-4.3 |
//! | RouteGrowth | further routes beside the current one, in the rounds of stage M | 3.2 |
//! | Relaxation | the proof that there is no plan, where it is easy | |
//! | DirectSteps | footholds of steps straight to a near goal | 4.4.2 |
//! | Segmentation | segments of the route that share their end states | 3.2 |
//! | Footholds | footholds along the route | 4.2, 4.4.4 |
//! | Connections | transitions between footholds | 4.4.2 |
//! | Primitives | configurations and motions of pi_S | 3.2, 4.4.5 |
//! | Segments | the choice of the next task | |
//! | Estimates | prior costs of transitions | 4.4.2 |
//! | Sequence | the cheapest sequence of transitions | 4.4.2 |
//! | Configurations | configurations for the transitions | 4.4.2 |
//! | Motions | motions within single modes | 4.4.3 |
//! | Recovery | the action that follows a failure | 4.4.4 |
//! | Shortcuts | shorter motions | 4.4.6 |
//! | SmoothPath | the smooth path that is executed | |
//! | Chunks | the chunks of the plan and their digest | |
//! | Improvement | other walks, of which the fastest is kept | |
//! | Method | a walk by another method, in place of Route to Recovery | 2, 5 |
//!
//! A sequence that cannot be completed costs more afterwards, so the next one differs. Where
//! sequences cost too much or there is none, more footholds are sampled, and stage P finds another
//! route. The footholds of all routes stand in one graph, so each sequence may use any of them.
//! Steps are removed from a complete sequence [Grey 4.4.6]. Several segments are planned in
//! parallel; the plan is complete once all are.

use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::message::PlanChunk;

use crate::base::capacity::ArenaFull;
use crate::constraints::constraints::Constraints;
use crate::foot_placement::{Scratch, Surfaces};
use crate::motion::ids::{TransitionId, boundary_of};
use crate::motion::mode_graph::ModeGraph;
use crate::pipeline::bottlenecks::Bottleneck;
use crate::pipeline::chunk_stage::ChunkStage;
use crate::pipeline::connection_stage::ConnectionStage;
use crate::pipeline::direct_stage::DirectStage;
use crate::pipeline::endpoint_stage::EndpointStage;
use crate::pipeline::foothold_stage::FootholdStage;
use crate::pipeline::improvement::Improvement;
use crate::pipeline::improvement_stage::ImprovementStage;
use crate::pipeline::method_stage::MethodStage;
use crate::pipeline::outcome::{Bound, Outcome, Status};
use crate::pipeline::outcome_text;
use crate::pipeline::primitive_stage::PrimitiveStage;
use crate::pipeline::recovery_stage::RecoveryStage;
use crate::pipeline::relaxation_stage::{self, RelaxationStage};
use crate::pipeline::resorts::Resort;
use crate::pipeline::retrace::{Retrace, steps_retraced};
use crate::pipeline::route_stage::RouteStage;
use crate::pipeline::search::{Margins, Search, SearchStats};
use crate::pipeline::search_trace::SearchTrace;
use crate::pipeline::segment_cycle::{ConfigurationStage, MotionStage};
use crate::pipeline::segment_stage::SegmentStage;
use crate::pipeline::segmentation_stage::SegmentationStage;
use crate::pipeline::sequence_stage::SequenceStage;
use crate::pipeline::shortcut_stage::ShortcutStage;
use crate::pipeline::smooth_path_stage::SmoothPathStage;
use crate::pipeline::stage::{Event, Stage, WorkCategory};
use crate::pipeline::stage_table;
use crate::possibility::RouteSearch;
use crate::preparation::Preparation;
use crate::preparation::planning_context::PlanningContext;
use crate::relaxation::Obstruction;
use crate::timing::limit::BindingTimes;
use crate::timing::path_point::{PathPoint, PathSpan};

/// Work units between two calls of the condition of [`Planner::step_while`].
const WORK_PER_CALL: u64 = 4_096;

/// A planner for one robot, world and scenario. All memory is allocated when it is built.
#[derive(Debug)]
pub struct Planner {
    pub(crate) context: PlanningContext,
    pub(crate) search: Search,
    pub(crate) stages: Stages,
    pub(crate) stage: Stage,
    pub(crate) joint_names: Vec<String>,
}

/// The stages that have a state.
#[derive(Debug)]
pub(crate) struct Stages {
    pub endpoints: EndpointStage,
    pub route: RouteStage,
    pub relaxation: RelaxationStage,
    pub segmentation: SegmentationStage,
    pub primitives: PrimitiveStage,
    pub sequence: SequenceStage,
    pub recovery: RecoveryStage,
    pub shortcuts: ShortcutStage,
    pub smooth_path: SmoothPathStage,
    pub chunks: ChunkStage,
    pub improvement: ImprovementStage,
    pub method: MethodStage,
}

impl Stages {
    /// Advances a stage by one piece of work, or by several within a budget.
    fn step(
        &mut self,
        stage: Stage,
        context: &PlanningContext,
        search: &mut Search,
        budget: u64,
    ) -> Result<Event, ArenaFull> {
        match stage {
            Stage::Endpoints => self.endpoints.step(context, search, budget),
            Stage::Route => self.route.step(context, search, budget),
            Stage::RouteGrowth => Ok(self.route.grow_beside(context, search, budget)),
            Stage::Relaxation => self.relaxation.step(context, search, budget),
            Stage::DirectSteps => DirectStage.step(context, search, budget),
            Stage::Segmentation => self.segmentation.step(context, search, budget),
            Stage::Footholds => FootholdStage.step(context, search, budget),
            Stage::Connections => ConnectionStage.step(context, search, budget),
            Stage::Primitives => self.primitives.step(context, search, budget),
            Stage::Segments => SegmentStage.step(context, search, budget),
            Stage::Estimates | Stage::Sequence => self.sequence.step(context, search, budget),
            Stage::Configurations => ConfigurationStage.step(context, search, budget),
            Stage::Motions => MotionStage.step(context, search, budget),
            Stage::Recovery => self.recovery.step(context, search, budget),
            Stage::Shortcuts => self.shortcuts.step(context, search, budget),
            Stage::SmoothPath => self.smooth_path.step(context, search, budget),
            Stage::Chunks => {
                let path = self.smooth_path.path();
                self.chunks.step(context, search, path, budget)
            }
            Stage::Improvement => {
                let event = self.improvement.step(context, search, &mut self.chunks, budget)?;
                if event == Event::NewWalk {
                    self.smooth_path.begin_another();
                }
                Ok(event)
            }
            Stage::Method => self.method.step(context, search, budget),
            Stage::Over => Ok(Event::Continue),
        }
    }
}

/// Where a search pauses before its work is spent.
#[derive(Debug, Clone, Copy)]
enum Pause {
    Never,
    /// Where the first chunk is final.
    FirstChunk,
    /// Where the work counts for another category than this one.
    Category(Option<WorkCategory>),
}

impl Planner {
    /// Advances the search by at most `work` units, or to its end.
    pub fn step(&mut self, work: u64) -> Status {
        self.step_while(work, &|| true)
    }

    /// Advances the search by at most `work` units, or until `may_continue` returns `false`: it is
    /// called now and then, for example to react to a signal. It has no influence on the plan.
    pub fn step_while(&mut self, work: u64, may_continue: &(dyn Fn() -> bool + Sync)) -> Status {
        self.step_to(Pause::Never, work, may_continue)
    }

    /// Like [`Planner::step_while`], and no further than to the first final chunk.
    pub fn step_to_first_chunk(
        &mut self,
        work: u64,
        may_continue: &(dyn Fn() -> bool + Sync),
    ) -> Status {
        self.step_to(Pause::FirstChunk, work, may_continue)
    }

    /// Advances the search by at most `work` units, or until its work counts for another category:
    /// for measurements.
    pub fn step_category(&mut self, work: u64) -> Status {
        let pause = Pause::Category(self.stage.category());
        self.in_pool(|planner| planner.advance(pause, work))
    }

    fn step_to(
        &mut self,
        pause: Pause,
        work: u64,
        may_continue: &(dyn Fn() -> bool + Sync),
    ) -> Status {
        let until = self.search.stats.work.saturating_add(work);
        self.in_pool(|planner| {
            loop {
                let left = until - planner.search.stats.work;
                let status = planner.advance(pause, left.min(WORK_PER_CALL));
                if status != Status::Working
                    || planner.search.stats.work >= until
                    || planner.is_at(pause)
                    || !may_continue()
                {
                    return status;
                }
            }
        })
    }

    fn in_pool(&mut self, advance: impl FnOnce(&mut Self) -> Status) -> Status {
        let threads = self.context.threads.clone();
        threads.run(|| advance(self))
    }

    fn is_at(&self, pause: Pause) -> bool {
        match pause {
            Pause::Never => false,
            Pause::FirstChunk => !self.final_chunks().is_empty(),
            Pause::Category(category) => category.is_some() && category != self.stage.category(),
        }
    }

    /// Advances by at most `work` units, or to the pause.
    fn advance(&mut self, pause: Pause, work: u64) -> Status {
        let until = self.search.stats.work.saturating_add(work).min(self.search.limits.work_max);
        while self.search.stats.work < until && !self.is_at(pause) && self.stage != Stage::Over {
            self.step_stage(until - self.search.stats.work);
            while matches!(self.stage, Stage::Segments | Stage::Recovery) {
                self.step_stage(0);
            }
        }
        if self.stage != Stage::Over && self.search.stats.work >= self.search.limits.work_max {
            self.end_or_take_best(Outcome::BudgetExhausted(Bound::Work));
        }
        self.search.outcome.map_or(Status::Working, Status::Done)
    }

    /// Advances the current stage, and takes the next one from the table.
    fn step_stage(&mut self, budget: u64) {
        let Self { context, search, stages, stage, .. } = self;
        let before = search.stats.work;
        let event = stages.step(*stage, context, search, budget);
        let category = match stages.improvement.improvement() {
            None => stage.category(),
            Some(_) => Some(WorkCategory::Improvement),
        };
        if let Some(category) = category {
            search.stats.work_by_category[category as usize] += search.stats.work - before;
        }
        if search.limits.margins == Margins::Due {
            context.relax_margins();
            search.limits.margins = Margins::Least;
        }
        match event {
            Ok(event) => *stage = stage_table::next(*stage, event),
            Err(full) => self.end_or_take_best(Outcome::ArenaFull(full)),
        }
    }

    /// Ends the search; while a plan is improved, with the best one.
    fn end_or_take_best(&mut self, outcome: Outcome) {
        if !self.stop_improving() {
            self.end(outcome);
        }
    }

    /// Ends the improvement of a plan with the best one so far. Returns whether there is one.
    pub fn stop_improving(&mut self) -> bool {
        if self.stage == Stage::Over || self.improvement().is_none() {
            return false;
        }
        self.stages.improvement.end(&mut self.search, &mut self.stages.chunks);
        self.stage = Stage::Over;
        true
    }

    /// What the improvement of the plan came to; `None` without one.
    pub fn improvement(&self) -> Option<Improvement> {
        self.stages.improvement.improvement()
    }

    /// Ends the search.
    pub(crate) fn end(&mut self, outcome: Outcome) {
        (self.stage, self.search.outcome) = (Stage::Over, Some(outcome));
    }

    /// Lowers the limit of the search's work to `work_max` units.
    pub fn limit_work(&mut self, work_max: u64) {
        self.search.limits.work_max = work_max.min(self.search.limits.work_max);
    }

    fn has_found(&self) -> bool {
        self.search.outcome == Some(Outcome::Found)
    }

    /// The chunks of the plan, once found. Their session and receiver are not set.
    pub fn chunks(&self) -> &[PlanChunk] {
        if self.has_found() { self.stages.chunks.chunks() } else { &[] }
    }

    /// The chunks that are final, also while the search goes on: a plan that it finds begins with
    /// them. Their session and receiver are not set. While a plan is to be improved there are none.
    pub fn final_chunks(&self) -> &[PlanChunk] {
        let is_final = !self.stages.improvement.is_wanted() || self.has_found();
        if is_final { self.stages.chunks.final_chunks() } else { &[] }
    }

    /// How long each limit binds the smooth motion; none of a quasi-static one.
    pub fn binding_times(&self) -> Option<&BindingTimes> {
        self.stages.chunks.binding_of_plan().filter(|_| self.has_found())
    }

    /// The name of a joint.
    pub fn joint_name(&self, joint: usize) -> Option<&str> {
        self.joint_names.get(joint).map(String::as_str)
    }

    /// The digest of the plan's chunks, once found.
    pub fn digest(&self) -> Digest {
        self.stages.chunks.digest()
    }

    /// Why no plan is possible, if the relaxed problem shows it, whatever the search has found: for
    /// tests and measurements. `None` before start and goal are known. Allocates.
    pub fn obstruction(&self) -> Option<Obstruction> {
        relaxation_stage::obstruction(&self.context, &self.search)
    }

    /// Leaves the relaxed problem out, what it shows and the coarse path that it gives: for tests
    /// and measurements.
    pub fn search_on(&mut self) {
        self.stages.route.skip_relaxation(&mut self.search);
    }

    /// Searches without one of the last resorts: for measurements of what it finds. To be called
    /// before the first step.
    pub fn leave_out(&mut self, resort: Resort) {
        self.search.limits.resorts.leave_out(resort);
        let leave_out: fn(&mut RouteSearch) = match resort {
            Resort::WiderRegion => |route| route.later_mut().may_widen = false,
            Resort::NecessaryCondition => |route| route.later_mut().has_necessary = false,
            Resort::LeaningRoot => |route| route.later_mut().has_leaning = false,
            Resort::Alternatives
            | Resort::UniformRounds
            | Resort::GoalPostures
            | Resort::LeastMargins => return,
        };
        leave_out(&mut self.search.route);
        self.search.guide.live.searches_mut().for_each(leave_out);
    }

    /// The statistics of the search.
    pub fn stats(&self) -> SearchStats {
        self.search.stats
    }

    /// The outcome as one line for a person: what ended the search and what to do about it.
    /// Allocates.
    pub fn describe(&self, outcome: &Outcome) -> String {
        outcome_text::describe(&self.context, self.stages.endpoints.stances(), outcome)
    }

    /// The place where most sequences failed, if any did.
    pub fn bottleneck(&self) -> Option<Bottleneck> {
        self.stages.recovery.bottleneck()
    }

    /// How far the search came. Allocates.
    pub fn trace(&self) -> SearchTrace {
        SearchTrace::of(&self.search.route, self.stats().used_straight_line, self.bottleneck())
    }

    /// How far back the plan leads first.
    pub fn retrace(&self) -> Retrace {
        self.stages.endpoints.retrace
    }

    /// The robot, the world and the conditions of every configuration.
    pub fn constraints(&self) -> &Constraints {
        &self.context.constraints
    }

    /// The surfaces on which soles can rest.
    pub fn surfaces(&self) -> &Surfaces {
        &self.context.surfaces
    }

    /// The preparation of the robot.
    pub fn preparation(&self) -> &Preparation {
        &self.context.preparation
    }

    /// Number of waypoints of the plan, once found.
    pub fn waypoints(&self) -> u64 {
        if self.has_found() { self.stages.chunks.chunks.waypoints() } else { 0 }
    }

    /// Number of steps of the plan, once found: how often a foot is lifted and set down.
    pub fn steps(&self) -> u64 {
        let plan = if self.has_found() { self.search.segmentation.plan() } else { &[] };
        let is_boundary = |node: TransitionId| boundary_of(node).is_some();
        let is_swing = |pair: &&[TransitionId]| {
            !is_boundary(pair[0]) && !is_boundary(pair[1]) && pair[1] != ModeGraph::twin(pair[0])
        };
        let retraced = steps_retraced(self.chunks(), self.retrace().chunks);
        (plan.windows(2).filter(is_swing).count() + retraced) as u64
    }

    /// The smooth path of the plan, once found: its points and its spans. None where the plan keeps
    /// the searched motion, or was improved.
    pub fn smooth_path(&self) -> Option<(&[PathPoint], &[PathSpan])> {
        let is_of_plan = self.has_found() && self.improvement().is_none();
        let path = self.stages.smooth_path.path().filter(|_| is_of_plan)?.path;
        Some((path.points, path.spans))
    }

    /// Bytes of all arenas by name.
    pub fn arena_bytes(&self) -> [(&'static str, usize); 12] {
        let Self { context, search, stages, .. } = self;
        let nearest_vertices = search.connections.nearest_vertices.capacity() * size_of::<u32>();
        let sequences = stages.sequence.bytes()
            + search.segments.bytes()
            + search.segmentation.bytes()
            + search.footholds.selection.bytes()
            + search.direct.bytes()
            + nearest_vertices;
        let possibility = search.route.bytes()
            + search.guide.live.bytes()
            + search.guide.crouch.bytes()
            + stages.relaxation.bytes();
        [
            ("possibility", possibility),
            ("roadmap", search.roadmap.bytes()),
            ("batches", search.batch.bytes()),
            ("sequences", sequences),
            ("chunks", stages.chunks.bytes()),
            ("collision", context.constraints.collision.bytes()),
            ("surfaces", context.surfaces.heap_bytes()),
            ("foot placement", search.footholds.scratch.iter().map(Scratch::heap_bytes).sum()),
            ("shortcuts", stages.shortcuts.bytes()),
            ("smooth path", stages.smooth_path.bytes()),
            ("method", stages.method.bytes()),
            ("improvement", stages.improvement.bytes()),
        ]
    }
}
