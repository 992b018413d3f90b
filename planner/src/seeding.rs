//! Fills the graph with foot placements along the guide route, and with the transitions between
//! them [Grey 4.4.4].

use std::ops::ControlFlow;

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_about, wrap_angle};

use crate::base::random::{Random, Stream};
use crate::collision::model::FootPhase;
use crate::constraints::constraints::Constraints;
use crate::constraints::foothold::{Foothold, left_and_right, single_mode};
use crate::foot_placement::foothold_query::{FootholdQuery, YAW_SPREAD_MAX};
use crate::foot_placement::{SampleLimits, Scratch, Surfaces};
use crate::geometry::polygon::area_and_centroid;
use crate::motion::mode_graph::{ArenaFull, FootholdId, ModeGraph, TransitionId, TransitionPrior};
use crate::motion::transition_sampling::ATTEMPTS_MAX;
use crate::possibility::GuideRoute;
use crate::preparation::FootPlacement;
use crate::preparation::planning_context::Shared;
use crate::preparation::step_limits::StepLimits;
use crate::primitives::level_sole::side_of;
use crate::primitives::transition_configuration::{
    TransitionPair, are_crossed, first_valid_posture, has_valid_posture, is_reached,
    is_within_reach,
};

/// Attempts that a primitive posture counts for that does not hold on both placements of a
/// transition, where a later one does.
const POSTURE_COUNTS: u32 = 3;
/// Attempts that a transition with crossed feet counts for besides: few swings find a way to it.
const CROSSED: u32 = 3;
/// Attempts that a transition counts for besides for each of its placements that carries only
/// little of the sole: a robot that is not quite where it should be slides off there [Grey 4.1.2].
const SCANT: u32 = 8;
/// The share of a sole that is not little.
const SCANT_SHARE: f64 = 0.6;
/// How far below and above the ideal a placement may be, m.
const REACH_Z: [f64; 2] = [-0.6, 0.6];
/// Placements kept of one query where the ideal itself does not carry.
const KEPT_MAX: usize = 6;
/// Placements kept of one query of a later sweep.
const KEPT_LATER_MAX: usize = 3;
/// How the feet stand in the first sweeps: the stance width, as a factor of the marks', and how far
/// the toes are turned out, rad. A robot with bulky legs walks and turns wider, and a knee that
/// bends deep in front of a riser needs to point past it.
const STANCES: [(f64, f64); 2] = [(1.0, 0.0), (1.5, 0.5)];
/// The sweep in which the toes are turned out.
const TURNED_OUT: usize = 1;
/// How much of a leg's reach the way must rise or fall between two stations to count as steep.
const STEEP_MIN: f64 = 0.15;
/// How far it may turn there to count as straight, rad: on a bend the feet are turned against each
/// other anyway.
const STRAIGHT_TURN_MAX: f64 = 0.15;
/// How far the ideals of later sweeps stray, m and rad.
const LATER_SPREAD: (f64, f64) = (0.2, 0.4);
/// Neighbours that a placement is connected to at the most.
const NEIGHBOURS_MAX: usize = 128;
/// Of all neighbours in one cell of this width (m) about a placement only the nearest is connected,
/// so that a crowd at hand does not crowd out the few across a gap.
const NEIGHBOUR_CELL: f64 = 0.1;

/// The effort of a first sweep: what the geometry says, and a little sampling where it says
/// nothing.
const FIRST_LIMITS: SampleLimits =
    SampleLimits { geometric_max: 64, perturbed_max: 0, sampled_max: 0 };
/// The effort of a query that found nothing at first, and of later sweeps.
const LATER_LIMITS: SampleLimits =
    SampleLimits { geometric_max: 48, perturbed_max: 8, sampled_max: 60 };

/// Variations of one transition that are drawn at the most.
pub const VARIATIONS_MAX: usize = 64;

/// A placement that another may form a step with.
#[derive(Debug, Clone, Copy)]
struct Neighbour {
    cell: glam::IVec3,
    distance: f64,
    id: FootholdId,
}

/// The placements that another is to be connected with.
pub type Neighbours = heapless::Vec<FootholdId, NEIGHBOURS_MAX>;

/// What seeding reads.
#[derive(Debug, Clone, Copy)]
pub struct Seeding<'a> {
    /// The robot and the world's geometry.
    pub constraints: &'a Constraints,
    /// Where soles can rest.
    pub surfaces: &'a Surfaces,
    /// The steps that the robot can make.
    pub steps: &'a StepLimits,
    /// The seed of all streams.
    pub seed: u64,
}

