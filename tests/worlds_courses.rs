//! The long courses (SL1M's, the gauntlets) are put together from what they claim to be.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/sole_support.rs"]
mod sole_support;

use std::f64::consts::PI;

use glam::{DVec3, dvec3};
use sole_support::{
    LONGEST_STEP, SOLE_SIZE, bounds, half_extents, heading, named, rests_wholly, shape, sole_at,
    world,
};
use surefoot_shared_types::base::spatial::wrap_angle;
use surefoot_shared_types::world::world::{World, WorldShape};

const EPSILON: f64 = 2e-6;

fn assert_near(actual: f64, expected: f64, what: &str) {
    assert!((actual - expected).abs() < EPSILON, "{what}: {actual}, not {expected}");
}

#[test]
fn sl1m_tiles_alternate_left_and_right_tilted_to_fifteen_degrees() {
    let world = world("sl1m_complex");
    let tiles = named(&world, "tile_");
    assert_eq!(tiles.len(), 8);
    let mut tilts = Vec::new();
    for (index, tile) in tiles.iter().enumerate() {
        let half = half_extents(tile);
        assert_near(2.0 * half.x, 0.34, "tile length");
        assert_near(2.0 * half.y, 0.33, "tile width");
        let top = tile.world_from_shape * dvec3(0.0, 0.0, half.z);
        assert!((0.05..=0.20).contains(&top.z), "'{}' is {} high", tile.name, top.z);
        let normal = tile.world_from_shape.rotation * DVec3::Z;
        let side = if index % 2 == 0 { 1.0 } else { -1.0 };
        assert_near(top.y, side * 0.165, "left and right in turn");
        assert!(-normal.y * side >= 0.0, "'{}' is tilted to the other side", tile.name);
        assert!(
            normal.z >= libm::cos(15f64.to_radians()) - EPSILON,
            "'{}' is too steep",
            tile.name
        );
        tilts.push(libm::acos(normal.z).to_degrees());
    }
    assert!(
        tilts.iter().any(|&tilt| tilt > 8.0) && tilts.iter().any(|&tilt| tilt < 8.0),
        "{tilts:?}"
    );
    let [start, middle] = ["floor_start", "floor_middle"].map(|name| bounds(shape(&world, name)));
    assert!(
        middle.0.x - start.1.x - SOLE_SIZE.x > LONGEST_STEP,
        "the rubble cannot be stepped over"
    );
}

#[test]
fn sl1m_steps_lead_to_a_bridge_and_a_platform() {
    let world = world("sl1m_complex");
    let steps = named(&world, "step_");
    assert_eq!(steps.len(), 6);
    for (index, step) in steps.iter().enumerate() {
        let (low, high) = bounds(step);
        assert_near(high.z, 0.10 * (index + 1) as f64, "rise");
        assert_near(high.x - low.x, 0.30, "tread");
        assert_near(high.y - low.y, 1.0, "width");
    }
    let [bridge, platform] = ["bridge", "platform"].map(|name| bounds(shape(&world, name)));
    assert_near(bridge.1.x - bridge.0.x, 3.0, "bridge length");
    assert_near(bridge.1.y - bridge.0.y, 0.30, "bridge width");
    assert_near(bridge.1.z, 0.60, "bridge height");
    assert_near(bridge.0.x, bounds(steps[5]).1.x, "the bridge follows the last step");
    assert_near(platform.0.x, bridge.1.x, "the platform follows the bridge");
    assert_near(platform.1.x - platform.0.x, 1.0, "platform length");
    assert_near(platform.1.z, 0.60, "platform height");
}

/// The shapes of one copy, by what follows its prefix.
fn copy(world: &World, number: usize) -> Vec<(&str, &WorldShape)> {
    let prefix = format!("c{number}_");
    named(world, &prefix).into_iter().map(|shape| (&shape.name[prefix.len()..], shape)).collect()
}

