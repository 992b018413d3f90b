//! Builds a planner: compiles robot and world, and reserves all memory of a search.

use std::num::NonZeroUsize;
use std::sync::Arc;

use surefoot_shared_types::Pose;
use surefoot_shared_types::config::MotionKind;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::config::scenario::Scenario;
use surefoot_shared_types::message::{PlanChunk, RestState};
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::World;

use crate::base::arena::reserve;
use crate::base::threads::Threads;
use crate::collision::error::CollisionError;
use crate::collision::model::CollisionModel;
use crate::constraints::constraints::Constraints;
use crate::constraints::tuning::COM_MARGIN_RESERVE;
use crate::foot_placement::sole_support::SurfacesError;
use crate::foot_placement::{
    Bearing, FootPlacementConfig, Scratch, SoleNeeds, Surfaces, find_bearing,
};
use crate::geometry::polygon::diameter;
use crate::methods::method::{Method, MethodParameters};
use crate::methods::method_search::MethodSearch;
use crate::motion::roadmap::Roadmap;
use crate::motion::search_batch::SearchBatch;
use crate::pipeline::chunk_stage::ChunkStage;
use crate::pipeline::direct_steps::DirectSteps;
use crate::pipeline::endpoint_stage::EndpointStage;
use crate::pipeline::endpoints::StanceSurfaces;
use crate::pipeline::foothold_order::{FootholdOrder, VertexSelection};
use crate::pipeline::improvement_stage::ImprovementStage;
use crate::pipeline::live_routes::LiveRoutes;
use crate::pipeline::method_stage::MethodStage;
use crate::pipeline::outcome::Outcome;
use crate::pipeline::planner::{Planner, Stages};
use crate::pipeline::primitive_stage::PrimitiveStage;
use crate::pipeline::recovery_stage::RecoveryStage;
use crate::pipeline::relaxation_stage::RelaxationStage;
use crate::pipeline::resorts::Resorts;
use crate::pipeline::retrace::{Retrace, executed_before, lift_off_before, rest_in};
use crate::pipeline::route_stage::RouteStage;
use crate::pipeline::search::{
    Connections, FootholdSampling, GuideState, Margins, Search, SearchLimits, SearchStats,
};
use crate::pipeline::segment_searches::SegmentSearches;
use crate::pipeline::segmentation::Segmentation;
use crate::pipeline::segmentation_stage::SegmentationStage;
use crate::pipeline::sequence_stage::SequenceStage;
use crate::pipeline::shortcut_stage::ShortcutStage;
use crate::pipeline::smooth_path_stage::SmoothPathStage;
use crate::pipeline::stage::Stage;
use crate::pipeline::trial_motion::{self, TrialMotion};
use crate::pipeline::uniform_rounds::UniformRounds;
use crate::plan::chunk_builder::{ChunkBuilder, Provenance};
use crate::plan::time_parameterization::{BalanceReserve, TimeParameterization};
use crate::possibility::{CrouchProfile, RouteSearch, SPACING_PER_REACH, UpperBody};
use crate::preparation::Preparation;
use crate::preparation::PreparationError;
use crate::preparation::planning_context::{LeastMargins, PlanningContext};
use crate::robot::mechanism::{Mechanism, MechanismError};
use crate::timing::limits::TimingLimits;
use crate::timing::path_timing::PathTiming;
use crate::timing::timed_robot::TimedRobot;

/// Number of sides of the pyramid that a checker may put inside the friction cone. Vertical forces
/// must lie in it, too.
const FRICTION_SIDES: f64 = 8.0;

