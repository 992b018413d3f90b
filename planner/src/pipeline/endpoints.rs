//! The robot at the start and at the goal: on both feet on a given stance, or in the state in which
//! it is [Grey 4.4.1].

use std::f64::consts::TAU;
use std::ops::ControlFlow;

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_about, wrap_angle, yaw_of};
use surefoot_shared_types::config::planner::CONTACT_GAP_MAX;
use surefoot_shared_types::config::scenario::{GoalTolerance, StancePose};
use surefoot_shared_types::message::{Contact, RestState, SupportMode};
use surefoot_shared_types::world::world::World;

use crate::collision::model::{FootPhase, Hit};
use crate::constraints::constraints::Constraints;
use crate::constraints::foothold::{FootPair, Foothold, double_mode, single_mode};
use crate::constraints::mode::{Mode, StartBalance};
use crate::constraints::mode_state::ModeState;
use crate::constraints::rejection::Rejection;
use crate::foot_placement::YAW_SPREAD_MAX;
use crate::foot_placement::foothold_query::FootholdQuery;
use crate::foot_placement::resting_sole::{SoleToRest, rest_pose};
use crate::foot_placement::sole_support::{NoSupport, SurfacesError};
use crate::foot_placement::{FootPlacementConfig, SampleLimits, Scratch, SoleShape, Surfaces};
use crate::pipeline::outcome::EndpointError;
use crate::robot::configuration::Configuration;
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::Mechanism;
use crate::robot::posture_ik::{Posture, solve_posture};

/// Leg extensions that are tried, relative to that of the standing posture.
const LEG_EXTENSIONS: [f64; 5] = [1.0, 0.97, 0.94, 0.9, 0.85];

/// Lowest and highest ground relative to a wanted sole pose, m.
const GROUND_Z: [f64; 2] = [-0.1, 0.1];
/// Greatest horizontal distance of a foothold from a wanted sole pose, m.
const OFFSET_MAX: f64 = 0.03;
/// Share of the tolerances of a goal that is used; the rest is left to rounding.
pub(crate) const TOLERANCE_SHARE: f64 = 0.98;
/// Most distance between a wanted sole and where it comes to rest that roughness accounts for, m.
const ROUGHNESS_MAX: f64 = 8e-3;
/// Limits of the query for ground near a wanted sole pose.
const GROUND_LIMITS: SampleLimits =
    SampleLimits { geometric_max: 64, perturbed_max: 0, sampled_max: 0 };

/// The robot at the start or at the goal.
#[derive(Debug, Clone)]
pub struct Endpoint {
    /// The footholds, left and right.
    pub footholds: [Foothold; 2],
    /// The configuration over both footholds.
    pub state: ModeState,
    /// The feet that carry the robot.
    pub support: SupportMode,
}

/// How far a foothold may be from a wanted sole pose.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Nearness {
    /// Greatest horizontal distance, m.
    offset: f64,
    /// Greatest turn, rad.
    turn: f64,
}

impl Nearness {
    /// That of a sole that may stand wherever there is ground.
    pub const USUAL: Self = Self { offset: OFFSET_MAX, turn: YAW_SPREAD_MAX };

    /// That of a sole at a goal.
    pub fn of_goal(tolerance: &GoalTolerance) -> Self {
        Self {
            offset: OFFSET_MAX.min(TOLERANCE_SHARE * tolerance.position),
            turn: YAW_SPREAD_MAX.min(TOLERANCE_SHARE * tolerance.yaw),
        }
    }

    fn contains(&self, wanted: &Pose, sole: &Pose) -> bool {
        let offset = (sole.translation - wanted.translation).truncate().length();
        let turn = wrap_angle(yaw_of(sole.rotation) - yaw_of(wanted.rotation)).abs();
        offset <= self.offset && turn <= self.turn
    }
}

/// Distances and directions of the offsets at which a sole is tried, and a whole stance.
const SOLE_OFFSETS: [usize; 2] = [6, 12];
const STANCE_OFFSETS: [usize; 2] = [3, 8];