#[test]
fn gauntlets_are_copies_end_to_end() {
    let one = world("gauntlet_1");
    let first = copy(&one, 1);
    assert_eq!(first.len() + 1, one.shapes.len());
    let ends = ["floor_end", "floor_start"].map(|name| shape(&one, &format!("c1_{name}")));
    let stride = bounds(shape(&one, "c_floor_goal")).0.with_y(0.0).with_z(0.0);
    assert_near(bounds(ends[0]).1.x, stride.x, "a copy ends where the next begins");
    for copies in [2, 4, 8] {
        let world = world(&format!("gauntlet_{copies}"));
        assert_eq!(world.shapes.len(), copies * first.len() + 1);
        let mut before: Option<DVec3> = None;
        for number in 1..=copies {
            let shapes = copy(&world, number);
            let offset =
                shapes[0].1.world_from_shape.translation - first[0].1.world_from_shape.translation;
            assert_near(offset.x, stride.x * (number - 1) as f64, "copies follow each other");
            assert_near(offset.z, 0.0, "copies are level");
            for ((name, shape), (first_name, first_shape)) in shapes.iter().zip(&first) {
                assert_eq!((name, &shape.shape), (first_name, &first_shape.shape));
                let moved =
                    shape.world_from_shape.translation - first_shape.world_from_shape.translation;
                assert!((moved - offset).length() < EPSILON, "'{}' is elsewhere", shape.name);
                assert_eq!(shape.world_from_shape.rotation, first_shape.world_from_shape.rotation);
            }
            if let Some(end) = before {
                let start = bounds(shape(&world, &format!("c{number}_floor_start")));
                assert!(
                    end.y > start.0.y + 0.3
                        && end.y < start.1.y
                        && (end.x - start.0.x).abs() < EPSILON,
                    "copy {number} is not reached"
                );
            }
            before = Some(bounds(shape(&world, &format!("c{number}_floor_end"))).1);
        }
    }
}

#[test]
fn a_gauntlet_holds_the_trench_and_the_stones() {
    let (gauntlet, gap, stones) =
        (world("gauntlet_1"), world("ibeam_gap"), world("stepping_stones"));
    let parts = [(&gap, "beam_", -1.0), (&gap, "post_", -1.0), (&stones, "stone_", 1.0)];
    for (original, prefix, shift) in parts {
        for part in named(original, prefix) {
            let here = shape(&gauntlet, &format!("c1_{}", part.name));
            assert_eq!(here.shape, part.shape);
            let expected = part.world_from_shape.translation + dvec3(shift, 0.0, 0.0);
            assert!(
                (here.world_from_shape.translation - expected).length() < EPSILON,
                "'{}' is elsewhere",
                here.name
            );
        }
    }
    let floors = ["floor_start", "floor_middle", "floor_spiral"]
        .map(|name| bounds(shape(&gauntlet, &format!("c1_{name}"))));
    assert_near(floors[1].0.x - floors[0].1.x, 1.0, "trench");
    assert_near(floors[2].0.x - floors[1].1.x, 3.0, "gap");
}

#[test]
fn a_gauntlets_spirals_are_the_same_up_and_down() {
    let (gauntlet, spiral) = (world("gauntlet_1"), world("spiral_steps"));
    let axis = dvec3(8.0, 0.7, 0.0);
    let middle = shape(&gauntlet, "c1_platform").world_from_shape.translation.with_z(0.0);
    for number in 1..=6 {
        let original = shape(&spiral, &format!("slab_{number}"));
        let [up, down] =
            ["up", "down"].map(|way| shape(&gauntlet, &format!("c1_slab_{way}_{number}")));
        assert_eq!((&up.shape, &down.shape), (&original.shape, &original.shape));
        let place = axis + original.world_from_shape.translation;
        assert!((up.world_from_shape.translation - place).length() < EPSILON);
        let turned = (2.0 * middle - place).with_z(place.z);
        assert!((down.world_from_shape.translation - turned).length() < EPSILON);
        assert!(wrap_angle(heading(up) - heading(original)).abs() < EPSILON);
        assert!(wrap_angle(heading(down) - heading(original) - PI).abs() < EPSILON);
    }
    let end = bounds(shape(&gauntlet, "c1_floor_end"));
    let landing = (2.0 * middle - dvec3(8.0, 0.0, 0.0)).with_z(0.0);
    assert!(
        rests_wholly(&gauntlet, &sole_at(landing - dvec3(0.02, 0.0, 0.0), 0.0)),
        "the way down ends on the floor"
    );
    assert!(
        named(&gauntlet, "c1_slab_up").iter().all(|slab| {
            let centre = slab.world_from_shape.translation;
            centre.y + 0.29 < end.0.y || centre.x + 0.29 < end.0.x || centre.x - 0.29 > end.1.x
        }),
        "no slab stands on the floor beside it"
    );
}