/// Why a planner cannot be built from these inputs.
#[derive(Debug, thiserror::Error)]
pub enum PlannerError {
    /// The planner cannot move this robot.
    #[error(transparent)]
    Mechanism(#[from] MechanismError),
    /// A shape cannot be compiled for collision checks.
    #[error(transparent)]
    Collision(#[from] CollisionError),
    /// A shape cannot be compiled into surfaces to stand on.
    #[error(transparent)]
    Surfaces(#[from] SurfacesError),
    /// The preparation was made for another robot or other margins.
    #[error("the preparation {0}")]
    Preparation(#[from] PreparationError),
    /// The threads cannot be started.
    #[error("cannot start {threads} planner threads: {reason}")]
    Threads {
        /// Number of threads.
        threads: usize,
        /// Reason that the system gives.
        reason: String,
    },
}

/// How the chunks of a plan are made.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Making {
    /// All of them are final at the end.
    Whole,
    /// The first ones are final before the last ones are made.
    InParts,
    /// The plan is improved with this work.
    Improved { work: u64 },
}

/// The inputs of a planner. [`Planner::builder`] sets the required ones.
#[derive(Debug, Clone)]
pub struct PlannerBuilder<'a> {
    model: &'a RobotModel,
    world: &'a World,
    scenario: &'a Scenario,
    preparation: Preparation,
    threads: NonZeroUsize,
    may_exceed_cores: bool,
    /// Plan id and epoch.
    plan_name: (u64, u64),
    rest_state: Option<&'a RestState>,
    /// The chunks executed last, and how many lift-offs the plan retraces.
    retrace: (&'a [PlanChunk], usize),
    /// Sole poses with half the sides (m) of the rectangle around each.
    keep_out: Vec<(Pose, [f64; 2])>,
    method: (Method, MethodParameters),
    making: Making,
}

impl Planner {
    /// Begins with a robot, a world, a scenario, and the preparation of the robot for the
    /// scenario's margins. One thread.
    pub fn builder<'a>(
        model: &'a RobotModel,
        world: &'a World,
        scenario: &'a Scenario,
        preparation: Preparation,
    ) -> PlannerBuilder<'a> {
        PlannerBuilder {
            model,
            world,
            scenario,
            preparation,
            threads: NonZeroUsize::MIN,
            may_exceed_cores: false,
            plan_name: (1, 0),
            rest_state: None,
            retrace: (&[], 0),
            keep_out: Vec::new(),
            method: (Method::Rpg, MethodParameters::default()),
            making: Making::Whole,
        }
    }
}

impl<'a> PlannerBuilder<'a> {
    /// Number of threads that share the work, the calling one included; at most one for each core
    /// that the process may use. It has no influence on the plan.
    pub fn threads(self, threads: NonZeroUsize) -> Self {
        Self { threads, may_exceed_cores: false, ..self }
    }

    /// Number of threads, also where the process may use fewer cores: to test that the plan does
    /// not depend on it.
    pub fn uncapped_threads(self, threads: NonZeroUsize) -> Self {
        Self { threads, may_exceed_cores: true, ..self }
    }

    /// Plan id and epoch that the chunks carry. Plan 1, epoch 0 by default.
    pub fn plan_name(self, plan_id: u64, epoch: u64) -> Self {
        Self { plan_name: (plan_id, epoch), ..self }
    }

    /// Starts in a state that the robot is in, on both feet or on one, in place of the scenario's
    /// start stance. Its feet get the support that the world gives them.
    pub fn start_in(self, rest_state: &'a RestState) -> Self {
        Self { rest_state: Some(rest_state), ..self }
    }

    /// Lets the plan retrace the `executed` chunks first, which led to the state given by
    /// [`PlannerBuilder::start_in`]: back to the `depth`-th last lift-off at which every condition
    /// holds, or the farthest. With depth 0 this is done only if a condition is violated in the
    /// state itself, and then to the last such lift-off.
    pub fn retrace(self, executed: &'a [PlanChunk], depth: usize) -> Self {
        Self { retrace: (executed, depth), ..self }
    }

    /// Searches by another method, over the same constraints and work limit.
    pub fn method(self, method: Method, parameters: MethodParameters) -> Self {
        Self { method: (method, parameters), ..self }
    }

