//! Soles that the planner places on uneven ground, and the support that the checker measures under
//! them.

use bytemuck::Zeroable;
use glam::{DVec2, DVec3};
use surefoot_controller_sim::Checker;
use surefoot_planner::foot_placement::{
    PlacementQuery, SampleLimits, Scratch, SoleShape, SupportedSole, Surfaces, propose,
};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::config::CheckerConfig;
use surefoot_shared_types::message::{Contact, Waypoint};
use surefoot_shared_types::robot::model::RobotModel;

/// Height of a standing robot's root over its soles, m: a little more than that of the highest
/// shipped robot.
pub const ROOT_HEIGHT: f64 = 0.9;

/// How far a left sole may be beside its declared pose, m.
pub fn foot_shift(model: &RobotModel) -> f64 {
    let limits = CheckerConfig::default();
    let reach = model.feet[0].polygon.iter().map(|corner| corner.length()).fold(0.0, f64::max);
    limits.foot_position_max + limits.foot_rotation_max * reach
}

/// The placements of a sole near a point of the ground, the nearest ones, `most` at most.
pub fn placements(
    surfaces: &Surfaces,
    sole: &[DVec2],
    (ideal, index): (Pose, u64),
    most: usize,
) -> Vec<SupportedSole> {
    let query = PlacementQuery {
        sole: SoleShape::flat(sole),
        ideal,
        reach_xy: 0.2,
        reach_z: [-0.3, 0.3],
        yaw_spread: 0.5,
        seed: 1,
        object: index,
        attempt: 0,
        limits: SampleLimits { geometric_max: 20, perturbed_max: 0, sampled_max: 0 },
        is_free: &|_| true,
    };
    let mut found = Vec::new();
    propose(surfaces, &mut Scratch::new(surfaces.config()), &query, &mut |placement| {
        found.push(placement);
        found.len() < most
    });
    found
}

/// The corners of the checker's support of a left sole under a robot that stands on it, in the
/// world.
pub fn measured(checker: &mut Checker, model: &RobotModel, world_from_sole: &Pose) -> Vec<DVec3> {
    let contact = Contact {
        position: world_from_sole.translation.to_array(),
        rotation: world_from_sole.rotation.to_array(),
        ..Contact::zeroed()
    };
    let mut q = [0.0; JOINTS_MAX];
    q[..model.joints.len()].copy_from_slice(&model.standing_q);
    let above = Pose::from_translation(world_from_sole.translation + DVec3::Z * ROOT_HEIGHT);
    let supports = checker.sole_supports(&[contact], &[Waypoint::at_rest(0.0, &above, &q)]);
    supports.corners().collect()
}