/// Puts the robot on a stance: exactly there where the ground is level, else on the nearest ground
/// that supports each sole, at most 3 cm aside.
///
/// # Errors
/// A sole has no support, or no posture over both soles meets the constraints.
pub fn stand_on(
    constraints: &Constraints,
    surfaces: &Surfaces,
    scratch: &mut Scratch,
    stance: &StancePose,
) -> Result<Endpoint, EndpointError> {
    stand_within(constraints, surfaces, scratch, (stance, Nearness::USUAL))
}

/// Does the same as near as asked: first on the given poses, then with each sole that does not fit
/// moved aside alone, then with both soles moved by the same offset.
///
/// # Errors
/// Those on the given poses.
pub(crate) fn stand_within(
    constraints: &Constraints,
    surfaces: &Surfaces,
    scratch: &mut Scratch,
    (stance, nearness): (&StancePose, Nearness),
) -> Result<Endpoint, EndpointError> {
    let soles = stance.world_from_soles();
    let mut near =
        |limb: usize| foothold_near(constraints, surfaces, scratch, limb, (&soles[limb], nearness));
    let exact = [near(0), near(1)];
    let stand_over = |footholds: [Foothold; 2]| -> Result<Endpoint, EndpointError> {
        let state = stand(constraints, &footholds, stance.yaw)?;
        Ok(Endpoint { footholds, state, support: SupportMode::Double })
    };
    let endpoint = match exact.clone() {
        [Ok(left), Ok(right)] => stand_over([left, right]),
        [Err(error), _] | [_, Err(error)] => Err(error),
    };
    let Err(error) = endpoint else { return endpoint };
    if !may_fit_aside(&error) {
        return Err(error);
    }
    let mut moved = |limb: usize, (offset, at): (DVec3, FootholdAt)| {
        let pose = Pose::from_parts(soles[limb].translation + offset, soles[limb].rotation);
        let foothold = at(constraints, surfaces, scratch, limb, &pose).ok()?;
        // The foot must also be able to leave.
        let pose = &foothold.world_from_sole;
        let is_free = constraints.collision.foot_hit(limb, pose, FootPhase::LiftOff).is_none();
        is_free.then_some(foothold)
    };
    let alone = [0, 1].map(|limb| {
        let mut aside = || offsets(SOLE_OFFSETS, nearness.offset).find_map(|by| moved(limb, by));
        exact[limb].clone().ok().or_else(&mut aside)
    });
    if let [Some(left), Some(right)] = alone
        && let Ok(endpoint) = stand_over([left, right])
    {
        return Ok(endpoint);
    }
    let mut together = offsets(STANCE_OFFSETS, nearness.offset)
        .filter_map(|by| stand_over([moved(0, by)?, moved(1, by)?]).ok());
    together.next().ok_or(error)
}

/// Whether a place a little aside may serve where one does not.
fn may_fit_aside(error: &EndpointError) -> bool {
    match error {
        EndpointError::Unsupported { reason, .. } => {
            !matches!(reason, NoSupport::InvalidSole | NoSupport::TooSteep | NoSupport::FacesDown)
        }
        EndpointError::FootCollides { .. } => true,
        EndpointError::NoPosture { rejection, .. } => *rejection == Rejection::Collision,
        EndpointError::UnknownStance => false,
    }
}

/// A way to find the foothold of a limb at a sole pose.
type FootholdAt =
    fn(&Constraints, &Surfaces, &mut Scratch, usize, &Pose) -> Result<Foothold, EndpointError>;