    /// Improves the plan, with at most `work` units after it is found and within the limit of the
    /// whole search: other walks are made from it, and the one that takes the least time is the
    /// plan. 0 leaves the first plan as it is.
    pub fn improve(self, work: u64) -> Self {
        if work == 0 { self } else { Self { making: Making::Improved { work }, ..self } }
    }

    fn improvement_work(&self) -> u64 {
        if let Making::Improved { work } = self.making { work } else { 0 }
    }

    /// Makes the first chunks of a smooth plan final while the rest of it is made, so that they can
    /// be sent. It is the same plan, unless no smooth motion continues the part that is final
    /// ([`Outcome::NoContinuation`]). A plan that is improved is never made in parts.
    pub fn in_parts(self) -> Self {
        if self.making == Making::Whole { Self { making: Making::InParts, ..self } } else { self }
    }

    /// Keeps soles out of a rectangle with these half sides (m) around a sole pose; see
    /// [`CollisionModel::add_keep_out_zone`].
    pub fn keep_out(mut self, world_from_sole: Pose, half_sides: [f64; 2]) -> Self {
        self.keep_out.push((world_from_sole, half_sides));
        self
    }

    /// Compiles robot and world, and reserves all memory of a search.
    ///
    /// # Errors
    /// The planner cannot use the robot or the world, the preparation is that of another robot, or
    /// the threads cannot be started.
    pub fn build(self) -> Result<Planner, PlannerError> {
        let (context, placement) = self.context()?;
        let config = &self.scenario.planner;
        let mut search = self.search(&context, &placement);
        search.direct.is_tried = search.footholds.uniform.replace_sweeps();
        let (method, parameters) = self.method;
        let method = MethodStage { search: MethodSearch::new(method, parameters, config) };
        let mut endpoints = EndpointStage::new(self.scenario, self.world);
        endpoints.is_other_method = method.search.is_some();
        let edges_max = config.configurations_max as usize;
        let Constraints { robot, waist, .. } = &context.constraints;
        let upper_body = Arc::new(UpperBody::new(self.model, robot, waist.as_ref()));
        let stages = Stages {
            relaxation: RelaxationStage::new(Arc::clone(&upper_body)),
            route: RouteStage::new(upper_body, endpoints.stances()[0].stance_width),
            endpoints,
            segmentation: SegmentationStage::default(),
            primitives: PrimitiveStage::default(),
            sequence: SequenceStage::new(
                config.footholds_max as usize,
                config.transitions_max as usize,
            ),
            recovery: RecoveryStage::default(),
            shortcuts: ShortcutStage::new(edges_max),
            smooth_path: SmoothPathStage::new(
                self.scenario.execution.motion == MotionKind::Smooth,
                self.making == Making::InParts,
                edges_max,
                config.waypoints_max as usize,
            ),
            chunks: ChunkStage::new(
                self.chunks(&context),
                self.timing(config.waypoints_max as usize),
                (self.improvement_work() > 0).then(|| self.chunks(&context)),
            ),
            improvement: ImprovementStage::new(self.improvement_work(), edges_max, self.trial()),
            method,
        };
        let joint_names = self.model.joints.iter().map(|joint| joint.name.clone()).collect();
        let mut planner = Planner { context, search, stages, stage: Stage::Endpoints, joint_names };
        self.begin_in_rest_state(&mut planner)?;
        for (world_from_sole, half_sides) in &self.keep_out {
            planner.context.constraints.collision.add_keep_out_zone(world_from_sole, *half_sides);
        }
        Ok(planner)
    }

