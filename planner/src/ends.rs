//! Whether and how the robot stands at the start and at the goal.

use std::ops::ControlFlow;

use glam::DVec2;
use surefoot_shared_types::Pose;
use surefoot_shared_types::config::scenario::StancePose;
use surefoot_shared_types::message::{Contact, RestState, SupportMode};
use surefoot_shared_types::world::world::World;

use crate::collision::model::{FootPhase, Hit};
use crate::constraints::constraints::{Constraints, Mode, Rejection, StartBalance};
use crate::constraints::foothold::{Foothold, double_mode, single_mode};
use crate::foot_placement::foothold_query::{FootholdQuery, YAW_SPREAD_MAX};
use crate::foot_placement::sole_support::{NoSupport, SurfacesError};
use crate::foot_placement::{FootPlacementConfig, SampleLimits, Scratch, Surfaces};
use crate::motion::local_planner::ModeState;
use crate::outcome::EndpointError;
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::{Configuration, Mechanism};
use crate::robot::posture_ik::{Posture, solve_posture};

/// Shares of the standing posture's reach that are tried for standing.
const REACH_SHARES: [f64; 5] = [1.0, 0.97, 0.94, 0.9, 0.85];

/// Both feet on a mark.
#[derive(Debug, Clone)]
pub struct End {
    /// The placements, left and right.
    pub footholds: [Foothold; 2],
    /// The robot standing on them.
    pub state: ModeState,
    /// Which of them carry it.
    pub support: SupportMode,
}

/// How far below and above its print a sole may find the ground, m.
const GROUND_REACH_Z: [f64; 2] = [-0.1, 0.1];
/// How far aside of its print a sole may come to rest, m.
const ASIDE_MAX: f64 = 0.03;
/// How hard ground near a print is looked for.
const GROUND_LIMITS: SampleLimits =
    SampleLimits { geometric_max: 64, perturbed_max: 0, sampled_max: 0 };

/// Stands the robot on a mark: exactly where the ground is level there, and else as the ground near
/// it takes each sole.
///
/// # Errors
/// Why it cannot stand there.
pub fn stand_on(
    constraints: &Constraints,
    surfaces: &Surfaces,
    scratch: &mut Scratch,
    mark: &StancePose,
) -> Result<End, EndpointError> {
    let prints = mark.world_from_soles();
    let left = foothold_near(constraints, surfaces, scratch, 0, &prints[0])?;
    let right = foothold_near(constraints, surfaces, scratch, 1, &prints[1])?;
    let footholds = [left, right];
    let state = stand(constraints, &footholds, mark.yaw)?;
    Ok(End { footholds, state, support: SupportMode::Double })
}

/// The smallest area that is looked for under a foot that stands already, m2: whatever carries it
/// counts.
const STANDING_AREA_MIN: f64 = 1e-4;
/// The narrowest piece of a face that counts then, m: the robot was seen to stand on it.
const STANDING_WIDTH_MIN: f64 = 2e-3;

/// A world as it turned out to be, to look for what carries feet that stand already.
pub(crate) struct StandingGround {
    surfaces: Surfaces,
    scratch: Scratch,
}

impl StandingGround {
    /// Compiles a world. Allocates; to be called before the search.
    ///
    /// # Errors
    /// The world has a shape that cannot be used.
    pub(crate) fn new(world: &World) -> Result<Self, SurfacesError> {
        let config = FootPlacementConfig {
            support_area_min: STANDING_AREA_MIN,
            centroid_edge_distance_min: 0.0,
            contact_width_min: STANDING_WIDTH_MIN,
            ..FootPlacementConfig::default()
        };
        Ok(Self { scratch: Scratch::new(&config), surfaces: Surfaces::new(world, config)? })
    }

