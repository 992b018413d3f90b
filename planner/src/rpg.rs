//! The planner: read this first.
//!
//! A search runs through phases, each advanced by bounded pieces of work:
//!
//! ```text
//! Ends      stand the robot on the start and the goal
//! Route     where the robot could perhaps go: stage P    [Grey 3, 4.1-4.3]
//! Stoop     where something hangs over the route         [Grey 3.2]
//! Cut       into segments that share their end states    [Grey 3.2]
//! Seed      foot placements along the guide route        [Grey 4.4.4]
//! Connect   transitions between neighbouring placements  [Grey 4.4.2]
//! Primitive what pi_S gives along possible edges         [Grey 3.2, 4.4.5]
//! Emit      its motions, side by side
//! Sequence  the cheapest sequence of transitions         [Grey 4.4.2]
//! Judge     how likely those are that it holds           [Grey 4.4.2]
//! Sample    configurations for its transitions           [Grey 4.4.2]
//! Move      motions within its modes                     [Grey 4.4.3]
//! Weigh     which motions are crooked                    [Grey 4.4.6]
//! Polish    shortcuts and corners within the modes       [Grey 4.4.6]
//! Assemble  chunks out of the motions
//! Scatter   more placements about a step that is not found   [Grey 4.4.4]
//! Vary      the placements of a step that is not found   [Grey 4.4.4]
//! ```
//!
//! A sequence that cannot be completed has become dearer, so the next one is another; where the
//! sequences grow too dear or there is none, more placements are sampled, and stage P looks for
//! another route. All routes' placements stand in one graph, so that each sequence may use any of
//! them. A sequence that is complete is shortened [Grey 4.4.6]. Several segments are planned side
//! by side (`rpg/lanes.rs`); once all are complete, so is the plan.

mod connect;
mod cycle;
mod hindrances;
mod judging;
mod lanes;
mod phase;
mod polish;
mod primitive_stretches;
mod remedies;
mod seeking;
mod segments;
mod shorten;
mod start;

use std::num::NonZeroUsize;

use surefoot_shared_types::Pose;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::config::scenario::Scenario;
use surefoot_shared_types::message::{PlanChunk, RestState};
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::World;

use crate::base::arena::reserve;
use crate::base::threads::Threads;
use crate::base::work_budget::items_in;
use crate::collision::model::CollisionModel;
use crate::constraints::constraints::Constraints;
use crate::foot_placement::sole_support::SurfacesError;
use crate::foot_placement::{FootPlacementConfig, Scratch, Surfaces};
use crate::geometry::CollisionError;
use crate::motion::mode_graph::{
    ArenaFull, GOAL, ModeGraph, START, TransitionId, boundary_node, boundary_of,
};
use crate::motion::roadmap::{Boundary, ModeEdge, Roadmap};
use crate::motion::search_batch::SearchBatch;
use crate::outcome::{Bound, Outcome, Status};
use crate::plan::chunk_builder::{ChunkBuilder, ModeMotion, PARALLEL_MOTIONS_MAX, Provenance};
use crate::plan::time_parameterization::TimeParameterization;
use crate::possibility::{
    CrouchContext, CrouchProfile, Progress, RouteSearch, StageContext, UpperBody,
};
use crate::preparation::PreparationError;
use crate::preparation::build::Preparation;
use crate::preparation::planning_context::Shared;
use crate::robot::mechanism::{Mechanism, MechanismError};
use crate::rpg::hindrances::Hindrances;
use crate::rpg::judging::Judging;
use crate::rpg::lanes::Lanes;
use crate::rpg::phase::Phase;
use crate::rpg::polish::Polish;
use crate::rpg::primitive_stretches::Walker;
use crate::rpg::seeking::Seeker;
use crate::rpg::segments::Cuts;
use crate::seeding::{Seeding, is_step};
use crate::stage::Stage;
use crate::trouble::Focus;

pub use crate::rpg::hindrances::Hindrance;
pub use crate::rpg::phase::Tally;
pub use crate::rpg::start::WayBack;

/// Why a planner cannot be made for these inputs.
#[derive(Debug, thiserror::Error)]
pub enum PlannerError {
    /// The robot is none that this planner can move.
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
        /// How many were asked for.
        threads: usize,
        /// What the system says.
        reason: String,
    },
}