    /// The read-only data of the search, and the limits of foot placement.
    fn context(&self) -> Result<(PlanningContext, FootPlacementConfig), PlannerError> {
        let config: &PlannerConfig = &self.scenario.planner;
        let robot = Mechanism::new(self.model, config)?;
        let collision = CollisionModel::new(self.model, self.world, config.clearance)?;
        let placement = placement_config(&robot, self.world, self.scenario);
        let least_margins = LeastMargins::new(config, &self.scenario.checker);
        let mut surfaces = Surfaces::new(self.world, placement.clone())?;
        let length = robot.soles.iter().map(|sole| diameter(&sole.polygon)).fold(0.0, f64::max);
        find_bearing(&mut surfaces, SoleNeeds { length, least: least_margins.support });
        if !self.preparation.is_for(self.model, config) {
            return Err(PreparationError::OtherRobot.into());
        }
        let start = if self.may_exceed_cores { Threads::uncapped } else { Threads::new };
        let threads = start(self.threads).map_err(|error| PlannerError::Threads {
            threads: self.threads.get(),
            reason: error.to_string(),
        })?;
        let mut constraints = Constraints::new(robot, collision, config.clone());
        constraints.checked_com_margin = self.scenario.checker.com_margin;
        let (preparation, seed) = (self.preparation.clone(), self.scenario.seed);
        let context =
            PlanningContext { constraints, surfaces, preparation, threads, seed, least_margins };
        Ok((context, placement))
    }

    /// The data that the stages share.
    fn search(&self, context: &PlanningContext, placement: &FootPlacementConfig) -> Search {
        let config = &self.scenario.planner;
        let vertices_max = config.tree_vertices_max as usize;
        let transitions_max = config.configurations_max as usize;
        let bounds = context.constraints.collision.world_bounds();
        let ends = [&self.scenario.start, &self.scenario.goal];
        let walking_width = context.preparation.step_limits().walking_width();
        let (method, parameters) = self.method;
        let discs = (method == Method::RpgDiscs).then_some(parameters);
        let route = || {
            let spacing = vertex_spacing(config, &context.constraints.robot);
            RouteSearch::new(ends, walking_width, spacing, vertices_max, &bounds, placement)
        };
        Search {
            roadmap: Roadmap::new(config, context.preparation.step_limits().reach()),
            route: route(),
            guide: GuideState {
                crouch: CrouchProfile::new(vertices_max),
                live: LiveRoutes::new((1..config.live_routes).map(|_| route())),
                is_relaxed: false,
                is_ground_due: Bearing::of(&context.surfaces).has_bare_ground(),
            },
            footholds: FootholdSampling {
                order: FootholdOrder::Sweep { next: 0 },
                selection: VertexSelection::new(2 * vertices_max),
                uniform: UniformRounds::new(
                    context.preparation.step_limits().longest_level_step(),
                    bounds,
                    discs,
                ),
                scratch: [(); 2].map(|()| Scratch::new(placement)),
            },
            connections: Connections {
                next: None,
                long_steps: false,
                nearest_vertices: reserve(config.footholds_max as usize),
                is_new_route: false,
                uniform_from: None,
            },
            direct: DirectSteps::new(),
            segmentation: Segmentation::new(transitions_max),
            segments: SegmentSearches::new(config),
            batch: SearchBatch::default(),
            limits: SearchLimits {
                work_max: config.work_max,
                resorts: Resorts::default(),
                margins: Margins::Configured,
            },
            stats: SearchStats::default(),
            outcome: None,
        }
    }

    /// The motion of parts of a plan that are tried, if smooth plans are improved.
    fn trial(&self) -> Option<TrialMotion> {
        let is_wanted = self.improvement_work() > 0;
        let timing = is_wanted.then(|| self.timing(trial_motion::POINTS_MAX)).flatten();
        timing.map(TrialMotion::new)
    }

    /// The timing of smooth paths of `points_max` points, if plans are smoothed.
    fn timing(&self, points_max: usize) -> Option<PathTiming> {
        let execution = &self.scenario.execution;
        let limits =
            TimingLimits::new(self.model, execution, self.world.mu, &self.scenario.checker);
        (execution.motion == MotionKind::Smooth)
            .then(|| PathTiming::new(TimedRobot::new(self.model, limits), points_max))
    }

