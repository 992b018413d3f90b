//! The hardest variants are what they claim to be: one thing harder, the rest as in the original.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/sole_support.rs"]
mod sole_support;

use std::collections::BTreeSet;

use glam::{DVec3, EulerRot};
use sole_support::{bounds, configs, half_extents, named, shape, world};
use surefoot_shared_types::Shape;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::world::world::{World, WorldShape};

const EPSILON: f64 = 2e-6;
/// Radius of rails and of the bar across, m.
const RAIL_RADIUS: f64 = 0.02;

fn assert_near(actual: f64, expected: f64, what: &str) {
    assert!((actual - expected).abs() < EPSILON, "{what}: {actual}, not {expected}");
}

/// Asserts that a world has all shapes of another but those whose names begin with a prefix.
fn assert_has_all_of(harder: &World, original: &World, but: &[&str]) {
    let differs = |shape: &&WorldShape| !but.iter().any(|prefix| shape.name.starts_with(prefix));
    for known in original.shapes.iter().filter(differs) {
        let same = shape(harder, &known.name);
        let offset = same.world_from_shape.translation - known.world_from_shape.translation;
        assert!(same.shape == known.shape && offset.length() < EPSILON, "'{}'", known.name);
    }
}

#[test]
fn twenty_steep_heaps_differ_and_lean_twice_as_far() {
    let pit = world("cinder_blocks");
    let mut heaps = BTreeSet::new();
    for seed in 1..=20 {
        let heap = world(&format!("cinder_blocks_steep/{seed:02}"));
        assert_has_all_of(&heap, &pit, &["block_"]);
        let blocks = named(&heap, "block_");
        assert!(blocks.len() > 60, "heap {seed}: {} blocks", blocks.len());
        assert!(blocks.iter().all(|block| half_extents(block) == half_extents(blocks[0])));
        let tilts = blocks.iter().map(|block| {
            let (_, pitch, roll) = block.world_from_shape.rotation.to_euler(EulerRot::ZYX);
            pitch.abs().max(roll.abs())
        });
        let steepest = tilts.fold(0.0, f64::max);
        assert!((0.6..=0.7 + EPSILON).contains(&steepest), "heap {seed}: {steepest} rad");
        let heights = blocks.iter().map(|block| block.world_from_shape.translation.z);
        let (low, high) = heights.fold((f64::MAX, f64::MIN), |(l, h), z| (l.min(z), h.max(z)));
        assert!(low > -0.156 && high < 0.086 && high - low > 0.2, "heap {seed}: {low} to {high}");
        heaps.insert(format!("{:?}", blocks[0].world_from_shape));
    }
    assert_eq!(heaps.len(), 20);
}

#[test]
fn plates_leave_no_foothold_between_them() {
    let plates = world("hallway_plates");
    assert_has_all_of(&plates, &world("ibeam_hallway"), &["beam_"]);
    let [first, second] = ["plate_1", "plate_2"].map(|name| bounds(shape(&plates, name)));
    for (low, high) in [first, second] {
        assert_near(high.x - low.x, 0.01, "thickness");
        assert_near(high.z, 0.20, "height");
        assert_near(high.y - low.y, 2.0, "from wall to wall");
    }
    assert_near(second.0.x - first.0.x, 0.19, "distance");
}

#[test]
fn low_bars_stand_where_the_others_do() {
    let [low, high] = ["pass_under_low", "pass_under"].map(world);
    assert_has_all_of(&low, &high, &["bar_"]);
    for (low, high) in named(&low, "bar_").into_iter().zip(named(&high, "bar_")) {
        assert_eq!(low.shape, high.shape);
        assert_near(bounds(low).0.z, 1.05, "underside");
        assert_near(bounds(low).0.x, bounds(high).0.x, "position");
    }
}

/// Asserts that rails run 0.95 above a line along the walk and 0.38 aside, and a bar 1.50 above a
/// point of it.
fn check_clutter(world: &World, ends: [DVec3; 2], below_bar: DVec3) {
    for (name, y) in [("rail_left", 0.38), ("rail_right", -0.38)] {
        let rail = shape(world, name);
        let Shape::Cylinder { radius, half_length } = rail.shape else { panic!("a round rail") };
        assert_near(radius, RAIL_RADIUS, "radius");
        let tips = [-half_length, half_length].map(|z| rail.world_from_shape * (DVec3::Z * z));
        let expected = ends.map(|end| end + DVec3::new(0.0, y, 0.95));
        let error = tips.iter().zip(expected).map(|(tip, end)| tip.distance(end));
        assert!(error.fold(0.0, f64::max) < 1e-5, "{name}: {tips:?}, not {expected:?}");
    }
    let bar = shape(world, "bar_across").world_from_shape.translation;
    assert!((bar - below_bar - 1.5 * DVec3::Z).length() < EPSILON, "{bar}");
}

