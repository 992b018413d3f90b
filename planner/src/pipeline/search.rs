//! The data that the stages share and change, and the statistics of a search.

use crate::base::capacity::ArenaFull;
use crate::constraints::rejection::Rejection;
use crate::foot_placement::Scratch;
use crate::motion::ids::FootholdId;
use crate::motion::roadmap::Roadmap;
use crate::motion::search_batch::{BatchStats, SearchBatch};
use crate::pipeline::direct_steps::DirectSteps;
use crate::pipeline::foothold_order::{FootholdOrder, VertexSelection};
use crate::pipeline::live_routes::LiveRoutes;
use crate::pipeline::outcome::Outcome;
use crate::pipeline::resorts::{Resort, Resorts};
use crate::pipeline::segment_searches::SegmentSearches;
use crate::pipeline::segmentation::Segmentation;
use crate::pipeline::stage::WorkCategory;
use crate::pipeline::uniform_rounds::UniformRounds;
use crate::possibility::{CrouchProfile, LabelStats, RouteSearch};
use crate::preparation::planning_context::PlanningContext;

/// What the stages share and change. All memory is reserved when the planner is built.
#[derive(Debug)]
pub(crate) struct Search {
    /// Gamma_M: all that stage M has found.
    pub roadmap: Roadmap,
    /// Gamma_P, with the guide route found last.
    pub route: RouteSearch,
    /// What belongs to the guide route.
    pub guide: GuideState,
    /// Orders and memory for foothold sampling.
    pub footholds: FootholdSampling,
    /// State of the transitions between footholds.
    pub connections: Connections,
    /// The direct steps to a near goal.
    pub direct: DirectSteps,
    /// The segments of the route.
    pub segmentation: Segmentation,
    /// The searches of the segments.
    pub segments: SegmentSearches,
    /// Searches for configurations and motions that run in parallel.
    pub batch: SearchBatch,
    /// What the search may do.
    pub limits: SearchLimits,
    /// Statistics.
    pub stats: SearchStats,
    /// The result, once the search has ended.
    pub outcome: Option<Outcome>,
}

/// What belongs to the guide route of stage P.
#[derive(Debug)]
pub(crate) struct GuideState {
    /// How the robot crouches along the route.
    pub crouch: CrouchProfile,
    /// The routes beside it.
    pub live: LiveRoutes,
    /// Whether the relaxed problem is solved, or left out.
    pub is_relaxed: bool,
    /// Whether the relaxed problem is to show, before the first route, whether a way leads around
    /// ground on which no sole rests.
    pub is_ground_due: bool,
}

/// What the search may do.
#[derive(Debug)]
pub(crate) struct SearchLimits {
    /// Limit of the work, in units.
    pub work_max: u64,
    /// The last resorts that may be used.
    pub resorts: Resorts,
    /// The margins that configurations and footholds keep.
    pub margins: Margins,
}

/// The margins of a search.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Margins {
    /// Those of the configuration.
    Configured,
    /// The least ones from the next step on.
    Due,
    /// The least ones: little more than the checker demands.
    Least,
}

/// What the foothold stage samples, and its memory.
#[derive(Debug)]
pub(crate) struct FootholdSampling {
    /// The next task.
    pub order: FootholdOrder,
    /// The vertices that a sweep visits.
    pub selection: VertexSelection,
    /// The rounds of uniform footholds.
    pub uniform: UniformRounds,
    /// Memory for foot placement queries of two threads.
    pub scratch: [Scratch; 2],
}

/// How far footholds are connected and located on the route.
#[derive(Debug)]
pub(crate) struct Connections {
    /// The next foothold to connect; none before the first.
    pub next: Option<FootholdId>,
    /// Whether footholds are connected that are farther apart than primitive postures reach.
    pub long_steps: bool,
    /// The vertex of the route nearest to each foothold, if the foothold may be used there.
    pub nearest_vertices: Vec<u32>,
    /// Whether the route is new, so that primitives are to be laid along it.
    pub is_new_route: bool,
    /// The first foothold of a uniform round that is not connected yet.
    pub uniform_from: Option<FootholdId>,
}

impl Connections {
    /// Locates all footholds again, on a new route.
    pub fn begin_route(&mut self) {
        self.nearest_vertices.clear();
        self.is_new_route = true;
    }

    /// Connects all footholds again, those beyond the reach of primitive postures included. They
    /// slow the search down, so this is done only where the others do not lead to the goal.
    pub fn begin_long_steps(&mut self) {
        self.long_steps = true;
        self.next = Some(0);
    }
}