    /// The builder of the plan's chunks.
    fn chunks(&self, context: &PlanningContext) -> ChunkBuilder {
        let provenance = Provenance {
            robot: self.model.digest,
            world: self.world.digest,
            config: self.scenario.digest,
            joints_len: context.constraints.robot.joints_len,
            goal: self.scenario.goal,
        };
        let waypoints_max = self.scenario.planner.waypoints_max as usize;
        let checked_margin = self.scenario.checker.com_margin + COM_MARGIN_RESERVE;
        let most = self.scenario.planner.com_margin - checked_margin;
        let balance = BalanceReserve { checked_margin, most };
        let timing = TimeParameterization::new(self.model, balance, self.world.mu);
        let mut chunks = ChunkBuilder::new(waypoints_max, provenance, timing);
        let (plan_id, epoch) = self.plan_name;
        chunks.set_plan_id(plan_id, epoch);
        chunks
    }

    /// Begins in the state that the robot is in, if one is given, or at an earlier lift-off.
    fn begin_in_rest_state(&self, planner: &mut Planner) -> Result<(), PlannerError> {
        let Some(rest_state) = self.rest_state else { return Ok(()) };
        let mut ground = StanceSurfaces::new(self.world)?;
        let rest_state = ground.with_support(&planner.context.constraints.robot, rest_state);
        start_in(planner, rest_state);
        let endpoints = &planner.stages.endpoints;
        let (executed, depth) = self.retrace;
        let is_valid = endpoints.is_rest_state_valid(&planner.context);
        let depth = if is_valid { depth } else { depth.max(1) };
        let conditions = (&planner.context.constraints, endpoints.com_margin());
        let lift_off = if depth > 0 {
            lift_off_before(conditions, self.world, &rest_state, (executed, depth))?
        } else {
            None
        };
        let Some(lift_off) = lift_off else { return Ok(()) };
        let rests = self.scenario.execution.motion == MotionKind::Smooth;
        let mut stop = lift_off.since.last().map(|last| rest_in(last, &rest_state.waypoint));
        for chunk in lift_off.since.iter().rev() {
            let Some(end) = stop.take().or(chunk.waypoints().last().copied()) else { continue };
            let before = executed_before(chunk, end.time);
            let chunks = &mut planner.stages.chunks.chunks;
            if let Err(full) = chunks.append_reversed(chunk, (&end, before), rests) {
                planner.end(Outcome::ArenaFull(full));
            }
        }
        planner.stages.endpoints.retrace =
            Retrace { chunks: lift_off.since.len(), depth: lift_off.depth };
        start_in(planner, lift_off.rest_state);
        Ok(())
    }
}

/// Begins in a state that the robot is in.
fn start_in(planner: &mut Planner, rest_state: RestState) {
    if let Some(start) = planner.stages.endpoints.start_in(rest_state) {
        planner.search.route.set_start(&start);
        planner.search.guide.live.searches_mut().for_each(|route| route.set_start(&start));
        planner.stages.route.set_stance_width(start.stance_width);
    }
}

/// Distance between the vertices of a route, m: the configured one, less for short legs.
fn vertex_spacing(config: &PlannerConfig, robot: &Mechanism) -> f64 {
    config.route_vertex_spacing.min(SPACING_PER_REACH * robot.shorter_reach())
}

/// Limits of foot placement for this robot's soles and the world's friction.
fn placement_config(robot: &Mechanism, world: &World, scenario: &Scenario) -> FootPlacementConfig {
    let standard = FootPlacementConfig::for_soles(
        &robot.soles.each_ref().map(|sole| sole.polygon.clone()),
        scenario.planner.support_area_min,
        &scenario.checker,
        COM_MARGIN_RESERVE,
    );
    let steepest = libm::atan(world.mu * libm::cos(std::f64::consts::PI / FRICTION_SIDES));
    FootPlacementConfig {
        friction_margin: standard.friction_margin.max(libm::atan(world.mu) - steepest),
        // Near placements come first, however small their support: the search weighs it
        // (docs/decisions/0010-foot-placement.md).
        support_area_inflation: 1.0,
        centre_height: robot.centre_height,
        ..standard
    }
}
