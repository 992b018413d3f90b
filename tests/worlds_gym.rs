//! The jungle gyms keep every relation of their description, and each variant is the full one
//! without one of its ways.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/sole_support.rs"]
mod sole_support;

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3, dvec2, dvec3};
use sole_support::{
    LONGEST_STEP, SOLE_SIZE, bounds, clip, half_extents, heading, named, rests_wholly, shape,
    sole_at, top_face, world,
};
use surefoot_shared_types::Shape;
use surefoot_shared_types::base::spatial::wrap_angle;
use surefoot_shared_types::scenario::load::load_scenario;
use surefoot_shared_types::world::world::World;

const EPSILON: f64 = 3e-6;
const TOP: f64 = 1.32;
const GYMS: [&str; 3] = ["jungle_gym_full", "jungle_gym_spiral_route", "jungle_gym_stair_route"];

fn assert_near(actual: f64, expected: f64, what: &str) {
    assert!((actual - expected).abs() < EPSILON, "{what}: {actual}, not {expected}");
}

/// Lower and upper corners of the platforms: south-east, south-west, north-east, north-west.
fn platforms(world: &World) -> [(DVec3, DVec3); 4] {
    ["south_east", "south_west", "north_east", "north_west"]
        .map(|corner| bounds(shape(world, &format!("platform_{corner}"))))
}

#[test]
fn four_platforms_stand_at_two_heights() {
    for name in GYMS {
        let world = world(name);
        let platforms = platforms(&world);
        for ((low, high), top) in platforms.into_iter().zip([0.0, 0.0, TOP, TOP]) {
            assert_near(high.x - low.x, 1.6, "platform length");
            assert_near(high.y - low.y, 1.6, "platform width");
            assert_near(high.z, top, "platform top");
        }
        let [south_east, south_west, north_east, north_west] = platforms;
        assert_near(south_east.0.x - south_west.1.x, 2.0, "the beam's span");
        assert_near(north_east.0.x - north_west.1.x, 2.0, "the bars' span");
        assert_near(bounds(shape(&world, "ground")).1.z, -0.8, "the void's depth");
        assert_eq!(
            (south_east.0.x, south_west.0.x),
            (north_east.0.x, north_west.0.x),
            "the platforms make a rectangle"
        );
    }
}

#[test]
fn each_variant_lacks_one_way_and_only_that() {
    let full = world("jungle_gym_full");
    for (name, missing, count) in [
        ("jungle_gym_spiral_route", ["bar_", "ground_below_bars"], 13),
        ("jungle_gym_stair_route", ["beam_", "beam_"], 3),
    ] {
        let variant = world(name);
        assert_eq!(variant.shapes.len() + count, full.shapes.len());
        for shape in &full.shapes {
            let is_missing = missing.iter().any(|prefix| shape.name.starts_with(prefix));
            let kept = variant.shapes.iter().find(|other| other.name == shape.name);
            assert_eq!(kept.is_none(), is_missing, "{name}: '{}'", shape.name);
            assert!(
                kept.is_none_or(|kept| kept.shape == shape.shape
                    && kept.world_from_shape == shape.world_from_shape)
            );
        }
    }
}

#[test]
fn stairs_climb_from_south_east_to_north_east() {
    let world = world("jungle_gym_full");
    let [south_east, _, north_east, _] = platforms(&world);
    let (mut front, mut height) = (south_east.1.y, 0.0);
    let steps = named(&world, "step_");
    assert_eq!(steps.len(), 5, "the platform is the sixth");
    for step in steps {
        let (low, high) = bounds(step);
        assert_near(high.z - height, 0.22, "rise");
        assert_near(high.y - low.y, 0.20, "tread");
        assert_near(low.y, front, "steps touch");
        assert_near(high.x - low.x, 1.2, "width");
        assert!(low.x > south_east.0.x && high.x < south_east.1.x, "open sides");
        (front, height) = (high.y, high.z);
    }
    assert_near(north_east.0.y, front, "the platform follows the last step");
    assert_near(north_east.1.z - height, 0.22, "the last rise");
}

#[test]
fn bars_lie_from_north_east_to_north_west() {
    let world = world("jungle_gym_full");
    let [_, _, north_east, north_west] = platforms(&world);
    let bars = named(&world, "bar_");
    assert_eq!(bars.len(), 12);
    for bar in &bars {
        assert_eq!(bar.shape, Shape::Cylinder { radius: 0.02, half_length: 0.6 });
        assert_near(
            (bar.world_from_shape.rotation * DVec3::Z).y.abs(),
            1.0,
            "a bar lies across the walk",
        );
        let centre = bar.world_from_shape.translation;
        assert_near(centre.z + 0.02, TOP, "its top is level with the platforms");
        assert_near(centre.y, 0.5 * (north_east.0.y + north_east.1.y), "in the platforms' middle");
    }
    let xs: Vec<f64> = bars.iter().map(|bar| bar.world_from_shape.translation.x).collect();
    assert!(xs.windows(2).all(|pair| (pair[1] - pair[0] - 0.16).abs() < EPSILON));
    assert_near(xs[0] - north_west.1.x, north_east.0.x - xs[11], "both ends are alike");
    assert_near(bounds(shape(&world, "ground_below_bars")).1.z, TOP - 1.0, "above their ground");
}

#[test]
fn beam_lies_from_south_east_to_south_west() {
    let world = world("jungle_gym_full");
    let [south_east, south_west, ..] = platforms(&world);
    let [bottom, web, top] = ["bottom_flange", "web", "top_flange"]
        .map(|part| bounds(shape(&world, &format!("beam_{part}"))));
    assert_near(top.1.z, 0.0, "level with the platforms");
    assert_near(top.1.z - bottom.0.z, 0.20, "height");
    assert_near(top.1.y - top.0.y, 0.12, "flange width");
    assert!(top.1.y - top.0.y < 2.0 * SOLE_SIZE.y, "two soles do not fit");
    assert_near(web.1.y - web.0.y, 0.015, "web thickness");
    assert_near(top.0.x, south_west.1.x, "meets the western platform");
    assert_near(top.1.x, south_east.0.x, "meets the eastern platform");
}