impl Search {
    /// Advances the batch by at most `budget` units of work. Returns what it did once all its
    /// searches have ended.
    ///
    /// # Errors
    /// An arena is full.
    pub fn advance_batch(
        &mut self,
        context: &PlanningContext,
        budget: u64,
    ) -> Result<Option<BatchStats>, ArenaFull> {
        let spent = self.batch.advance(context, &self.roadmap, budget);
        self.stats.work += spent;
        self.guide.live.count_work(spent);
        if spent == budget {
            return Ok(None);
        }
        self.stats.work += 1;
        let batch = self.batch.merge(&context.threads, &mut self.roadmap)?;
        self.stats.segments_at_once = self.stats.segments_at_once.max(batch.segment_searches);
        for (total, count) in self.stats.rejections.iter_mut().zip(batch.rejections) {
            *total += count;
        }
        Ok(Some(batch))
    }

    /// Keeps the sequence of the current segment as complete, and begins with another segment.
    ///
    /// # Errors
    /// The sequence does not fit.
    pub fn complete_segment(&mut self) -> Result<(), ArenaFull> {
        let Self { segments, segmentation, .. } = self;
        segmentation.complete(segments.current().segment, &segments.current().sequence)?;
        segments.begin_next(segmentation.len());
        if let Some(vertex) = segmentation.traversed() {
            self.route.mark_traversed(vertex);
        }
        Ok(())
    }

    /// Relaxes the margins after this step, once. Returns whether it does.
    pub fn relax_margins(&mut self) -> bool {
        let is_due = self.limits.margins == Margins::Configured
            && self.limits.resorts.has(Resort::LeastMargins);
        if is_due {
            self.limits.margins = Margins::Due;
            self.stats.has_least_margins = true;
        }
        is_due
    }

    /// Begins a sweep of the selected vertices, or the round of uniform footholds that replaces it.
    pub fn begin_sweep(&mut self) {
        let FootholdSampling { order, uniform, .. } = &mut self.footholds;
        *order = FootholdOrder::Sweep { next: 0 };
        if uniform.replace_sweeps() {
            uniform.rounds += 1;
            *order = FootholdOrder::Uniform { left: uniform.round_footholds() };
        }
    }

    /// Whether a round of uniform footholds begins in place of leaving the route.
    pub fn is_uniform_due(&mut self) -> bool {
        self.limits.resorts.has(Resort::UniformRounds) && self.footholds.uniform.is_due()
    }

    /// Whether a transition on partial support keeps its prior cost: only once better footholds
    /// have failed.
    pub fn may_use_partial_support(&self) -> bool {
        self.stats.routes > 1 || self.stats.sweeps > 1
    }
}

/// Statistics of a search.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct SearchStats {
    /// Work units spent.
    pub work: u64,
    /// Work units spent, by [`WorkCategory`].
    pub work_by_category: [u64; WorkCategory::COUNT],
    /// Sequences tried.
    pub sequences: u64,
    /// Guide routes followed, detours included.
    pub routes: u64,
    /// Guide routes found under C_N alone, where no route meets the other conditions of stage P.
    pub routes_under_c_n: u64,
    /// Guide routes along which the root leans, where no upright route is free.
    pub leaning_routes: u64,
    /// Whether stage P found no route, so that a straight line was tried.
    pub used_straight_line: bool,
    /// Turns from one live route to another.
    pub turns: u64,
    /// Postures at the goal that replaced an earlier one.
    pub goal_postures: u64,
    /// Whether the margins were relaxed to little more than the checker demands.
    pub has_least_margins: bool,
    /// Most segments of a route that shared a batch.
    pub segments_at_once: u64,
    /// Sweeps for footholds along guide routes.
    pub sweeps: u64,
    /// Transitions with a configuration.
    pub transitions_found: u64,
    /// Motions found.
    pub motions_found: u64,
    /// Motions that pi_S gave.
    pub primitives: u64,
    /// Motions that pi_S could not give although C_S holds; always 0.
    pub primitives_failed: u64,
    /// How often the robot rests between the first and the last configuration of a smooth path.
    pub rests: u64,
    /// Phases of a smooth path that keep the searched motion.
    pub searched_phases: u64,
    /// Points of a smooth path at which the robot cannot stand within the full margins of timing,
    /// but within smaller ones.
    pub relaxed_points: u64,
    /// Points of a smooth path at which no contact forces within the limits hold the robot.
    pub beyond_limits: u64,
    /// Chunks of a smooth path in which the robot cannot stop within the limits.
    pub without_stop: u64,
    /// Pieces of a smooth path without a timing within the limits: the robot rests at their
    /// waypoints.
    pub untimed_pieces: u64,
    /// Edges of the current guide route.
    pub route_edges: LabelStats,
    /// Edges of the trees of stage P.
    pub tree_edges: LabelStats,
    /// Rejected configurations and motions, by [`Rejection`].
    pub rejections: [u64; Rejection::COUNT],
}