/// Horizontal offsets up to `offset_max` (m), the smallest first: for a sole exactly there, then
/// for one that is set down there.
fn offsets(
    [distances, directions]: [usize; 2],
    offset_max: f64,
) -> impl Iterator<Item = (DVec3, FootholdAt)> {
    let around = move |at: FootholdAt| {
        (1..=distances).flat_map(move |step| {
            let distance = offset_max * step as f64 / distances as f64;
            (0..directions).map(move |direction| {
                let (sin, cos) = libm::sincos(TAU * direction as f64 / directions as f64);
                (DVec3::new(distance * cos, distance * sin, 0.0), at)
            })
        })
    };
    [foothold_at as FootholdAt, foothold_set_down].into_iter().flat_map(around)
}

/// Smallest support area under a foot that stands already, m2.
const STANCE_AREA_MIN: f64 = 1e-4;
/// Smallest width of a support polygon under a foot that stands already, m.
const STANCE_WIDTH_MIN: f64 = 2e-3;

/// The surfaces of a world, with the limits for feet that stand already.
pub(crate) struct StanceSurfaces {
    surfaces: Surfaces,
    scratch: Scratch,
}

impl StanceSurfaces {
    /// Compiles a world. Allocates.
    ///
    /// # Errors
    /// A shape cannot be compiled into surfaces.
    pub fn new(world: &World) -> Result<Self, SurfacesError> {
        let config = FootPlacementConfig {
            support_area_min: STANCE_AREA_MIN,
            centroid_edge_distance_min: 0.0,
            contact_width_min: STANCE_WIDTH_MIN,
            ground_height_max: CONTACT_GAP_MAX,
            ..FootPlacementConfig::default()
        };
        Ok(Self { scratch: Scratch::new(&config), surfaces: Surfaces::new(world, config)? })
    }

    /// A rest state with the support polygons that the world gives its standing feet. A foot
    /// without support gets an empty polygon, which [`stand_in`] refuses.
    pub fn with_support(&mut self, robot: &Mechanism, rest_state: &RestState) -> RestState {
        let mut rest_state = *rest_state;
        let mode = SupportMode::from_wire(rest_state.mode);
        for contact in &mut rest_state.contacts[..rest_state.contacts_len as usize] {
            let limb = contact.limb as usize;
            if mode.is_some_and(|mode| mode.carries(limb)) {
                let support = self.surfaces.support_of_sole(
                    &mut self.scratch,
                    SoleShape::of(&robot.soles[limb]),
                    &contact.world_from_sole(),
                );
                set_polygon(contact, support.as_ref().map_or(&[], |support| &support.polygon));
            }
        }
        rest_state
    }
}

fn set_polygon(contact: &mut Contact, polygon: &[DVec2]) {
    contact.polygon = Default::default();
    contact.polygon.iter_mut().zip(polygon).for_each(|(slot, vertex)| *slot = vertex.to_array());
    contact.polygon_len = polygon.len() as u32;
}

/// The robot in a rest state, on both feet or on one. A standing foot keeps the support polygon of
/// the state; [`StanceSurfaces::with_support`] updates it where the world was corrected. A lifted
/// foot has the foothold where it stood last.
///
/// # Errors
/// A foothold is not known, or a standing foot has no support.
pub(crate) fn stand_in(
    constraints: &Constraints,
    rest_state: &RestState,
) -> Result<Endpoint, EndpointError> {
    let support = SupportMode::from_wire(rest_state.mode).ok_or(EndpointError::UnknownStance)?;
    let [Some(left), Some(right)] = [0, 1].map(|limb| rest_state.contact_of(limb)) else {
        return Err(EndpointError::UnknownStance);
    };
    for (limb, contact) in [left, right].into_iter().enumerate() {
        if support.carries(limb) && contact.polygon_len < 3 {
            return Err(EndpointError::Unsupported { limb, reason: NoSupport::NothingBelow });
        }
    }
    let footholds = [left, right].map(|contact| {
        let support = contact.polygon().iter().map(|vertex| DVec2::from_array(*vertex)).collect();
        Foothold::of(&constraints.robot, contact.limb as usize, contact.world_from_sole(), support)
    });
    let configuration = Configuration {
        world_from_root: rest_state.waypoint.world_from_root(),
        q: rest_state.waypoint.q,
    };
    let kinematic_state = KinematicState::new(&constraints.robot, &configuration);
    let world_from_soles = [0, 1].map(|limb| match support.carries(limb) {
        false => kinematic_state.world_from_sole(&constraints.robot, limb),
        true => footholds[limb].world_from_sole,
    });
    Ok(Endpoint { footholds, state: ModeState { configuration, world_from_soles }, support })
}