impl<'a> Seeding<'a> {
    /// Of what all stages read.
    pub fn of(shared: &'a Shared) -> Self {
        Self {
            constraints: &shared.constraints,
            surfaces: &shared.surfaces,
            steps: shared.preparation.step_limits(),
            seed: shared.seed,
        }
    }

    /// Adds a placement that stage P has found [Grey 4.4.4], unless there is one that is all but
    /// the same; `exactly` this one where primitives stand on it.
    ///
    /// # Errors
    /// The placement arena is full.
    pub fn reuse(
        &self,
        placed: &FootPlacement,
        exactly: bool,
        graph: &mut ModeGraph,
        scratch: &mut Scratch,
    ) -> Result<(), ArenaFull> {
        let sole_polygon = &self.constraints.robot.sole_polygons[placed.limb];
        let Ok(support) = self.surfaces.support(scratch, sole_polygon, &placed.world_from_sole)
        else {
            return Ok(());
        };
        let foothold = Foothold::of(
            &self.constraints.robot,
            placed.limb,
            placed.world_from_sole,
            support.polygon,
        );
        let known = if exactly {
            graph.identical(foothold.limb, &foothold.world_from_sole)
        } else {
            graph.find_equivalent(&foothold)
        };
        if known.is_none() {
            graph.add_foothold(foothold)?;
        }
        Ok(())
    }

    /// Adds the placements of one foot at one station of a route, in the sweep `sweep` of that
    /// route; `name` tells apart the sweeps of all routes.
    ///
    /// # Errors
    /// The placement arena is full.
    pub fn sweep_station(
        &self,
        route: &GuideRoute,
        place: (usize, usize),
        (sweep, name): (usize, u64),
        graph: &mut ModeGraph,
        scratch: &mut Scratch,
    ) -> Result<(), ArenaFull> {
        let (station, limb) = place;
        let object = (station * 2 + limb) as u64;
        let Some(&(widening, toes_out)) = STANCES.get(sweep) else {
            return self.sample_about(
                &route.world_from_ideal_sole(station, limb, 1.0),
                limb,
                (object, name),
                graph,
                scratch,
            );
        };
        let straight = route.world_from_ideal_sole(station, limb, widening);
        let turn =
            rotation_about(DVec3::Z, side_of(limb) * toes_out.min(0.5 * self.steps.turn_max()));
        let ideal = Pose::from_parts(straight.translation, straight.rotation * turn);
        let before = graph.footholds().len();
        self.query(&ideal, limb, (object, name), FIRST_LIMITS, KEPT_MAX, graph, scratch)?;
        if graph.footholds().len() == before {
            self.query(&ideal, limb, (object, name), LATER_LIMITS, KEPT_MAX, graph, scratch)?;
        }
        Ok(())
    }

    /// Adds the placements of one foot at a station with its toes turned out where the way leads
    /// straight up or down, and no primitive posture holds on a step of this foot: the knee would
    /// meet the next riser [Grey 4.4.2].
    ///
    /// # Errors
    /// The placement arena is full.
    pub fn turn_out(
        &self,
        route: &GuideRoute,
        (station, limb): (usize, usize),
        name: u64,
        graph: &mut ModeGraph,
        scratch: &mut Scratch,
    ) -> Result<(), ArenaFull> {
        let last = (station + 1).min(route.vertex_count() - 1);
        let is_hard = |from: usize| {
            self.is_steep(route, from)
                && !self.holds_step(route, from, if from == station { 1 - limb } else { limb })
        };
        if (station.saturating_sub(1)..last).any(is_hard) {
            return self.sweep_station(route, (station, limb), (TURNED_OUT, name), graph, scratch);
        }
        Ok(())
    }

    /// Whether a route leads straight up or down from a station to the next.
    fn is_steep(&self, route: &GuideRoute, from: usize) -> bool {
        let [from, to] = [from, from + 1].map(|index| route.pose(index));
        (to.position.z - from.position.z).abs() > STEEP_MIN * self.constraints.robot.shorter_reach()
            && wrap_angle(to.yaw - from.yaw).abs() < STRAIGHT_TURN_MAX
    }

