//! The further worlds (stairs, beam, bars, spiral, checkers, bars overhead, hopeless ones) are what
//! they claim to be.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/sole_support.rs"]
mod sole_support;

use glam::{DVec2, DVec3, dvec2, dvec3};
use sole_support::{
    LONGEST_STEP, SOLE, SOLE_SIZE, area, bounds, half_extents, heading, hull, named, rests_wholly,
    shape, sole_at, world,
};
use surefoot_shared_types::Shape;
use surefoot_shared_types::base::spatial::wrap_angle;
use surefoot_shared_types::world::world::World;

const EPSILON: f64 = 1e-6;

fn assert_near(actual: f64, expected: f64, what: &str) {
    assert!((actual - expected).abs() < EPSILON, "{what}: {actual}, not {expected}");
}

/// Solid steps one behind the other, then a landing one rise (or none) above the last.
fn check_flight(world: &World, rise: f64, tread: f64, width: f64, landing: &str) -> f64 {
    let mut height = 0.0;
    let mut front = None;
    for step in named(world, "step_") {
        let (low, high) = bounds(step);
        assert_near(high.z - height, rise, "rise");
        assert_near(high.x - low.x, tread, "tread");
        assert_near(high.y - low.y, width, "width");
        assert_near(low.z, 0.0, "a step is solid down to the floor");
        assert_near(low.x, front.unwrap_or(low.x), "steps touch");
        (height, front) = (high.z, Some(high.x));
    }
    let (low, high) = bounds(shape(world, landing));
    assert_near(low.x, front.unwrap(), "the landing follows the last step");
    assert_near(high.y - low.y, width, "landing width");
    high.z
}

#[test]
fn stairs_bauzil_climbs_six_low_steps() {
    let world = world("stairs_bauzil");
    assert_eq!(named(&world, "step_").len(), 6);
    assert_near(check_flight(&world, 0.10, 0.30, 1.0, "landing"), 0.60, "landing height");
}

#[test]
fn stairs_climbs_six_steep_risers() {
    let world = world("stairs");
    assert_eq!(named(&world, "step_").len(), 5, "the platform is the sixth");
    assert_near(check_flight(&world, 0.22, 0.20, 1.2, "platform"), 6.0 * 0.22, "platform height");
    let (low, high) = bounds(shape(&world, "platform"));
    assert_near(high.x - low.x, 1.5, "platform length");
}

#[test]
fn beam_is_too_narrow_for_two_soles_side_by_side() {
    let world = world("beam");
    let flange = bounds(shape(&world, "beam_top_flange"));
    assert_near(flange.1.y - flange.0.y, 0.12, "flange width");
    assert!(flange.1.y - flange.0.y < 2.0 * SOLE_SIZE.y);
    assert_near(flange.1.x - flange.0.x, 2.0, "beam length");
    assert_near(flange.1.z, 0.0, "level with the platforms");
    assert_near(bounds(shape(&world, "ground")).1.z, -0.8, "above the ground");
    assert_near(bounds(shape(&world, "floor_start")).1.x, flange.0.x, "meets the first platform");
    assert_near(bounds(shape(&world, "floor_goal")).0.x, flange.1.x, "meets the second platform");
}

/// The centres along x of a row of round bars.
fn bar_centres(world: &World) -> Vec<f64> {
    named(world, "bar_").iter().map(|bar| bar.world_from_shape.translation.x).collect()
}

/// The bars that a sole at `x`, facing along the walk, rests on.
fn bars_under(centres: &[f64], x: f64) -> Vec<f64> {
    centres.iter().copied().filter(|centre| (x - 0.09..=x + 0.13).contains(centre)).collect()
}

#[test]
fn monkey_bars_span_two_metres_in_twelve_bars() {
    let world = world("monkey_bars");
    let centres = bar_centres(&world);
    assert_eq!(centres.len(), 12);
    assert!(centres.windows(2).all(|pair| (pair[1] - pair[0] - 0.16).abs() < EPSILON));
    for bar in named(&world, "bar_") {
        assert_eq!(bar.shape, Shape::Cylinder { radius: 0.02, half_length: 0.6 });
        assert_near(
            (bar.world_from_shape.rotation * DVec3::Z).y.abs(),
            1.0,
            "a bar lies across the walk",
        );
        assert_near(
            bar.world_from_shape.translation.z,
            -0.02,
            "its top is level with the platforms",
        );
    }
    assert_near(
        bounds(shape(&world, "floor_goal")).0.x - bounds(shape(&world, "floor_start")).1.x,
        2.0,
        "span",
    );
    assert_near(bounds(shape(&world, "ground")).1.z, -1.0, "above the ground");
}