impl Endpoint {
    /// Whether every condition holds here, with the centre of mass `margin_min` (m) inside the
    /// support. A lifted foot may be as near to the world as one that leaves it.
    pub(crate) fn holds(&self, constraints: &Constraints, margin_min: f64) -> bool {
        let [left, right] = &self.footholds;
        let mode = match self.support {
            SupportMode::Left => single_mode(left),
            SupportMode::Right => single_mode(right),
            SupportMode::Double => double_mode(left, right),
        };
        let feet = [0, 1]
            .map(|limb| if self.stands(limb) { FootPhase::Stance } else { FootPhase::LiftOff });
        let kinematic_state = KinematicState::new(&constraints.robot, &self.state.configuration);
        let start = Some(StartBalance { com: kinematic_state.com.truncate(), margin_min });
        constraints.check(&Mode { start, ..mode }, &kinematic_state, feet).is_ok()
    }

    /// Whether a foot carries the robot.
    pub fn stands(&self, limb: usize) -> bool {
        self.support.carries(limb)
    }

    /// The placements of both feet, if both carry the robot.
    pub(crate) fn pair(&self, robot: &Mechanism) -> Option<FootPair> {
        let placements = || self.footholds.each_ref().map(|foothold| foothold.placement(robot));
        (self.support == SupportMode::Double).then(placements)
    }
}

/// The foothold at a sole pose; where that has no support, the one in which the sole comes to rest
/// when it is set down there, or else the nearest one that is near enough.
///
/// # Errors
/// The ground supports no sole there, or the foot collides with the world.
pub(crate) fn foothold_near(
    constraints: &Constraints,
    surfaces: &Surfaces,
    scratch: &mut Scratch,
    limb: usize,
    (wanted, nearness): (&Pose, Nearness),
) -> Result<Foothold, EndpointError> {
    let set_down = foothold_set_down(constraints, surfaces, scratch, limb, wanted);
    let Err(EndpointError::Unsupported { .. }) = set_down else { return set_down };
    let query = FootholdQuery {
        limb,
        ideal: *wanted,
        reach_z: GROUND_Z,
        yaw_spread: YAW_SPREAD_MAX,
        seed: 0,
        name: (limb as u64, 0),
        limits: GROUND_LIMITS,
        kept_max: 1,
    };
    let mut nearest = None;
    query.run((constraints, surfaces), scratch, &mut |placement| {
        let is_near = nearness.contains(wanted, &placement.world_from_sole);
        nearest = is_near.then_some(placement.world_from_sole).or(nearest);
        ControlFlow::Continue(is_near)
    });
    nearest.map_or(set_down, |pose| foothold_at(constraints, surfaces, scratch, limb, &pose))
}

/// The foothold at a sole pose, or where that has no support, the one in which the sole comes to
/// rest when it is set down there.
///
/// # Errors
/// That of the sole pose; on rough ground that of the pose of rest.
fn foothold_set_down(
    constraints: &Constraints,
    surfaces: &Surfaces,
    scratch: &mut Scratch,
    limb: usize,
    wanted: &Pose,
) -> Result<Foothold, EndpointError> {
    let exact = foothold_at(constraints, surfaces, scratch, limb, wanted);
    let Err(EndpointError::Unsupported { .. }) = exact else { return exact };
    let sole = SoleToRest {
        outline: &constraints.robot.soles[limb].polygon,
        position: wanted.translation,
        yaw: yaw_of(wanted.rotation),
        reach_z: GROUND_Z,
    };
    let Some(rest) = rest_pose(surfaces, scratch, &sole) else { return exact };
    match foothold_at(constraints, surfaces, scratch, limb, &rest) {
        Ok(foothold) => Ok(foothold),
        Err(error) if is_small(&error) && is_rough(sole.outline, [wanted, &rest]) => Err(error),
        Err(_) => exact,
    }
}