    /// Whether primitive postures hold on the step of a foot from what a station stands on to what
    /// the next one does.
    fn holds_step(&self, route: &GuideRoute, from: usize, limb: usize) -> bool {
        let (Some(from), Some(to)) = (route.pair(from), route.pair(from + 1)) else { return true };
        let [stance, other] = [&from[1 - limb], &to[limb]].map(|placed| {
            Foothold::whole(&self.constraints.robot, placed.limb, placed.world_from_sole)
        });
        let holds = |stance: &Foothold, other: &Foothold| {
            first_valid_posture(
                self.constraints,
                &single_mode(stance),
                TransitionPair { stance, other },
            )
            .is_some()
        };
        holds(&stance, &other) && holds(&other, &stance)
    }

    /// Adds placements of one foot at random near a pose.
    ///
    /// # Errors
    /// The placement arena is full.
    pub fn sample_about(
        &self,
        pose: &Pose,
        limb: usize,
        name: (u64, u64),
        graph: &mut ModeGraph,
        scratch: &mut Scratch,
    ) -> Result<(), ArenaFull> {
        let mut random = Random::new(self.seed, Stream::FootPlacement, name.0 | 1 << 40, name.1);
        let (shift, turn) = (LATER_SPREAD.0, LATER_SPREAD.1.min(self.steps.turn_max()));
        let offset = DVec3::new(random.uniform(-shift, shift), random.uniform(-shift, shift), 0.0);
        let rotation = pose.rotation * rotation_about(DVec3::Z, random.uniform(-turn, turn));
        let ideal = Pose::from_parts(pose.translation + offset, rotation);
        self.query(&ideal, limb, name, LATER_LIMITS, KEPT_LATER_MAX, graph, scratch)
    }

    /// Both placements of a transition drawn anew near where they are, each in its plane, if the
    /// robot reaches one from the other and some primitive posture holds there.
    pub fn variation(
        &self,
        id: TransitionId,
        name: (u64, u64),
        graph: &ModeGraph,
        scratch: &mut Scratch,
    ) -> Option<[Foothold; 2]> {
        let mut random = Random::new(
            self.seed,
            Stream::FootPlacement,
            u64::from(id) << 8 | name.0 | 1 << 42,
            name.1,
        );
        let (stance, other) = graph.pair(id);
        let [stance, other] =
            [stance, other].map(|foothold| self.varied(foothold, &mut random, scratch));
        let (stance, other) = stance.zip(other)?;
        let pair = TransitionPair { stance: &stance, other: &other };
        let mode = single_mode(&stance);
        let is_possible = is_reached(self.constraints, &mode, pair)
            && has_valid_posture(self.constraints, &mode, pair);
        is_possible.then_some([stance, other])
    }

    /// A placement moved and turned at random in its plane, if it is carried and free there.
    fn varied(
        &self,
        foothold: &Foothold,
        random: &mut Random,
        scratch: &mut Scratch,
    ) -> Option<Foothold> {
        let (shift, turn) = (LATER_SPREAD.0, LATER_SPREAD.1.min(self.steps.turn_max()));
        let moved = DVec3::new(random.uniform(-shift, shift), random.uniform(-shift, shift), 0.0);
        let turned = rotation_about(DVec3::Z, random.uniform(-turn, turn));
        let world_from_sole = foothold.world_from_sole * Pose::from_parts(moved, turned);
        let support = self
            .surfaces
            .support(
                scratch,
                &self.constraints.robot.sole_polygons[foothold.limb],
                &world_from_sole,
            )
            .ok()?;
        let is_free = self
            .constraints
            .collision
            .foot_hit(foothold.limb, &world_from_sole, FootPhase::LiftOff)
            .is_none();
        is_free.then(|| {
            Foothold::of(&self.constraints.robot, foothold.limb, world_from_sole, support.polygon)
        })
    }