/// A planner for one robot, world and scenario. All memory is allocated by [`Planner::new`].
#[derive(Debug)]
pub struct Planner {
    shared: Shared,
    roadmap: Roadmap,
    round: SearchBatch,
    /// For queries about placements, by two threads at once.
    scratch: [Scratch; 2],
    torso: UpperBody,
    growth: RouteSearch,
    stooping: CrouchProfile,
    scenario: Scenario,
    seeker: Seeker,
    judging: Judging,
    chunks: ChunkBuilder,
    phase: Phase,
    standing: Option<RestState>,
    way_back: WayBack,
    cuts: Cuts,
    lanes: Lanes,
    polish: Polish,
    /// The station of the route that is nearest to each placement, if it may be used there.
    nearest_stations: Vec<u32>,
    /// How many stations the route had before the detour that is being sought.
    stations_before: Option<usize>,
    /// The walk from start to goal: transitions and the nodes of boundaries.
    walk: Vec<TransitionId>,
    tally: Tally,
    hindrances: Hindrances,
    digest: Digest,
    focus: Focus,
    /// Whether placements are connected that are farther apart than primitive postures reach.
    stretches: bool,
    /// The robot on its way along the possible edges of a new route.
    walker: Option<Walker>,
}

impl Planner {
    /// Compiles the robot and the world and allocates all that a search needs. `preparation` is the
    /// robot's, for the scenario's margins.
    ///
    /// # Errors
    /// The robot or the world is none that this planner can use, the preparation is another
    /// robot's, or the threads cannot be started.
    pub fn new(
        model: &RobotModel,
        world: &World,
        scenario: &Scenario,
        preparation: Preparation<'static>,
        threads: NonZeroUsize,
    ) -> Result<Self, PlannerError> {
        let config: &PlannerConfig = &scenario.planner;
        let robot = Mechanism::new(model, config)?;
        let collision = CollisionModel::new(model, world, config.clearance)?;
        let placement = placement_config(&robot, world, scenario);
        let scratch = [(); 2].map(|()| Scratch::new(&placement));
        let surfaces = Surfaces::new(world, placement.clone())?;
        if !preparation.is_for(model, config) {
            return Err(PreparationError::OtherRobot.into());
        }
        let provenance = Provenance {
            robot: model.digest,
            world: world.digest,
            config: scenario.digest,
            joints_len: robot.joints_len,
        };
        let started = Threads::new(threads);
        let threads = started.map_err(|error| PlannerError::Threads {
            threads: threads.get(),
            reason: error.to_string(),
        })?;
        let torso = UpperBody::new(model, &robot);
        let tree_vertices_max = config.tree_vertices_max as usize;
        let reach = preparation.step_limits().reach();
        let stooping = CrouchProfile::new(tree_vertices_max);
        let ends = [&scenario.start, &scenario.goal];
        let growth = RouteSearch::new(
            ends,
            config.route_vertex_spacing,
            tree_vertices_max,
            &collision.world_bounds(),
            &placement,
        );
        Ok(Self {
            shared: Shared {
                constraints: Constraints { robot, collision, config: config.clone() },
                surfaces,
                preparation,
                threads,
                seed: scenario.seed,
            },
            roadmap: Roadmap::new(config, reach),
            round: SearchBatch::default(),
            scratch,
            torso,
            growth,
            stooping,
            scenario: scenario.clone(),
            seeker: Seeker::new(config.footholds_max as usize, config.transitions_max as usize),
            judging: Judging::default(),
            chunks: ChunkBuilder::new(
                config.waypoints_max as usize,
                provenance,
                TimeParameterization::new(model),
            ),
            phase: Phase::Ends,
            standing: None,
            way_back: WayBack::default(),
            cuts: Cuts::new(config.configurations_max as usize),
            lanes: Lanes::new(config),
            polish: Polish::new(config.configurations_max as usize),
            nearest_stations: reserve(config.footholds_max as usize),
            stations_before: None,
            walk: reserve(config.configurations_max as usize),
            tally: Tally::default(),
            hindrances: Hindrances::default(),
            digest: Digest::default(),
            focus: Focus::new(2 * tree_vertices_max),
            stretches: false,
            walker: None,
        })
    }

    /// Lowers the bound of the search's work to `work_max` units.
    pub fn limit_work(&mut self, work_max: u64) {
        let configured = &mut self.shared.constraints.config.work_max;
        *configured = work_max.min(*configured);
    }

