//! The checker's support of a sole on uneven ground is no larger than one that is computed on a
//! dense grid, without rays and with tilts of the foot in all directions.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]
#![allow(clippy::print_stdout, reason = "the comparison is printed")]

#[path = "common/dense_support.rs"]
mod dense_support;
#[path = "common/measured_sole.rs"]
mod measured_sole;

use std::path::Path;

use dense_support::DenseGround;
use glam::{DVec2, DVec3};
use measured_sole::{ROOT_HEIGHT, foot_shift, measured, placements};
use surefoot_controller_sim::Checker;
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::foot_placement::{FootPlacementConfig, Surfaces};
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_about;
use surefoot_shared_types::config::{CheckerConfig, PlannerConfig};
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::world::load::load_world;

/// Soles that are compared.
const SOLES: usize = 24;
/// The most by which a corner of the checker's support may lie beyond the dense one, m: the spacing
/// of the checker's rays and of the grid.
const BEYOND_MAX: f64 = 1.5e-3;
/// The checker rounds heights of the centre of mass up to a multiple of this one, m.
const HEIGHT_STEP: f64 = 0.05;

/// Poses of a sole that is set down on the rough ground.
fn poses(surfaces: &Surfaces, outline: &[DVec2]) -> Vec<Pose> {
    let mut random = Random::new(1, Stream::Preparation, 0, 0);
    let ideals = (0..200).map(|index| {
        let at = DVec3::new(random.uniform(0.5, 4.5), random.uniform(-0.8, 0.8), 0.0);
        (Pose::from_parts(at, rotation_about(DVec3::Z, random.uniform(-3.0, 3.0))), index)
    });
    let nearest = ideals.filter_map(|ideal| placements(surfaces, outline, ideal, 1).pop());
    nearest.map(|placement| placement.world_from_sole).take(SOLES).collect()
}

#[test]
fn on_rough_ground_the_checker_measures_no_more_than_a_dense_grid_shows() {
    let configs = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
    let model = load_robot(&configs.join("robots/hubo/robot.toml")).unwrap();
    let world = load_world(&configs.join("worlds/rough_ground.toml")).unwrap();
    let outline = &model.feet[0].polygon;
    let surfaces = Surfaces::new(&world, FootPlacementConfig::default()).unwrap();
    let mut checker = Checker::new(model.clone(), world.clone(), CheckerConfig::default()).unwrap();
    let shift = foot_shift(&model);
    let centre = Mechanism::new(&model, &PlannerConfig::default()).unwrap().standing_com;
    let (mut count, mut worst) = (0, f64::NEG_INFINITY);
    for pose in poses(&surfaces, outline) {
        let height = (ROOT_HEIGHT * DVec3::Z + centre).dot(pose.rotation * DVec3::Z);
        let height = (height / HEIGHT_STEP).ceil() * HEIGHT_STEP;
        let dense = DenseGround::new(&world, &pose, outline, shift).region(height, shift);
        let corners = measured(&mut checker, &model, &pose);
        let sole_from_world = pose.inverse();
        let beyond =
            corners.iter().map(|corner| dense.beyond((sole_from_world * *corner).truncate()));
        worst = beyond.fold(worst, f64::max);
        count += usize::from(corners.len() > 2);
    }
    println!("{count} soles, at most {:.2} mm beyond", 1e3 * worst);
    assert!(count > SOLES / 2 && worst <= BEYOND_MAX, "{count} soles, {worst} m");
}