    #[allow(
        clippy::too_many_arguments,
        reason = "one call site's arguments in three layers; a struct would only rename them"
    )]
    fn query(
        &self,
        ideal: &Pose,
        limb: usize,
        name: (u64, u64),
        limits: SampleLimits,
        kept_max: usize,
        graph: &mut ModeGraph,
        scratch: &mut Scratch,
    ) -> Result<(), ArenaFull> {
        let query = FootholdQuery {
            limb,
            ideal: *ideal,
            reach_z: REACH_Z,
            yaw_spread: YAW_SPREAD_MAX.min(self.steps.turn_max()),
            seed: self.seed,
            name,
            limits,
            kept_max,
        };
        let mut ending = Ok(());
        query.run((self.constraints, self.surfaces), scratch, &mut |placement| {
            let foothold = Foothold::of(
                &self.constraints.robot,
                limb,
                placement.world_from_sole,
                placement.support.polygon,
            );
            if graph.find_equivalent(&foothold).is_some() {
                return ControlFlow::Continue(false);
            }
            ending = graph.add_foothold(foothold).map(|_| ());
            if ending.is_ok() { ControlFlow::Continue(true) } else { ControlFlow::Break(()) }
        });
        ending
    }

    /// The earlier placements of the other foot that a placement is to be connected with: no
    /// farther than `reach` (m), where it is due and the feet do not meet.
    pub fn neighbours(
        &self,
        foothold: FootholdId,
        reach: f64,
        is_due: impl Fn(&Foothold, &Foothold) -> bool,
        graph: &ModeGraph,
    ) -> Neighbours {
        let mut neighbours: heapless::Vec<Neighbour, NEIGHBOURS_MAX> = heapless::Vec::new();
        let here = &graph.footholds()[foothold as usize];
        let place = here.world_from_sole.translation;
        for (id, other) in graph.near(1 - here.limb, place).take_while(|&(id, _)| id < foothold) {
            let distance = here.distance(other);
            if distance > reach || !is_due(here, other) {
                continue;
            }
            let offset = other.world_from_sole.translation - place;
            let cell = (offset / NEIGHBOUR_CELL).round().as_ivec3();
            let neighbour = Neighbour { cell, distance, id };
            match neighbours.iter_mut().find(|known| known.cell == cell) {
                Some(known) if known.distance <= distance => {}
                Some(known) => *known = neighbour,
                None => drop(neighbours.push(neighbour)),
            }
        }
        neighbours
            .iter()
            .map(|neighbour| neighbour.id)
            .filter(|&id| !self.feet_meet(graph, foothold, id))
            .collect()
    }

    /// Whether the two feet would intersect on these placements: such a transition can not exist
    /// [Grey 4.4.2].
    fn feet_meet(&self, graph: &ModeGraph, a: FootholdId, b: FootholdId) -> bool {
        let [left, right] =
            left_and_right(&graph.footholds()[a as usize], &graph.footholds()[b as usize]);
        self.constraints.collision.feet_hit([&left.world_from_sole, &right.world_from_sole])
    }
}

/// What a transition begins with: the more primitive postures do not hold on both its placements,
/// the lower its priority [Grey 4.4.2, figure 4.14]. Scant support counts against it too, unless
/// `may_be_scant`.
pub fn judge(
    constraints: &Constraints,
    id: TransitionId,
    graph: &ModeGraph,
    may_be_scant: bool,
) -> TransitionPrior {
    let (stance, other) = graph.pair(id);
    let pair = TransitionPair { stance, other };
    let (attempts, extra_attempts) =
        match first_valid_posture(constraints, &single_mode(stance), pair) {
            Some(failed) => (POSTURE_COUNTS * failed as u32, 0),
            None => (ATTEMPTS_MAX, TransitionPrior::UNLIKELY),
        };
    let crossed = if are_crossed(pair) { CROSSED } else { 0 };
    let scant = [stance, other]
        .into_iter()
        .filter(|foothold| !may_be_scant && is_scant(constraints, foothold))
        .count() as u32;
    TransitionPrior { attempts, extra_attempts: extra_attempts + crossed + SCANT * scant }
}

fn is_scant(constraints: &Constraints, foothold: &Foothold) -> bool {
    let [carried, all] = [&foothold.support[..], &constraints.robot.sole_polygons[foothold.limb]]
        .map(|outline| area_and_centroid(outline).0);
    carried < SCANT_SHARE * all
}

/// Whether the robot, standing on the first placement, reaches the second one, and then stands on
/// that with the first still touched, by inverse kinematics [Grey 4.4.2].
pub fn is_step(constraints: &Constraints, step: [&FootPlacement; 2]) -> bool {
    let [from, to] =
        step.map(|placed| Foothold::whole(&constraints.robot, placed.limb, placed.world_from_sole));
    is_within_reach(constraints, &from, &to) && is_within_reach(constraints, &to, &from)
}