#[test]
fn monkey_bars_carry_a_sole_on_two_bars_at_most() {
    let world = world("monkey_bars");
    let centres = bar_centres(&world);
    for step in 0..1500 {
        let bars = bars_under(&centres, 1.8 + 1e-3 * f64::from(step));
        assert!(bars.len() <= 2);
        let ends: Vec<DVec2> =
            bars.iter().flat_map(|&x| [dvec2(x, -0.07), dvec2(x, 0.07)]).collect();
        assert!(
            ends.is_empty() || area(&hull(ends)) <= 0.75 * area(&SOLE),
            "two bars carry too much"
        );
    }
    let centred = 0.5 * (centres[4] + centres[5]) - 0.02;
    assert_eq!(bars_under(&centres, centred).len(), 2);
    for shift in [-0.031, 0.031] {
        assert_eq!(bars_under(&centres, centred + shift).len(), 1, "shifted by {shift}");
    }
}

#[test]
fn spiral_steps_wind_up_in_seven_equal_rises() {
    let world = world("spiral_steps");
    let slabs = named(&world, "slab_");
    assert_eq!(slabs.len(), 6);
    for (index, slab) in slabs.iter().enumerate() {
        let centre = slab.world_from_shape.translation;
        assert_eq!(half_extents(slab), dvec3(0.25, 0.13, 0.025));
        assert_near(centre.truncate().length(), 0.70, "radius");
        assert_near(centre.z + 0.025, 1.32 * (index + 1) as f64 / 7.0, "height");
        let outward = libm::atan2(centre.y, centre.x);
        assert_near(wrap_angle(outward - heading(slab)), 0.0, "the long side points outward");
        let before =
            index.checked_sub(1).map_or(-std::f64::consts::FRAC_PI_2, |at| heading(slabs[at]));
        assert_near(wrap_angle(heading(slab) - before), 0.55, "angle between slabs");
    }
    let platform = shape(&world, "platform");
    assert_near(
        platform.world_from_shape.translation.z + half_extents(platform).z,
        1.32,
        "platform height",
    );
}

#[test]
fn spiral_steps_leave_six_centimetres_along_the_walk() {
    let world = world("spiral_steps");
    for slab in named(&world, "slab_") {
        let along = heading(slab) + std::f64::consts::FRAC_PI_2;
        let pose = sole_at(slab.world_from_shape.translation + dvec3(0.0, 0.0, 0.025), along);
        let placed = |shift: f64| sole_at(pose * dvec3(shift - 0.02, 0.0, 0.0), along);
        assert!(rests_wholly(&world, &placed(0.0)));
        assert!(!rests_wholly(&world, &placed(0.061)) && !rests_wholly(&world, &placed(-0.061)));
    }
}

#[test]
fn checkers_misses_every_other_square() {
    let world = world("checkers");
    let tiles = named(&world, "tile_");
    let corners: Vec<(DVec3, DVec3)> = tiles.iter().map(|tile| bounds(tile)).collect();
    for (low, high) in &corners {
        assert_near(high.x - low.x, 0.26, "tile length");
        assert_near(high.y - low.y, 0.26, "tile width");
        assert_near(high.z, 0.0, "tile top");
        let beside = corners
            .iter()
            .filter(|(other, _)| (*other - *low).truncate().length() < 0.26 + EPSILON);
        assert_eq!(beside.count(), 1, "a tile touches its neighbours at corners only");
    }
    let extent = |pick: fn(&DVec3) -> f64| {
        let high = corners.iter().map(|(_, high)| pick(high)).fold(f64::MIN, f64::max);
        high - corners.iter().map(|(low, _)| pick(low)).fold(f64::MAX, f64::min)
    };
    assert_near(extent(|corner| corner.y), 1.3, "width");
    assert!((2.86 - EPSILON..=3.0).contains(&extent(|corner| corner.x)));
    assert_near(
        bounds(shape(&world, "floor_goal")).0.x - bounds(shape(&world, "floor_start")).1.x,
        3.0,
        "gap",
    );
}

