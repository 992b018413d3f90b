//! Samples footholds along the guide route, and near steps that are not found
//! [Grey 4.2, 4.4.4].

use std::ops::ControlFlow;

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_about, wrap_angle};

use crate::base::capacity::ArenaFull;
use crate::base::random::{Random, Stream};
use crate::collision::model::FootPhase;
use crate::constraints::constraints::Constraints;
use crate::constraints::foothold::{FootPlacement, Foothold, single_mode};
use crate::foot_placement::YAW_SPREAD_MAX;
use crate::foot_placement::foothold_query::FootholdQuery;
use crate::foot_placement::{SampleLimits, Scratch, SoleShape, Surfaces};
use crate::motion::ids::TransitionId;
use crate::motion::mode_graph::ModeGraph;
use crate::possibility::{GuideRoute, IdealWidth};
use crate::preparation::planning_context::PlanningContext;
use crate::preparation::step_limits::StepLimits;
use crate::primitives::level_sole::side_of;
use crate::primitives::transition_configuration::{has_valid_posture, is_reached, is_valid_step};
use crate::primitives::transition_pair::TransitionPair;

/// Lowest and highest foothold relative to its ideal, m.
const GROUND_Z: [f64; 2] = [-0.6, 0.6];
/// Footholds kept of one query in a first sweep, where the ideal itself has no support.
const SWEEP_FOOTHOLDS_MAX: usize = 6;
/// Footholds kept of one query with a random ideal.
const RANDOM_FOOTHOLDS_MAX: usize = 3;
/// Stances of the first sweeps: stance width, and toe-out angle, rad. Narrow feet that turn inward
/// collide, and wide legs need a wider stance. On steep stairs, turned-out feet keep the knee clear
/// of the next riser.
const STANCES: [(IdealWidth, f64); 3] =
    [(IdealWidth::Walking, 0.0), (IdealWidth::OfEnds(1.0), 0.0), (IdealWidth::OfEnds(1.5), 0.5)];
/// Index of the stance with toe-out.
const TOE_OUT: usize = 2;
/// Rise or fall between two vertices that counts as steep, relative to the reach of a leg.
const STEEP_MIN: f64 = 0.15;
/// Greatest turn (rad) between two vertices that counts as straight: on a bend the feet are turned
/// against each other anyway.
const STRAIGHT_TURN_MAX: f64 = 0.15;
/// Greatest offset (m) and turn (rad) of a random ideal.
const RANDOM_SPREAD: (f64, f64) = (0.2, 0.4);

/// Limits of a query in a first sweep: candidates of the geometry.
const FIRST_LIMITS: SampleLimits =
    SampleLimits { geometric_max: 64, perturbed_max: 0, sampled_max: 0 };
/// Limits of a query where the first found nothing, and of queries with random ideals.
const LATER_LIMITS: SampleLimits =
    SampleLimits { geometric_max: 48, perturbed_max: 8, sampled_max: 60 };

/// Most perturbations of one transition.
pub const PERTURBATIONS_MAX: usize = 64;

/// Samples footholds on the surfaces of the world.
#[derive(Debug, Clone, Copy)]
pub struct FootholdSampler<'a> {
    /// The robot and the world's geometry.
    pub constraints: &'a Constraints,
    /// The surfaces on which soles can rest.
    pub surfaces: &'a Surfaces,
    /// The steps that the robot can make.
    pub steps: &'a StepLimits,
    /// The seed of all random streams.
    pub seed: u64,
}

/// A query for footholds near an ideal sole pose.
#[derive(Debug, Clone, Copy)]
struct SampleQuery {
    ideal: Pose,
    limb: usize,
    /// Object and index in the random stream.
    name: (u64, u64),
    limits: SampleLimits,
    kept_max: usize,
}

impl<'a> FootholdSampler<'a> {
    /// A sampler for the robot, world and seed of a search.
    pub fn new(context: &'a PlanningContext) -> Self {
        Self {
            constraints: &context.constraints,
            surfaces: &context.surfaces,
            steps: context.preparation.step_limits(),
            seed: context.seed,
        }
    }

    /// Adds a placement that stage P found [Grey 4.4.4], unless the graph has nearly the same.
    /// With `is_exact` only an identical one counts: primitives need exactly this pose.
    ///
    /// # Errors
    /// The foothold arena is full.
    pub fn reuse(
        &self,
        placed: &FootPlacement,
        is_exact: bool,
        graph: &mut ModeGraph,
        scratch: &mut Scratch,
    ) -> Result<(), ArenaFull> {
        let robot = &self.constraints.robot;
        let sole = SoleShape::of(&robot.soles[placed.limb]);
        let Ok(support) = self.surfaces.support_of_sole(scratch, sole, &placed.world_from_sole)
        else {
            return Ok(());
        };
        let foothold = support.foothold(robot, placed.limb, placed.world_from_sole);
        let known = if is_exact {
            graph.identical(foothold.limb, &foothold.world_from_sole)
        } else {
            graph.find_equivalent(&foothold)
        };
        if known.is_none() {
            graph.add_foothold(foothold)?;
        }
        Ok(())
    }