    /// Keeps soles away from where one was not carried, whatever the world's shapes say; see
    /// [`CollisionModel::shun`]. To be called before the first step.
    pub fn shun(&mut self, world_from_sole: &Pose, half_sides: [f64; 2]) {
        self.shared.constraints.collision.add_keep_out_zone(world_from_sole, half_sides);
    }

    /// Sets the name that the plan's chunks carry: which plan of its session it is, and how often
    /// it was planned again. Plan 1, epoch 0, unless told otherwise. To be called before the first
    /// step.
    pub fn name_plan(&mut self, plan_id: u64, epoch: u64) {
        self.chunks.set_plan_id(plan_id, epoch);
    }

    /// Advances the search by at most `work` units, or to its end.
    pub fn step(&mut self, work: u64) -> Status {
        self.step_while(work, &|| true)
    }

    /// The same, but no farther once `goes_on`, asked now and then, says no: for a signal that asks
    /// for the end. When it does so has no influence on the plan.
    pub fn step_while(&mut self, work: u64, goes_on: &(dyn Fn() -> bool + Sync)) -> Status {
        let until = self.tally.work.saturating_add(work);
        self.in_pool(|planner| {
            loop {
                let status =
                    planner.step_inside((until - planner.tally.work).min(WORK_PER_LOOK), None);
                if status != Status::Working || planner.tally.work >= until || !goes_on() {
                    return status;
                }
            }
        })
    }

    /// The same, but no farther than to the end of the stage that the search is in: for whoever
    /// times stages.
    pub fn step_stage(&mut self, work: u64) -> Status {
        let stage = self.phase.stage();
        self.in_pool(|planner| planner.step_inside(work, Some(stage)))
    }

    fn in_pool(&mut self, advance: impl FnOnce(&mut Self) -> Status + Send) -> Status {
        let threads = self.shared.threads.clone();
        threads.run(|| advance(self))
    }

    /// Advances by at most `work` units, and no farther than to the end of a stage.
    fn step_inside(&mut self, work: u64, only: Option<Stage>) -> Status {
        let until =
            self.tally.work.saturating_add(work).min(self.shared.constraints.config.work_max);
        while self.tally.work < until && only.is_none_or(|stage| stage == self.phase.stage()) {
            if let Phase::Over(outcome) = self.phase {
                return Status::Done(outcome);
            }
            let (stage, before) = (self.phase.stage(), self.tally.work);
            if !self.phase.counts() {
                self.tally.work += 1;
            }
            self.phase = self
                .advance(until - before)
                .unwrap_or_else(|full| Phase::Over(Outcome::ArenaFull(full)));
            self.tally.work_by_stage[stage as usize] += self.tally.work - before;
        }
        if let Phase::Over(outcome) = self.phase {
            return Status::Done(outcome);
        }
        if self.tally.work >= self.shared.constraints.config.work_max {
            let outcome = Outcome::BudgetExhausted(Bound::Work);
            self.phase = Phase::Over(outcome);
            return Status::Done(outcome);
        }
        Status::Working
    }

    /// The plan's chunks, once found; complete but for who receives them.
    pub fn chunks(&self) -> &[PlanChunk] {
        if self.has_found() { self.chunks.chunks() } else { &[] }
    }

    fn has_found(&self) -> bool {
        self.phase == Phase::Over(Outcome::Found)
    }

    /// The digest of the chunk stream, once found.
    pub fn digest(&self) -> Digest {
        self.digest
    }

    /// What the search has done so far.
    pub fn tally(&self) -> Tally {
        self.tally
    }

    /// Where the search failed most often to get on, if it did.
    pub fn hindrance(&self) -> Option<Hindrance> {
        self.hindrances.worst()
    }

    /// The robot, the world and the conditions of every configuration.
    pub fn constraints(&self) -> &Constraints {
        &self.shared.constraints
    }

    /// Waypoints of the plan, once found.
    pub fn waypoints(&self) -> u64 {
        if self.has_found() { self.chunks.waypoints() } else { 0 }
    }

