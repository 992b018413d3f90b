//! The checker's support of a sole on uneven ground is no larger than one that is computed on a
//! dense grid, without rays and with tilts of the foot in all directions.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]
#![allow(clippy::print_stdout, reason = "the comparison is printed")]

#[path = "common/dense_support.rs"]
mod dense_support;

use std::path::Path;

use bytemuck::Zeroable;
use dense_support::DenseGround;
use glam::{DVec2, DVec3};
use surefoot_controller_sim::Checker;
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::foot_placement::{
    FootPlacementConfig, PlacementQuery, SampleLimits, Scratch, SoleShape, Surfaces, propose,
};
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::base::spatial::rotation_about;
use surefoot_shared_types::config::{CheckerConfig, PlannerConfig};
use surefoot_shared_types::message::{Contact, Waypoint};
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::load::load_world;

/// Soles that are compared.
const SOLES: usize = 24;
/// The most by which a corner of the checker's support may lie beyond the dense one, m: the spacing
/// of the checker's rays and of the grid.
const BEYOND_MAX: f64 = 1.5e-3;
/// Height of the root over a sole, m.
const ROOT_HEIGHT: f64 = 0.9;
/// The checker rounds heights of the centre of mass up to a multiple of this one, m.
const HEIGHT_STEP: f64 = 0.05;

/// Poses of a sole that is set down on the rough ground.
fn poses(surfaces: &Surfaces, outline: &[DVec2]) -> Vec<Pose> {
    let mut random = Random::new(1, Stream::Preparation, 0, 0);
    let mut scratch = Scratch::new(surfaces.config());
    let mut found = Vec::new();
    for object in 0..200 {
        let at = DVec3::new(random.uniform(0.5, 4.5), random.uniform(-0.8, 0.8), 0.0);
        let heading = rotation_about(DVec3::Z, random.uniform(-3.0, 3.0));
        let query = PlacementQuery {
            sole: SoleShape::flat(outline),
            ideal: Pose::from_parts(at, heading),
            reach_xy: 0.2,
            reach_z: [-0.3, 0.3],
            yaw_spread: 0.5,
            seed: 1,
            object,
            attempt: 0,
            limits: SampleLimits { geometric_max: 20, perturbed_max: 0, sampled_max: 0 },
            is_free: &|_| true,
        };
        propose(surfaces, &mut scratch, &query, &mut |placement| {
            found.push(placement.world_from_sole);
            false
        });
        if found.len() >= SOLES {
            break;
        }
    }
    found
}

/// The corners of the checker's support of a left sole, in the sole frame.
fn measured(checker: &mut Checker, model: &RobotModel, world_from_sole: &Pose) -> Vec<DVec2> {
    let contact = Contact {
        position: world_from_sole.translation.to_array(),
        rotation: world_from_sole.rotation.to_array(),
        ..Contact::zeroed()
    };
    let mut q = [0.0; JOINTS_MAX];
    q[..model.joints.len()].copy_from_slice(&model.standing_q);
    let above = Pose::from_translation(world_from_sole.translation + DVec3::Z * ROOT_HEIGHT);
    let supports = checker.sole_supports(&[contact], &[Waypoint::at_rest(0.0, &above, &q)]);
    let sole_from_world = world_from_sole.inverse();
    supports.corners().map(|corner| (sole_from_world * corner).truncate()).collect()
}

#[test]
fn on_rough_ground_the_checker_measures_no_more_than_a_dense_grid_shows() {
    let configs = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
    let model = load_robot(&configs.join("robots/hubo/robot.toml")).unwrap();
    let world = load_world(&configs.join("worlds/rough_ground.toml")).unwrap();
    let outline = &model.feet[0].polygon;
    let surfaces = Surfaces::new(&world, FootPlacementConfig::default()).unwrap();
    let mut checker = Checker::new(model.clone(), world.clone(), CheckerConfig::default()).unwrap();
    let limits = CheckerConfig::default();
    let reach = outline.iter().map(|corner| corner.length()).fold(0.0, f64::max);
    let shift = limits.foot_position_max + limits.foot_rotation_max * reach;
    let centre = Mechanism::new(&model, &PlannerConfig::default()).unwrap().standing_com;
    let (mut count, mut worst) = (0, f64::NEG_INFINITY);
    for pose in poses(&surfaces, outline) {
        let height = (ROOT_HEIGHT * DVec3::Z + centre).dot(pose.rotation * DVec3::Z);
        let height = (height / HEIGHT_STEP).ceil() * HEIGHT_STEP;
        let dense = DenseGround::new(&world, &pose, outline, shift).region(height, shift);
        let corners = measured(&mut checker, &model, &pose);
        let beyond = corners.iter().map(|corner| dense.beyond(*corner));
        worst = beyond.fold(worst, f64::max);
        count += usize::from(corners.len() > 2);
    }
    println!("{count} soles, at most {:.2} mm beyond", 1e3 * worst);
    assert!(count > SOLES / 2 && worst <= BEYOND_MAX, "{count} soles, {worst} m");
}