    /// Where the robot stands with the support that the world gives each foot that carries it. One
    /// that it gives none loses its polygon: [`stand_as`] refuses it then.
    pub(crate) fn supported_anew(&mut self, robot: &Mechanism, standing: &RestState) -> RestState {
        let mut standing = *standing;
        let mode = SupportMode::from_wire(standing.mode);
        for contact in &mut standing.contacts[..standing.contacts_len as usize] {
            let limb = contact.limb as usize;
            if mode.is_some_and(|mode| mode.carries(limb)) {
                let support = self.surfaces.support(
                    &mut self.scratch,
                    &robot.sole_polygons[limb],
                    &contact.world_from_sole(),
                );
                set_polygon(contact, support.as_ref().map_or(&[], |support| &support.polygon));
            }
        }
        standing
    }
}

fn set_polygon(contact: &mut Contact, polygon: &[DVec2]) {
    contact.polygon = Default::default();
    contact.polygon.iter_mut().zip(polygon).for_each(|(slot, vertex)| *slot = vertex.to_array());
    contact.polygon_len = polygon.len() as u32;
}

/// Takes the robot as it stands where a walk was broken off, on both feet or on one. A foot that
/// carries it is supported as it says, so where the world was corrected meanwhile it is to be
/// supported anew first; a lifted one is remembered where it stood last.
///
/// # Errors
/// It is not known where both feet stood, or nothing carries one that the robot stands on.
pub fn stand_as(constraints: &Constraints, standing: &RestState) -> Result<End, EndpointError> {
    let support = SupportMode::from_wire(standing.mode).ok_or(EndpointError::UnknownStance)?;
    let [Some(left), Some(right)] = [0, 1].map(|limb| standing.contact_of(limb)) else {
        return Err(EndpointError::UnknownStance);
    };
    for (limb, contact) in [left, right].into_iter().enumerate() {
        if support.carries(limb) && contact.polygon_len < 3 {
            return Err(EndpointError::Unsupported { limb, reason: NoSupport::NothingBelow });
        }
    }
    let footholds = [left, right].map(|contact| {
        let polygon = &contact.polygon[..(contact.polygon_len as usize).min(contact.polygon.len())];
        let support = polygon.iter().map(|vertex| DVec2::from_array(*vertex)).collect();
        Foothold::of(&constraints.robot, contact.limb as usize, contact.world_from_sole(), support)
    });
    let configuration = Configuration {
        world_from_root: standing.waypoint.world_from_root(),
        q: standing.waypoint.q,
    };
    let kinematic_state = constraints.robot.kinematic_state(&configuration);
    let world_from_soles = [0, 1].map(|limb| match support.carries(limb) {
        false => constraints.robot.world_from_sole(&kinematic_state, limb),
        true => footholds[limb].world_from_sole,
    });
    Ok(End { footholds, state: ModeState { configuration, world_from_soles }, support })
}

impl End {
    /// Whether every condition holds where the robot stands, its centre of mass `margin_min` (m)
    /// inside its support, a lifted foot as near to the world as one that is just leaving it.
    pub fn holds(&self, constraints: &Constraints, margin_min: f64) -> bool {
        let [left, right] = &self.footholds;
        let mode = match self.support {
            SupportMode::Left => single_mode(left),
            SupportMode::Right => single_mode(right),
            SupportMode::Double => double_mode(left, right),
        };
        let feet = [0, 1]
            .map(|limb| if self.stands(limb) { FootPhase::Stance } else { FootPhase::LiftOff });
        let kinematic_state = constraints.robot.kinematic_state(&self.state.configuration);
        let start = Some(StartBalance { com: kinematic_state.com.truncate(), margin_min });
        constraints.check(&Mode { start, ..mode }, &kinematic_state, feet).is_ok()
    }

    /// Whether a foot carries the robot.
    pub fn stands(&self, limb: usize) -> bool {
        self.support.carries(limb)
    }
}