    /// Adds footholds of one foot at a vertex of a route: `place` is the vertex and the foot. In
    /// the first sweeps of a route the ideals are those of `STANCES`, then random. `name` is
    /// unique among the sweeps of all routes.
    ///
    /// # Errors
    /// The foothold arena is full.
    pub fn sweep_vertex(
        &self,
        route: &GuideRoute,
        place: (usize, usize),
        (sweep, name): (usize, u64),
        graph: &mut ModeGraph,
        scratch: &mut Scratch,
    ) -> Result<(), ArenaFull> {
        let (vertex, limb) = place;
        let name = ((vertex * 2 + limb) as u64, name);
        let Some(&(width, toe_out)) = STANCES.get(sweep) else {
            let ideal = route.world_from_ideal_sole(vertex, limb, IdealWidth::OfEnds(1.0));
            return self.sample_near(&ideal, limb, name, graph, scratch);
        };
        let straight = route.world_from_ideal_sole(vertex, limb, width);
        let toe_out = toe_out.min(0.5 * self.steps.turn_max());
        let turn = rotation_about(DVec3::Z, side_of(limb) * toe_out);
        let ideal = Pose::from_parts(straight.translation, straight.rotation * turn);
        let before = graph.footholds().len();
        let query =
            SampleQuery { ideal, limb, name, limits: FIRST_LIMITS, kept_max: SWEEP_FOOTHOLDS_MAX };
        self.add_footholds(&query, graph, scratch)?;
        if graph.footholds().len() == before {
            let query = SampleQuery { limits: LATER_LIMITS, ..query };
            self.add_footholds(&query, graph, scratch)?;
        }
        Ok(())
    }

    /// Adds footholds of one foot with toe-out where the route leads straight up or down, and no
    /// primitive posture holds on a step of this foot: the knee would collide with the next riser
    /// [Grey 4.4.2].
    ///
    /// # Errors
    /// The foothold arena is full.
    pub fn toe_out(
        &self,
        route: &GuideRoute,
        (vertex, limb): (usize, usize),
        name: u64,
        graph: &mut ModeGraph,
        scratch: &mut Scratch,
    ) -> Result<(), ArenaFull> {
        let last = (vertex + 1).min(route.vertex_count() - 1);
        let is_hard = |from: usize| {
            self.is_steep(route, from)
                && !self.holds_step(route, from, if from == vertex { 1 - limb } else { limb })
        };
        if (vertex.saturating_sub(1)..last).any(is_hard) {
            return self.sweep_vertex(route, (vertex, limb), (TOE_OUT, name), graph, scratch);
        }
        Ok(())
    }

    /// Whether a route leads straight up or down from a vertex to the next.
    fn is_steep(&self, route: &GuideRoute, from: usize) -> bool {
        let [from, to] = [from, from + 1].map(|index| route.pose(index));
        (to.position.z - from.position.z).abs() > STEEP_MIN * self.constraints.robot.shorter_reach()
            && wrap_angle(to.yaw - from.yaw).abs() < STRAIGHT_TURN_MAX
    }

    /// Whether primitive postures hold on the step of a foot from the placements at a vertex to
    /// those at the next.
    fn holds_step(&self, route: &GuideRoute, from: usize, limb: usize) -> bool {
        let (Some(from), Some(to)) = (route.pair(from), route.pair(from + 1)) else { return true };
        let [stance, other] = [&from[1 - limb], &to[limb]].map(|placed| {
            Foothold::whole(&self.constraints.robot, placed.limb, placed.world_from_sole)
        });
        is_valid_step(self.constraints, [&stance, &other])
    }

    /// Adds footholds of one foot near a random pose near `pose`.
    ///
    /// # Errors
    /// The foothold arena is full.
    pub fn sample_near(
        &self,
        pose: &Pose,
        limb: usize,
        name: (u64, u64),
        graph: &mut ModeGraph,
        scratch: &mut Scratch,
    ) -> Result<(), ArenaFull> {
        let mut random = Random::new(self.seed, Stream::FootPlacement, name.0 | 1 << 40, name.1);
        let (offset, turn) = self.random_offset(&mut random);
        let ideal = Pose::from_parts(pose.translation + offset, pose.rotation * turn);
        let query =
            SampleQuery { ideal, limb, name, limits: LATER_LIMITS, kept_max: RANDOM_FOOTHOLDS_MAX };
        self.add_footholds(&query, graph, scratch)
    }

    /// Adds a foothold of one foot at a pose, or the nearest one where the sole has no support
    /// there. It is added even if there is one like it: a walk may need one of two that are nearer
    /// to each other than others may be.
    ///
    /// # Errors
    /// The foothold arena is full.
    pub fn add_at(
        &self,
        pose: &Pose,
        limb: usize,
        name: (u64, u64),
        graph: &mut ModeGraph,
        scratch: &mut Scratch,
    ) -> Result<(), ArenaFull> {
        self.add_within(pose, limb, name, |_| true, (graph, scratch))
    }