#[test]
fn clutter_surrounds_the_beam_and_the_stairs() {
    let [beam, stairs] = ["cluttered_beam", "cluttered_stairs"].map(world);
    assert_has_all_of(&beam, &world("beam"), &[]);
    let at = |x: f64, z: f64| DVec3::new(x, 0.0, z);
    check_clutter(&beam, [at(1.6, 0.0), at(3.6, 0.0)], at(2.6, 0.0));
    assert_has_all_of(&stairs, &world("stairs"), &[]);
    // Over the middle of a tread, 0.1 behind its nosing, the rail is 0.95 high.
    check_clutter(&stairs, [at(1.5, 0.11), at(2.5, 1.21)], at(2.0, 0.66));
}

#[test]
fn a_detour_leads_around_a_wall_on_a_bare_floor() {
    for half_length in [3.0, 4.0, 5.0, 6.0, 8.0, 11.0] {
        let world = world(&format!("detour_{half_length}"));
        let [(low, high), (floor, _)] = ["wall", "floor"].map(|name| bounds(shape(&world, name)));
        assert_near(high.x - low.x, 0.1, "thickness");
        assert_near(high.y - low.y, 2.0 * half_length, "length");
        assert_near(high.z, 2.0, "height");
        assert!(floor.truncate().max_element() == -12.0 && world.shapes.len() == 2);
    }
}

#[test]
fn the_hard_gym_is_built_of_the_harder_ways() {
    let gym = world("gym_hard");
    assert_has_all_of(
        &gym,
        &world("jungle_gym_full"),
        &["platform_north", "step_", "bar_", "slab_", "beam_", "ground_below"],
    );
    let top = |name: &str| bounds(shape(&gym, name)).1.z;
    for (index, step) in named(&gym, "step_").iter().enumerate() {
        assert_near(bounds(step).1.z, 0.26 * (index + 1) as f64, "rise of stairs_steep");
    }
    assert_near(top("platform_north_east"), 6.0 * 0.26, "six risers");
    assert_near(top("platform_north_west"), 7.0 * 0.28, "seven rises of spiral_high");
    let slab_top = |slab: &WorldShape| slab.world_from_shape.translation.z + half_extents(slab).z;
    for (index, slab) in named(&gym, "slab_").iter().enumerate() {
        assert_near(slab_top(slab), 0.28 * (index + 1) as f64, "rise of spiral_high");
    }
    let flange = bounds(shape(&gym, "beam_top_flange"));
    assert_near(flange.1.y - flange.0.y, 0.06, "flange of beam_narrow");
    let bars = named(&gym, "bar_");
    assert_eq!(bars.len(), named(&world("bars_uneven"), "bar_").len());
    let heights: Vec<f64> =
        bars.iter().map(|bar| bar.world_from_shape.translation.z + RAIL_RADIUS).collect();
    for (index, height) in heights.iter().enumerate() {
        let even = 1.56 + 0.40 * (index + 1) as f64 / 12.0;
        assert!((height - even).abs() <= 0.03 + EPSILON, "bar {index}: {height}");
    }
    let apart = bars.windows(2).map(|pair| {
        pair[0].world_from_shape.translation.x - pair[1].world_from_shape.translation.x
    });
    assert!(apart.clone().all(|apart| (0.16..=0.20).contains(&apart)));
    assert!(apart.into_iter().any(|apart| (apart - 0.18).abs() > 1e-3), "uneven");
}

#[test]
fn the_larger_soles_are_those_of_drc_hubo() {
    let [usual, large] = ["hubo", "hubo_large_sole"]
        .map(|name| load_robot(&configs("robots").join(name).join("robot.toml")).unwrap());
    for (foot, usual_foot) in large.feet.iter().zip(&usual.feet) {
        let extent = |axis: usize| {
            let along = foot.polygon.iter().map(|corner| corner[axis]);
            along.clone().fold(f64::MIN, f64::max) - along.fold(f64::MAX, f64::min)
        };
        assert_near(extent(0), 0.30, "length");
        assert_near(extent(1), 0.17, "width");
        assert_eq!(foot.link_from_sole, usual_foot.link_from_sole);
    }
    assert_eq!(large.links.len(), usual.links.len());
}