/// The placement of a foot at a pose, or where that is not carried the nearest one that the ground
/// offers.
fn foothold_near(
    constraints: &Constraints,
    surfaces: &Surfaces,
    scratch: &mut Scratch,
    limb: usize,
    print: &Pose,
) -> Result<Foothold, EndpointError> {
    let exact = foothold_at(constraints, surfaces, scratch, limb, print);
    let Err(EndpointError::Unsupported { .. }) = exact else { return exact };
    let query = FootholdQuery {
        limb,
        ideal: *print,
        reach_z: GROUND_REACH_Z,
        yaw_spread: YAW_SPREAD_MAX,
        seed: 0,
        name: (limb as u64, 0),
        limits: GROUND_LIMITS,
        kept_max: 1,
    };
    let mut nearest = None;
    query.run((constraints, surfaces), scratch, &mut |placement| {
        let aside = (placement.world_from_sole.translation - print.translation).truncate().length();
        let is_near = aside <= ASIDE_MAX;
        nearest = is_near.then_some(placement.world_from_sole).or(nearest);
        ControlFlow::Continue(is_near)
    });
    nearest.map_or(exact, |pose| foothold_at(constraints, surfaces, scratch, limb, &pose))
}

/// The placement of a foot exactly at a pose.
///
/// # Errors
/// No support, or the foot meets the world.
pub fn foothold_at(
    constraints: &Constraints,
    surfaces: &Surfaces,
    scratch: &mut Scratch,
    limb: usize,
    world_from_sole: &Pose,
) -> Result<Foothold, EndpointError> {
    let support = surfaces
        .support(scratch, &constraints.robot.sole_polygons[limb], world_from_sole)
        .map_err(|reason| EndpointError::Unsupported { limb, reason })?;
    if constraints.collision.foot_hit(limb, world_from_sole, FootPhase::Stance).is_some() {
        return Err(EndpointError::FootCollides { limb });
    }
    Ok(Foothold::of(&constraints.robot, limb, *world_from_sole, support.polygon))
}

/// A standing configuration over two placements, the centre of mass between both feet.
///
/// # Errors
/// What is wrong with the posture that the robot file asks for; where the legs do not reach in that
/// one, with the next that they reach in.
pub fn stand(
    constraints: &Constraints,
    footholds: &[Foothold; 2],
    yaw: f64,
) -> Result<ModeState, EndpointError> {
    let mode = double_mode(&footholds[0], &footholds[1]);
    let world_from_soles = [footholds[0].world_from_sole, footholds[1].world_from_sole];
    let middle: DVec2 = 0.5 * (footholds[0].region.centroid() + footholds[1].region.centroid());
    let world_from_root = surefoot_shared_types::base::spatial::rotation_about(glam::DVec3::Z, yaw);
    let mut fault = None;
    for share in REACH_SHARES {
        let posture = Posture {
            world_from_root,
            leg_extension: share * constraints.robot.standing_leg_extension,
            com: middle,
        };
        let settled = solve_posture(
            &constraints.robot,
            &world_from_soles,
            &posture,
            constraints.robot.standing_q,
        );
        let Ok((configuration, kinematic_state)) = settled else { continue };
        match constraints.check(&mode, &kinematic_state, [FootPhase::Stance; 2]) {
            Ok(()) => return Ok(ModeState { configuration, world_from_soles }),
            Err(rejection) => {
                fault = fault.or_else(|| {
                    Some((rejection, what_hits(constraints, &kinematic_state, rejection)))
                })
            }
        }
    }
    let (rejection, hit) = fault.unwrap_or((Rejection::Unreachable, None));
    Err(EndpointError::NoPosture { rejection, hit })
}

/// What is too near to what, where that is why a standing robot was rejected.
fn what_hits(
    constraints: &Constraints,
    kinematic_state: &KinematicState,
    rejection: Rejection,
) -> Option<Hit> {
    let is_hit = matches!(rejection, Rejection::Collision | Rejection::SelfCollision);
    is_hit.then(|| constraints.collision.hit(kinematic_state, &[FootPhase::Stance; 2])).flatten()
}
