//! The support that the planner finds for a sole on uneven ground is one that the checker measures,
//! too: the planner's margins do not have to cover a difference between their definitions.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]
#![allow(clippy::print_stdout, reason = "the comparison is printed")]

use std::path::Path;

use bytemuck::Zeroable;
use glam::{DVec2, DVec3};
use surefoot_controller_sim::Checker;
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::foot_placement::{
    FootPlacementConfig, PlacementQuery, SampleLimits, Scratch, SupportedSole, Surfaces, propose,
};
use surefoot_planner::geometry::convex_region::ConvexRegion;
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::base::spatial::rotation_about;
use surefoot_shared_types::config::{CheckerConfig, PlannerConfig};
use surefoot_shared_types::message::{Contact, Waypoint};
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::load::load_world;

/// Placements that are compared.
const PLACEMENTS: usize = 200;
/// The most by which a corner of the planner's support lies beyond the checker's, m: the reserve of
/// the planner's margin of the centre of mass.
const BEYOND_MAX: f64 = 4e-3;

/// The placements of a sole near a point of the ground, the nearest ones.
fn placements(surfaces: &Surfaces, sole: &[DVec2], ideal: Pose, index: u64) -> Vec<SupportedSole> {
    let query = PlacementQuery {
        sole_polygon: sole,
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
        found.len() < 4
    });
    found
}

/// The checker's support of a left sole, in world x and y, under a robot that stands on it.
fn measured(checker: &mut Checker, model: &RobotModel, world_from_sole: &Pose) -> ConvexRegion {
    let contact = Contact {
        position: world_from_sole.translation.to_array(),
        rotation: world_from_sole.rotation.to_array(),
        ..Contact::zeroed()
    };
    let mut q = [0.0; JOINTS_MAX];
    q[..model.joints.len()].copy_from_slice(&model.standing_q);
    let above = Pose::from_translation(world_from_sole.translation + DVec3::Z * ROOT_HEIGHT);
    let supports = checker.sole_supports(&[contact], &[Waypoint::at_rest(0.0, &above, &q)]);
    ConvexRegion::hull(supports.corners().map(DVec3::truncate))
}

/// Height of a standing robot's root over its soles, m: a little more than that of the highest
/// shipped robot.
const ROOT_HEIGHT: f64 = 0.9;

/// The most by which a corner of the planner's support lies beyond the checker's (m), over
/// placements of a sole on a shipped world between two corners of a box.
fn beyond(world: &str, [low, high]: [DVec3; 2]) -> f64 {
    let configs = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
    let model = load_robot(&configs.join("robots/hubo/robot.toml")).unwrap();
    let world_of = load_world(&configs.join(format!("worlds/{world}.toml"))).unwrap();
    let limits = CheckerConfig::default();
    let sole = &model.feet[0].polygon;
    let reach = sole.iter().map(|corner| corner.length()).fold(0.0, f64::max);
    let config = FootPlacementConfig {
        centre_height: Mechanism::new(&model, &PlannerConfig::default()).unwrap().centre_height,
        foot_shift: limits.foot_position_max + limits.foot_rotation_max * reach,
        is_secured: true,
        ..FootPlacementConfig::default()
    };
    let surfaces = Surfaces::new(&world_of, config).unwrap();
    let mut checker = Checker::new(model.clone(), world_of, limits).unwrap();
    let mut random = Random::new(1, Stream::Preparation, 0, 0);
    let (mut count, mut worst, mut index) = (0, f64::NEG_INFINITY, 0);
    while count < PLACEMENTS {
        let at = DVec3::from_array([0, 1, 2].map(|axis| random.uniform(low[axis], high[axis])));
        let heading = rotation_about(DVec3::Z, random.uniform(-3.0, 3.0));
        index += 1;
        for found in placements(&surfaces, sole, Pose::from_parts(at, heading), index) {
            let region = measured(&mut checker, &model, &found.world_from_sole);
            for corner in &found.support.polygon {
                let corner = found.world_from_sole * corner.extend(0.0);
                worst = worst.max(-region.margin(corner.truncate()));
            }
            count += 1;
        }
    }
    println!("{world}: {count} placements, at most {:.2} mm beyond", 1e3 * worst);
    worst
}

#[test]
fn on_uneven_ground_the_planner_relies_on_no_support_that_the_checker_does_not_measure() {
    let ground = [DVec3::new(0.5, -0.8, 0.0), DVec3::new(4.5, 0.8, 0.0)];
    assert!(beyond("rough_ground", ground) <= BEYOND_MAX);
}

#[test]
fn on_bars_the_planner_relies_on_no_line_that_a_foot_beside_its_place_may_miss() {
    let bars = [DVec3::new(1.7, -0.4, 0.0), DVec3::new(5.5, 0.4, 0.0)];
    assert!(beyond("bars_thin", bars) <= BEYOND_MAX);
}

#[test]
fn on_blocks_the_checker_measures_all_of_a_support_that_is_cut_by_an_edge() {
    let blocks = [DVec3::new(2.2, -0.6, -0.1), DVec3::new(4.2, 0.6, 0.1)];
    assert!(beyond("cinder_blocks", blocks) <= BEYOND_MAX);
}