/// Whether a sole has contacts, but too few.
fn is_small(error: &EndpointError) -> bool {
    let EndpointError::Unsupported { reason, .. } = error else { return false };
    matches!(reason, NoSupport::AreaTooSmall | NoSupport::CentroidNearEdge)
}

/// Whether a sole that is set down comes to rest so near to the wanted pose that the ground is
/// rough there, rather than an obstacle or a hole in the sole's place.
fn is_rough(outline: &[DVec2], [wanted, rest]: [&Pose; 2]) -> bool {
    let apart = |corner: &DVec2| (*wanted * corner.extend(0.0) - *rest * corner.extend(0.0)).z;
    outline.iter().all(|corner| apart(corner).abs() <= ROUGHNESS_MAX)
}

/// The foothold exactly at a sole pose.
///
/// # Errors
/// The sole has no support there, or the foot collides with the world.
pub fn foothold_at(
    constraints: &Constraints,
    surfaces: &Surfaces,
    scratch: &mut Scratch,
    limb: usize,
    world_from_sole: &Pose,
) -> Result<Foothold, EndpointError> {
    let support = surfaces
        .support_of_sole(scratch, SoleShape::of(&constraints.robot.soles[limb]), world_from_sole)
        .map_err(|reason| EndpointError::Unsupported { limb, reason })?;
    if constraints.collision.foot_hit(limb, world_from_sole, FootPhase::Stance).is_some() {
        return Err(EndpointError::FootCollides { limb });
    }
    Ok(support.foothold(&constraints.robot, limb, *world_from_sole))
}

/// A configuration over two footholds, the centre of mass between both feet.
///
/// # Errors
/// The condition that the posture of the robot file violates; where the legs do not reach in that
/// posture, that of the first one in which they do.
pub(crate) fn stand(
    constraints: &Constraints,
    footholds: &[Foothold; 2],
    yaw: f64,
) -> Result<ModeState, EndpointError> {
    let mode = double_mode(&footholds[0], &footholds[1]);
    let world_from_soles = [footholds[0].world_from_sole, footholds[1].world_from_sole];
    let middle: DVec2 = 0.5 * (footholds[0].region.centroid() + footholds[1].region.centroid());
    let world_from_root = rotation_about(DVec3::Z, yaw);
    let mut fault = None;
    for extension in LEG_EXTENSIONS {
        let posture = Posture {
            world_from_root,
            leg_extension: extension * constraints.robot.standing_leg_extension,
            com: middle,
        };
        let posed = solve_posture(
            &constraints.robot,
            &world_from_soles,
            &posture,
            constraints.robot.standing_q,
        );
        let Ok((configuration, kinematic_state)) = posed else { continue };
        match constraints.check(&mode, &kinematic_state, [FootPhase::Stance; 2]) {
            Ok(()) => return Ok(ModeState { configuration, world_from_soles }),
            Err(rejection) => {
                fault = fault
                    .or_else(|| Some((rejection, hit_of(constraints, &kinematic_state, rejection))))
            }
        }
    }
    let (rejection, hit) = fault.unwrap_or((Rejection::Unreachable, None));
    Err(EndpointError::NoPosture { rejection, hit })
}

/// The two bodies that are too near, where a collision is the reason for a rejection.
fn hit_of(
    constraints: &Constraints,
    kinematic_state: &KinematicState,
    rejection: Rejection,
) -> Option<Hit> {
    let is_hit = matches!(rejection, Rejection::Collision | Rejection::SelfCollision);
    is_hit.then(|| constraints.collision.hit(kinematic_state, &[FootPhase::Stance; 2])).flatten()
}