    /// The same, of the footholds whose positions (m) `may_use` allows.
    ///
    /// # Errors
    /// The foothold arena is full.
    pub fn add_within(
        &self,
        pose: &Pose,
        limb: usize,
        name: (u64, u64),
        may_use: impl Fn(DVec3) -> bool,
        (graph, scratch): (&mut ModeGraph, &mut Scratch),
    ) -> Result<(), ArenaFull> {
        let query = FootholdQuery {
            limb,
            ideal: *pose,
            reach_z: GROUND_Z,
            yaw_spread: 0.0,
            seed: self.seed,
            name,
            limits: LATER_LIMITS,
            kept_max: 1,
        };
        let robot = &self.constraints.robot;
        let mut result = Ok(());
        query.run((self.constraints, self.surfaces), scratch, &mut |placement| {
            if !may_use(placement.world_from_sole.translation) {
                return ControlFlow::Continue(false);
            }
            let foothold = placement.support.foothold(robot, limb, placement.world_from_sole);
            result = graph.add_foothold(foothold).map(|_| ());
            ControlFlow::Break(())
        });
        result
    }

    /// Both footholds of a transition, each at a random pose near its own in the same plane, if
    /// the robot reaches one from the other and some primitive posture holds there.
    pub fn perturbation(
        &self,
        id: TransitionId,
        name: (u64, u64),
        graph: &ModeGraph,
        scratch: &mut Scratch,
    ) -> Option<[Foothold; 2]> {
        let object = u64::from(id) << 8 | name.0 | 1 << 42;
        let mut random = Random::new(self.seed, Stream::FootPlacement, object, name.1);
        let (stance, other) = graph.pair(id);
        let [stance, other] =
            [stance, other].map(|foothold| self.perturbed(foothold, &mut random, scratch));
        let (stance, other) = stance.zip(other)?;
        let pair = TransitionPair { stance: &stance, other: &other };
        let mode = single_mode(&stance);
        let is_possible = is_reached(self.constraints, &mode, pair)
            && has_valid_posture(self.constraints, &mode, pair);
        is_possible.then_some([stance, other])
    }

    /// A foothold set down at a random pose near `foothold` in the same plane, if it has support
    /// and is free there.
    fn perturbed(
        &self,
        foothold: &Foothold,
        random: &mut Random,
        scratch: &mut Scratch,
    ) -> Option<Foothold> {
        let Constraints { robot, collision, .. } = self.constraints;
        let (offset, turn) = self.random_offset(random);
        let limb = foothold.limb;
        let world_from_sole = foothold.world_from_sole * Pose::from_parts(offset, turn);
        let sole = SoleShape::of(&robot.soles[limb]);
        let set_down = self.surfaces.support_set_down(scratch, sole, &world_from_sole);
        let (world_from_sole, support) = set_down.ok()?;
        let is_free = collision.foot_hit(limb, &world_from_sole, FootPhase::LiftOff).is_none();
        is_free.then(|| support.foothold(robot, limb, world_from_sole))
    }

    /// A horizontal offset (m) and a turn about the vertical within [`RANDOM_SPREAD`].
    fn random_offset(&self, random: &mut Random) -> (DVec3, glam::DQuat) {
        let (shift, turn) = (RANDOM_SPREAD.0, RANDOM_SPREAD.1.min(self.steps.turn_max()));
        let offset = DVec3::new(random.uniform(-shift, shift), random.uniform(-shift, shift), 0.0);
        (offset, rotation_about(DVec3::Z, random.uniform(-turn, turn)))
    }

    /// Adds the footholds that a query finds and the graph does not have.
    fn add_footholds(
        &self,
        query: &SampleQuery,
        graph: &mut ModeGraph,
        scratch: &mut Scratch,
    ) -> Result<(), ArenaFull> {
        let SampleQuery { ideal, limb, name, limits, kept_max } = *query;
        let yaw_spread = YAW_SPREAD_MAX.min(self.steps.turn_max());
        let (reach_z, seed) = (GROUND_Z, self.seed);
        let query =
            FootholdQuery { limb, ideal, reach_z, yaw_spread, seed, name, limits, kept_max };
        let robot = &self.constraints.robot;
        let mut result = Ok(());
        query.run((self.constraints, self.surfaces), scratch, &mut |placement| {
            let foothold = placement.support.foothold(robot, limb, placement.world_from_sole);
            if graph.find_equivalent(&foothold).is_some() {
                return ControlFlow::Continue(false);
            }
            result = graph.add_foothold(foothold).map(|_| ());
            if result.is_ok() { ControlFlow::Continue(true) } else { ControlFlow::Break(()) }
        });
        result
    }
}