#[test]
fn spiral_winds_from_south_west_to_north_west() {
    let world = world("jungle_gym_full");
    let slabs = named(&world, "slab_");
    assert_eq!(slabs.len(), 6);
    let axis = (0.5
        * (slabs[0].world_from_shape.translation + slabs[5].world_from_shape.translation))
        .truncate();
    let axis = axis + dvec2(0.70 * libm::cos(1.375), 0.0);
    for (index, slab) in slabs.iter().enumerate() {
        let centre = slab.world_from_shape.translation;
        assert_eq!(half_extents(slab), dvec3(0.25, 0.13, 0.025));
        assert_near((centre.truncate() - axis).length(), 0.70, "radius");
        assert_near(centre.z + 0.025, TOP * (index + 1) as f64 / 7.0, "height");
        let outward = centre.truncate() - axis;
        assert_near(
            wrap_angle(libm::atan2(outward.y, outward.x) - heading(slab)),
            0.0,
            "the long side points outward",
        );
        assert_near(
            wrap_angle(heading(slab) - PI),
            (2.5 - index as f64) * 0.55,
            "angle between slabs",
        );
    }
}

/// The corners of a slab seen from above, counter-clockwise.
fn outline(world: &World, slab: &str) -> Vec<DVec2> {
    top_face(shape(world, slab)).unwrap().1
}

#[test]
fn spiral_begins_and_ends_a_whole_step_from_the_platforms() {
    let world = world("jungle_gym_full");
    let [_, south_west, _, north_west] = platforms(&world);
    for (slab, (low, high)) in [("slab_1", south_west), ("slab_6", north_west)] {
        let platform = [
            dvec2(low.x, low.y),
            dvec2(high.x, low.y),
            dvec2(high.x, high.y),
            dvec2(low.x, high.y),
        ];
        assert!(clip(&outline(&world, slab), &platform).is_empty(), "{slab} lies over a platform");
        let centre = shape(&world, slab).world_from_shape.translation;
        let along = heading(shape(&world, slab)) - FRAC_PI_2;
        // The nearest sole wholly on the platform, turned as on the slab.
        let nearest = (0..200).map(|step| low.x + 0.005 * f64::from(step)).find(|x| {
            let pose =
                sole_at(dvec3(*x, centre.y.clamp(low.y + 0.15, high.y - 0.15), high.z), along);
            rests_wholly(&world, &pose)
        });
        let reach = nearest.unwrap() - centre.x;
        assert!((0.26..LONGEST_STEP).contains(&reach), "{slab}: {reach} from the platform");
    }
}

#[test]
fn spiral_slabs_leave_six_centimetres_along_the_walk() {
    let world = world("jungle_gym_full");
    for slab in named(&world, "slab_") {
        let along = heading(slab) - FRAC_PI_2;
        let pose = sole_at(slab.world_from_shape.translation + dvec3(0.0, 0.0, 0.025), along);
        let placed = |shift: f64| sole_at(pose * dvec3(shift - 0.02, 0.0, 0.0), along);
        assert!(rests_wholly(&world, &placed(0.0)));
        assert!(!rests_wholly(&world, &placed(0.061)) && !rests_wholly(&world, &placed(-0.061)));
    }
}

#[test]
fn there_is_no_short_cut_between_the_ways() {
    let world = world("jungle_gym_full");
    let groups = [&["step_", "platform_north_east"][..], &["bar_"], &["beam_"], &["slab_"]];
    let centres = |prefixes: &[&str]| -> Vec<DVec3> {
        prefixes
            .iter()
            .flat_map(|prefix| named(&world, prefix))
            .map(|shape| shape.world_from_shape.translation)
            .collect()
    };
    for slab in centres(groups[3]) {
        let nearest = |others: &[&str]| {
            centres(others)
                .iter()
                .map(|at| at.truncate().distance(slab.truncate()))
                .fold(f64::MAX, f64::min)
        };
        assert!(
            nearest(groups[0]) > 2.0 * LONGEST_STEP
                && nearest(groups[1]) > LONGEST_STEP
                && nearest(groups[2]) > LONGEST_STEP
        );
    }
    let [south_east, south_west, north_east, north_west] = platforms(&world);
    assert!(
        south_east.0.x - south_west.1.x - SOLE_SIZE.x > LONGEST_STEP
            && north_east.0.x - north_west.1.x - SOLE_SIZE.x > LONGEST_STEP
    );
    assert!(
        north_west.1.z - south_west.1.z > LONGEST_STEP,
        "nobody steps up from platform to platform"
    );
}

#[test]
fn start_and_goal_are_opposite_corners() {
    for name in GYMS {
        let scenario =
            load_scenario(&sole_support::configs("scenarios").join(format!("{name}.toml")))
                .unwrap();
        let [south_east, _, _, north_west] = platforms(&world(name));
        let middle = |(low, high): (DVec3, DVec3)| (0.5 * (low + high)).with_z(high.z);
        assert!((scenario.start.position - middle(south_east)).length() < EPSILON);
        assert!((scenario.goal.position - middle(north_west)).length() < EPSILON);
        let way = scenario.goal.position - scenario.start.position;
        assert!(
            wrap_angle(libm::atan2(way.y, way.x) - scenario.start.yaw).abs() < 1e-3,
            "{name}: the robot faces the goal"
        );
    }
}
