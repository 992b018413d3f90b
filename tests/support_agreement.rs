//! The support that the planner finds for a sole on uneven ground is one that the checker measures,
//! too: the planner's margins do not have to cover a difference between their definitions.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]
#![allow(clippy::print_stdout, reason = "the comparison is printed")]

#[path = "common/measured_sole.rs"]
mod measured_sole;

use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};
use measured_sole::{foot_shift, measured, placements};
use surefoot_controller_sim::Checker;
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::foot_placement::{FootPlacementConfig, Scratch, Surfaces};
use surefoot_planner::geometry::convex_region::ConvexRegion;
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::base::spatial::rotation_about;
use surefoot_shared_types::config::planner::CONTACT_TILT_MAX;
use surefoot_shared_types::config::{CheckerConfig, PlannerConfig};
use surefoot_shared_types::geometry::shape::Shape;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::load::load_world;
use surefoot_shared_types::world::world::{World, WorldShape};

/// Placements that are compared, and those beside the last one.
const PLACEMENTS: usize = 200;
/// The most by which a corner of the planner's support lies beyond the checker's, m: the reserve of
/// the planner's margin of the centre of mass.
const BEYOND_MAX: f64 = 4e-3;
/// The same on bars, m: at their ends the checker's samples are coarser.
const BEYOND_ON_BARS_MAX: f64 = 2e-3;
/// Soles on bars of one radius.
const SOLES_ON_BARS: usize = 60;

fn configs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("configs")
}

fn hubo() -> RobotModel {
    load_robot(&configs().join("robots/hubo/robot.toml")).unwrap()
}

/// The support that the planner relies on.
fn placement_config(model: &RobotModel) -> FootPlacementConfig {
    FootPlacementConfig {
        centre_height: Mechanism::new(model, &PlannerConfig::default()).unwrap().centre_height,
        foot_shift: foot_shift(model),
        is_secured: true,
        ..FootPlacementConfig::default()
    }
}

/// The checker's support of a left sole, in world x and y.
fn region(checker: &mut Checker, model: &RobotModel, world_from_sole: &Pose) -> ConvexRegion {
    ConvexRegion::hull(measured(checker, model, world_from_sole).into_iter().map(DVec3::truncate))
}