#[test]
fn pass_under_is_lower_than_the_robot() {
    let world = world("pass_under");
    for (bar, (x, underside)) in
        named(&world, "bar_").into_iter().zip([(1.4, 1.30), (2.0, 1.20), (2.6, 1.30)])
    {
        let (low, high) = bounds(bar);
        assert_near(0.5 * (low.x + high.x), x, "bar position");
        assert_near(low.z, underside, "underside");
        assert_near(high.z - low.z, 0.05, "bar height");
        assert_near(high.x - low.x, 0.05, "bar depth");
        assert_near(high.y - low.y, 2.0, "from wall to wall");
    }
    assert_eq!(named(&world, "bar_").len(), 3);
    assert_eq!(named(&world, "wall").len(), 4);
}

#[test]
fn rough_ground_has_hardly_two_triangles_in_one_plane() {
    let world = world("rough_ground");
    let Shape::Mesh { vertices, triangles, .. } = &shape(&world, "ground").shape else {
        panic!("not a mesh")
    };
    let is_level_end = |v: &DVec3| !(0.5..=4.5).contains(&v.x);
    assert!(vertices.iter().filter(|v| is_level_end(v)).all(|v| v.z == 0.0));
    let heights = vertices.iter().map(|v| v.z);
    let (lowest, highest) = heights.fold((0f64, 0f64), |(low, high), z| (low.min(z), high.max(z)));
    assert!(lowest < -0.1 && highest > 0.1, "from {lowest} to {highest}");
    let corners = |triangle: &[u32; 3]| triangle.map(|index| vertices[index as usize]);
    let normal = |triangle: &[u32; 3]| {
        let [a, b, c] = corners(triangle);
        (b - a).cross(c - a).normalize()
    };
    let is_rough =
        |pair: &&[[u32; 3]]| pair.iter().flat_map(corners).all(|v| (1.0..=4.0).contains(&v.x));
    let halves = || triangles.as_chunks::<2>().0.iter().map(|pair| &pair[..]).filter(is_rough);
    let bent = halves()
        .filter(|pair| normal(&pair[0]).dot(normal(&pair[1])) < libm::cos(0.2f64.to_radians()));
    assert!(10 * bent.count() > 9 * halves().count(), "the two halves of a square");
    assert!(
        triangles.iter().all(|triangle| normal(triangle).z > libm::cos(25f64.to_radians())),
        "friction holds everywhere"
    );
}

#[test]
fn no_way_slope_is_beyond_friction() {
    let world = world("no_way_slope");
    let slope = shape(&world, "slope");
    let normal = slope.world_from_shape.rotation * DVec3::Z;
    let tilt = libm::acos(normal.z);
    let checker = surefoot_shared_types::config::CheckerConfig::default();
    assert!(
        tilt > libm::atan(world.mu) + checker.contact_tilt_max,
        "even a sole tilted to the limit slips"
    );
    let half = half_extents(slope);
    let end = |side: f64| slope.world_from_shape * dvec3(side * half.x, 0.0, half.z);
    assert!((end(-1.0) - dvec3(2.0, 0.0, 0.0)).length() < 1e-5, "begins at the floor's end");
    let platform = bounds(shape(&world, "platform"));
    assert!(
        (end(1.0) - dvec3(platform.0.x, 0.0, platform.1.z)).length() < 1e-5,
        "ends at the platform's edge"
    );
    assert!(platform.0.x - 2.0 - SOLE_SIZE.x > LONGEST_STEP);
}

#[test]
fn no_way_ceiling_is_too_low_for_too_long() {
    let world = world("no_way_ceiling");
    let [ceiling, left, right, floor] =
        ["ceiling", "wall_left", "wall_right", "floor"].map(|name| bounds(shape(&world, name)));
    assert_near(ceiling.0.z - floor.1.z, 0.35, "headroom");
    assert!(ceiling.0.z - floor.1.z < 0.12 + 0.33, "lower than a knee above an upright shank");
    assert!(ceiling.1.z >= 2.0, "nobody climbs over");
    assert!(ceiling.1.x - ceiling.0.x - SOLE_SIZE.x > LONGEST_STEP);
    assert_near(ceiling.1.y, left.0.y, "meets the left wall");
    assert_near(ceiling.0.y, right.1.y, "meets the right wall");
}