    /// Steps of the plan, once found: how often a foot is lifted and set down.
    pub fn steps(&self) -> u64 {
        let walk = if self.has_found() { self.walk.as_slice() } else { &[] };
        let is_boundary = |node: TransitionId| boundary_of(node).is_some();
        let is_swing = |pair: &&[TransitionId]| {
            !is_boundary(pair[0]) && !is_boundary(pair[1]) && pair[1] != ModeGraph::twin(pair[0])
        };
        (walk.windows(2).filter(is_swing).count() + self.steps_back()) as u64
    }

    /// Bytes of all arenas by name.
    pub fn arena_bytes(&self) -> [(&'static str, usize); 9] {
        let walk = self.walk.capacity() * size_of::<TransitionId>()
            + self.nearest_stations.capacity() * size_of::<u32>();
        let sequence = self.seeker.bytes()
            + self.lanes.bytes()
            + self.cuts.bytes()
            + self.focus.bytes()
            + walk;
        [
            ("possibility", self.growth.bytes() + self.stooping.bytes()),
            ("roadmap", self.roadmap.bytes()),
            ("rounds", self.round.bytes()),
            ("sequence", sequence),
            ("chunks", self.chunks.bytes()),
            ("collision", self.shared.constraints.collision.bytes()),
            ("surfaces", self.shared.surfaces.heap_bytes()),
            ("foot placement", self.scratch.iter().map(Scratch::heap_bytes).sum()),
            ("polish", self.polish.bytes()),
        ]
    }

    /// Advances the phase by one piece of work, or by as many as a budget allows.
    fn advance(&mut self, budget: u64) -> Result<Phase, ArenaFull> {
        match self.phase {
            Phase::Ends => self.stand_on_ends(),
            Phase::Route => self.find_route(budget),
            Phase::Stoop => Ok(self.stoop(budget)),
            Phase::Cut { station } => self.cut(station),
            Phase::Seed { next } => self.seed(next),
            Phase::Connect { next } => self.connect(next, budget),
            Phase::Judge => self.judge(budget),
            Phase::Scatter { index } => self.scatter(index),
            Phase::Vary { index, tried, end } => self.vary(index, tried, end, budget),
            Phase::Primitive => self.begin_primitive(),
            Phase::Emit => self.emit_primitives(budget),
            Phase::Sequence => self.seek_alone(budget),
            Phase::Sample => self.sample(budget),
            Phase::Move => self.plan_motions(budget),
            Phase::Weigh { next } => Ok(self.weigh(next)),
            Phase::Polish(goal) => self.polish(goal, budget),
            Phase::Assemble { next } => self.assemble(next, budget),
            Phase::Seal => self.seal(budget),
            Phase::Over(_) => Ok(self.phase),
        }
    }

    fn find_route(&mut self, budget: u64) -> Result<Phase, ArenaFull> {
        let context = StageContext {
            constraints: &self.shared.constraints,
            surfaces: &self.shared.surfaces,
            upper_body: &self.torso,
            preparation: &self.shared.preparation,
            seed: self.shared.seed,
            stance_width: self.scenario.start.stance_width,
            threads: &self.shared.threads,
            is_step,
        };
        let (progress, spent) = self.growth.advance(&context, budget);
        self.tally.work += spent;
        self.tally.tree_edges = self.growth.labelled();
        match progress {
            Progress::Growing => return Ok(Phase::Route),
            Progress::Route => {}
            Progress::Full if self.tally.routes == 0 => return Err(ArenaFull::TreeVertices),
            Progress::Exhausted if self.tally.routes == 0 => {
                self.tally.is_unguided = true;
                self.growth.use_straight_line();
            }
            Progress::Exhausted | Progress::Full => {
                self.stations_before = None;
                self.growth.unblock_all();
                return Ok(Phase::Connect { next: self.roadmap.graph.connected() });
            }
        }
        let is_detour = |station: usize| !self.growth.placements(station).is_empty();
        let stations = self.growth.route().vertex_count();
        let is_whole = !(0..stations).any(is_detour) || self.tally.routes == 0;
        self.focus.only(stations, |station| is_whole || is_detour(station));
        self.tally.routes += 1;
        self.tally.route_edges = self.growth.route().labelled();
        self.walker = Some(Walker::default());
        self.nearest_stations.clear();
        self.stooping.begin();
        Ok(if self.growth.route().is_upright() { self.cut_anew_or_shift() } else { Phase::Stoop })
    }

    /// Finds out how the robot stoops along the route.
    fn stoop(&mut self, budget: u64) -> Phase {
        let Constraints { robot, collision, .. } = &self.shared.constraints;
        let site = CrouchContext {
            robot,
            upper_body: &self.torso,
            collision,
            threads: &self.shared.threads,
        };
        let (spent, has_chosen) = self.stooping.advance(&site, self.growth.route(), budget);
        self.tally.work += spent;
        if has_chosen { self.cut_anew_or_shift() } else { Phase::Stoop }
    }

    fn seed(&mut self, next: usize) -> Result<Phase, ArenaFull> {
        let route = self.growth.route();
        if next == 2 * route.vertex_count() {
            self.tally.sweeps += 1;
            self.lanes.current_mut().sweeps += 1;
            return Ok(Phase::Connect { next: self.roadmap.graph.connected() });
        }
        let seeding = Seeding::of(&self.shared);
        let (graph, scratch) = (&mut self.roadmap.graph, &mut self.scratch[0]);
        let (station, limb, sweeps) = (next / 2, next % 2, self.lanes.current().sweeps);
        if !self.focus.wants(station) {
            return Ok(Phase::Seed { next: next + 1 });
        }
        let known = self.growth.placements(station);
        if sweeps == 0 && !known.is_empty() {
            for placed in known.iter().filter(|placed| placed.limb == limb) {
                seeding.reuse(
                    placed,
                    route.is_used_by_primitives(station, placed),
                    graph,
                    scratch,
                )?;
            }
            seeding.turn_out(route, (station, limb), self.tally.sweeps, graph, scratch)?;
        } else {
            seeding.sweep_station(
                route,
                (station, limb),
                (sweeps, self.tally.sweeps),
                graph,
                scratch,
            )?;
        }
        Ok(Phase::Seed { next: next + 1 })
    }

    /// Makes chunks of the next motions of the walk, and seals those of motions before, each a unit
    /// of work.
    fn assemble(&mut self, next: usize, budget: u64) -> Result<Phase, ArenaFull> {
        let at_once = items_in(budget, PARALLEL_MOTIONS_MAX);
        let edges = self.walk[next..]
            .windows(2)
            .take(at_once)
            .map(|pair| ModeEdge { from: pair[0], to: pair[1] });
        let count = edges.len();
        if count == 0 {
            self.tally.work += 1;
            return Ok(Phase::Seal);
        }
        let motions: heapless::Vec<ModeMotion<'_>, PARALLEL_MOTIONS_MAX> =
            edges.filter_map(|edge| self.roadmap.mode_motion(edge)).collect();
        let sealed = self.chunks.append(
            &motions,
            items_in(budget - count as u64, usize::MAX),
            &self.shared.threads,
        )?;
        self.tally.work += (count + sealed) as u64;
        Ok(Phase::Assemble { next: next + count })
    }

    /// Seals what is left of the plan, each chunk a unit of work.
    fn seal(&mut self, budget: u64) -> Result<Phase, ArenaFull> {
        if self.chunks.unfinalized() > 1 {
            self.tally.work +=
                self.chunks.append(&[], items_in(budget, usize::MAX), &self.shared.threads)? as u64;
            return Ok(Phase::Seal);
        }
        self.tally.work += 1;
        self.digest = self.chunks.finalize_last();
        Ok(Phase::Over(Outcome::Found))
    }
}

/// Foot placement with the bounds that this robot's soles and the world's friction allow.
fn placement_config(robot: &Mechanism, world: &World, scenario: &Scenario) -> FootPlacementConfig {
    let standard = FootPlacementConfig::for_soles(
        &robot.sole_polygons,
        scenario.planner.support_area_min,
        scenario.checker.support_area_min,
    );
    let steepest = libm::atan(world.mu * libm::cos(std::f64::consts::PI / FRICTION_SIDES));
    FootPlacementConfig {
        friction_margin: standard.friction_margin.max(libm::atan(world.mu) - steepest),
        // Nearer placements first, however little they carry: the search weighs them
        // (docs/decisions/0010-foot-placement.md).
        support_area_inflation: 1.0,
        ..standard
    }
}

/// Work units between two looks at whether a step shall go on.
const WORK_PER_LOOK: u64 = 4_096;
/// Sides of the pyramid that a checker may put inside the friction cone: vertical forces must lie
/// in it too.
const FRICTION_SIDES: f64 = 8.0;