/// The most by which a corner of the planner's support lies beyond the checker's (m), over
/// placements of a sole on a shipped world between two corners of a box.
fn beyond(world: &str, [low, high]: [DVec3; 2]) -> f64 {
    let model = hubo();
    let world_of = load_world(&configs().join(format!("worlds/{world}.toml"))).unwrap();
    let sole = &model.feet[0].polygon;
    let surfaces = Surfaces::new(&world_of, placement_config(&model)).unwrap();
    let mut checker = Checker::new(model.clone(), world_of, CheckerConfig::default()).unwrap();
    let mut random = Random::new(1, Stream::Preparation, 0, 0);
    let (mut count, mut worst, mut index) = (0, f64::NEG_INFINITY, 0);
    while count < PLACEMENTS {
        let at = DVec3::from_array([0, 1, 2].map(|axis| random.uniform(low[axis], high[axis])));
        let heading = rotation_about(DVec3::Z, random.uniform(-3.0, 3.0));
        index += 1;
        for found in placements(&surfaces, sole, (Pose::from_parts(at, heading), index), 4) {
            let region = region(&mut checker, &model, &found.world_from_sole);
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

/// A world of two bars along y, tilted about y.
fn bars(radius: f64, places: [f64; 2], half_length: f64, world_from_bars: &Pose) -> World {
    let along_y = rotation_about(DVec3::X, -std::f64::consts::FRAC_PI_2);
    let bar = |(index, x): (usize, &f64)| WorldShape {
        name: format!("bar {index}"),
        world_from_shape: *world_from_bars
            * Pose::from_parts(DVec3::new(*x, 0.0, -radius), along_y),
        shape: Shape::Cylinder { radius, half_length },
    };
    World {
        mu: 0.6,
        shapes: places.iter().enumerate().map(bar).collect(),
        digest: Digest::default(),
    }
}

/// Soles on two bars of a radius: near each other and far apart, turned and tilted, and with the
/// lines near every edge.
fn on_bars(model: &RobotModel, radius: f64) -> Agreement {
    let sole = &model.feet[0].polygon;
    let (back, front) =
        sole.iter().fold((0.0_f64, 0.0_f64), |(back, front), at| (back.min(at.x), front.max(at.x)));
    let mut random = Random::new(1, Stream::Preparation, 0, 0);
    let mut agreement = Agreement::default();
    for index in 0..SOLES_ON_BARS {
        let spacing = (front - back) * random.uniform(0.5, 1.02);
        let turn = random.uniform(-0.6, 0.6) * random.uniform(0.0, 1.0);
        let tilt = if index % 2 == 0 { 0.0 } else { random.uniform(-0.3, 0.3) };
        // Of some bars the ends are under the sole.
        let half_length = if index % 4 == 3 { 0.05 } else { 0.5 };
        let slack = 0.5 * (front - back - spacing).abs() + 0.01;
        let middle = 0.5 * spacing + random.uniform(-slack, slack);
        let place = DVec3::new(middle, random.uniform(-0.03, 0.03), 0.0);
        let world_from_bars = Pose::from_parts(DVec3::ZERO, rotation_about(DVec3::Y, tilt));
        let world_from_sole = world_from_bars
            * Pose::from_parts(place, rotation_about(DVec3::Z, turn))
            * Pose::from_translation(DVec3::new(-0.5 * (front + back), 0.0, 0.0));
        let world = bars(radius, [0.0, spacing], half_length, &world_from_bars);
        agreement.compare(model, world, &world_from_sole);
    }
    agreement
}

/// How well the planner's supports agree with the checker's.
#[derive(Debug, Default)]
struct Agreement {
    /// Soles that both support.
    both: usize,
    /// Soles that only the checker supports.
    checker_only: usize,
    /// The most by which a corner of the planner's support lies beyond the checker's, m.
    beyond: f64,
    /// The sums of the areas that the planner and the checker find, m2.
    areas: [f64; 2],
}

impl Agreement {
    fn compare(&mut self, model: &RobotModel, world: World, world_from_sole: &Pose) {
        let config = FootPlacementConfig {
            support_area_min: 2e-3,
            centroid_edge_distance_min: 0.01,
            ..placement_config(model)
        };
        let surfaces = Surfaces::new(&world, config).unwrap();
        let mut checker = Checker::new(model.clone(), world, CheckerConfig::default()).unwrap();
        let measured = region(&mut checker, model, world_from_sole);
        let mut scratch = Scratch::new(surfaces.config());
        let found = surfaces.support(&mut scratch, &model.feet[0].polygon, world_from_sole);
        let Ok(support) = found else {
            self.checker_only += usize::from(area(measured.vertices()) > 8e-3);
            return;
        };
        let corners = support.polygon.iter().map(|corner| *world_from_sole * corner.extend(0.0));
        let corners: Vec<DVec2> = corners.map(DVec3::truncate).collect();
        let beyond = corners.iter().map(|corner| -measured.margin(*corner));
        self.beyond = beyond.fold(self.beyond, f64::max);
        self.both += 1;
        self.areas[0] += area(&corners);
        self.areas[1] += area(measured.vertices());
    }
}

/// The area of a polygon, m2.
fn area(corners: &[DVec2]) -> f64 {
    let next = corners.iter().cycle().skip(1);
    corners.iter().zip(next).map(|(a, b)| 0.5 * a.perp_dot(*b)).sum()
}

#[test]
fn on_bars_of_any_radius_the_planner_relies_on_all_that_the_checker_measures_and_no_more() {
    let model = hubo();
    for radius in [0.005, 0.01, 0.02, 0.03, 0.06] {
        let agreement = on_bars(&model, radius);
        let Agreement { both, checker_only, beyond, areas } = agreement;
        let share = areas[0] / areas[1];
        println!("{radius} m: {both} and {checker_only} soles, {share:.3}, {:.2} mm", 1e3 * beyond);
        assert!(both > 7 * SOLES_ON_BARS / 10 && checker_only < SOLES_ON_BARS / 5, "{agreement:?}");
        assert!(beyond <= BEYOND_ON_BARS_MAX && share > 0.9, "{agreement:?}");
    }
}

/// A floor that ends at x = 0, from where a ramp rises.
fn floor_before_ramp(incline: f64) -> World {
    let half_extents = DVec3::new(0.5, 0.5, 0.1);
    let block = |name: &str, incline: f64, middle: DVec3| {
        let rotation = rotation_about(DVec3::Y, -incline);
        WorldShape {
            name: name.into(),
            world_from_shape: Pose::from_parts(rotation * middle, rotation),
            shape: Shape::Box { half_extents },
        }
    };
    let floor = block("floor", 0.0, DVec3::new(-0.5, 0.0, -0.1));
    let ramp = block("ramp", incline, DVec3::new(0.5, 0.0, -0.1));
    World { mu: 0.6, shapes: vec![floor, ramp], digest: Digest::default() }
}

#[test]
fn a_toe_that_just_touches_a_ramp_tilts_the_foot_for_both() {
    let model = hubo();
    let mut random = Random::new(1, Stream::Preparation, 0, 0);
    let mut agreement = Agreement::default();
    for _ in 0..SOLES_ON_BARS {
        let incline = random.uniform(0.02, CONTACT_TILT_MAX);
        let world = floor_before_ramp(incline);
        let turn = random.uniform(-0.3, 0.3);
        // The foremost corner is as far on the ramp, and no deeper in it than ground may be.
        let heading = rotation_about(DVec3::Z, turn);
        let corners = model.feet[0].polygon.iter().map(|at| (heading * at.extend(0.0)).x);
        let reach = corners.fold(0.0, f64::max);
        let farthest = 9e-5 / libm::tan(incline);
        let place = DVec3::new(random.uniform(5e-4, farthest.min(8e-3)) - reach, 0.0, 0.0);
        agreement.compare(&model, world, &Pose::from_parts(place, heading));
    }
    println!("ramps: {agreement:?}");
    assert!(agreement.both > SOLES_ON_BARS / 2 && agreement.checker_only == 0, "{agreement:?}");
    assert!(agreement.beyond <= BEYOND_MAX, "{agreement:?}");
}
