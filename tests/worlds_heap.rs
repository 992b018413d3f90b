//! The cinder block heap is a heap: close, tilted, with no foothold shared by two blocks and no
//! even way across.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/sole_support.rs"]
mod sole_support;

use std::f64::consts::PI;
use std::sync::LazyLock;

use glam::{DVec2, DVec3, EulerRot, dvec2, dvec3};
use sole_support::{LONGEST_STEP, bounds, half_extents, hull, named, shape, world};
use surefoot_shared_types::Pose;

const EPSILON: f64 = 1e-6;
const HALF: DVec3 = dvec3(0.195, 0.095, 0.095);
/// Half the sole's length and width, m.
const SOLE_HALF: DVec2 = dvec2(0.11, 0.07);
/// The grid of soles tried on a block: step, m, and turn, rad. No sole's point is farther than
/// `SLACK` from a tried one's.
const GRID: (f64, f64) = (2.5e-3, 0.025);
const SLACK: f64 = 0.5 * GRID.0 * std::f64::consts::SQRT_2 + 0.13 * 0.5 * GRID.1;
/// A foot is this high, m: what stands less far over a block's top stands in its way.
const FOOT_HEIGHT: f64 = 0.10;

fn blocks() -> Vec<Pose> {
    named(&world("cinder_blocks"), "block_").iter().map(|block| block.world_from_shape).collect()
}

/// The eight corners of a block, each axis' sign one bit.
fn corners(world_from_block: &Pose) -> [DVec3; 8] {
    std::array::from_fn(|i| {
        let sign = |bit: usize| if i >> bit & 1 == 1 { 1.0 } else { -1.0 };
        *world_from_block * (HALF * dvec3(sign(0), sign(1), sign(2)))
    })
}

fn outline_from_above(block: &Pose) -> Vec<DVec2> {
    hull(corners(block).iter().map(|corner| corner.truncate()).collect())
}

/// The distance from a point to a counter-clockwise convex polygon, 0 inside.
fn distance(polygon: &[DVec2], point: DVec2) -> f64 {
    let sides = || polygon.iter().enumerate().map(|(i, &a)| (a, polygon[(i + 1) % polygon.len()]));
    if sides().all(|(a, b)| (b - a).perp_dot(point - a) >= 0.0) {
        return 0.0;
    }
    let to_side = |(a, b): (DVec2, DVec2)| {
        (a + (b - a) * ((point - a).dot(b - a) / (b - a).length_squared()).clamp(0.0, 1.0))
            .distance(point)
    };
    sides().map(to_side).fold(f64::MAX, f64::min)
}

/// The part of a flat polygon in space where `inside` is not negative.
fn cut(polygon: &[DVec3], inside: impl Fn(DVec3) -> f64) -> Vec<DVec3> {
    let mut kept = Vec::new();
    for (i, &a) in polygon.iter().enumerate() {
        let b = polygon[(i + 1) % polygon.len()];
        let (at_a, at_b) = (inside(a), inside(b));
        if at_a >= 0.0 {
            kept.push(a);
        }
        if at_a * at_b < 0.0 {
            kept.push(a + (b - a) * (at_a / (at_a - at_b)));
        }
    }
    kept
}

#[test]
fn pit_and_corridor_have_their_size() {
    let world = world("cinder_blocks");
    let [start, goal, pit] =
        ["floor_start", "floor_goal", "pit_floor"].map(|name| bounds(shape(&world, name)));
    assert!((goal.0.x - start.1.x - 2.4).abs() < EPSILON && (pit.1.z + 0.25).abs() < EPSILON);
    assert!((pit.0.x - start.1.x).abs() < EPSILON && (pit.1.x - goal.0.x).abs() < EPSILON);
    let [left, right] = ["wall_left", "wall_right"].map(|name| bounds(shape(&world, name)));
    assert!((left.0.y - right.1.y - 2.0).abs() < EPSILON);
    assert!(
        left.0.x <= start.0.x && left.1.x >= goal.1.x && left.1.z >= 2.0,
        "the walls go all the way"
    );
}

#[test]
fn blocks_are_tilted_within_their_ranges_and_head_everywhere() {
    let world = world("cinder_blocks");
    let (mut headings, mut steep) = ([0; 8], 0);
    for block in named(&world, "block_") {
        assert_eq!(half_extents(block), HALF);
        let (yaw, pitch, roll) = block.world_from_shape.rotation.to_euler(EulerRot::ZYX);
        assert!(
            roll.abs() <= 0.35 + EPSILON && pitch.abs() <= 0.35 + EPSILON,
            "'{}' is too steep",
            block.name
        );
        let centre = block.world_from_shape.translation;
        assert!(
            (centre.z + 0.095).abs() <= 0.06 + EPSILON,
            "'{}' lies too high or too low",
            block.name
        );
        assert!(
            (2.0..=4.4).contains(&centre.x) && centre.y.abs() <= 1.0,
            "'{}' lies outside the pit",
            block.name
        );
        headings[((yaw + PI) / (2.0 * PI) * 8.0).min(7.0) as usize] += 1;
        steep += usize::from(roll.abs().max(pitch.abs()) > 0.2);
    }
    assert!(headings.iter().all(|&count| count >= 3), "{headings:?}");
    assert!(2 * steep > headings.iter().sum::<usize>(), "only {steep} are tilted by more than 0.2");
}

#[test]
fn blocks_lie_as_close_as_a_heap_does() {
    let outlines: Vec<Vec<DVec2>> = blocks().iter().map(outline_from_above).collect();
    for i in 0..220 {
        for j in 0..200 {
            let point = dvec2(2.105 + 0.01 * f64::from(i), -0.995 + 0.01 * f64::from(j));
            let gap =
                outlines.iter().map(|outline| distance(outline, point)).fold(f64::MAX, f64::min);
            assert!(
                gap <= 0.025 + 0.5e-2 * std::f64::consts::SQRT_2,
                "nothing lies within {gap} of {point}"
            );
        }
    }
    for (i, one) in outlines.iter().enumerate() {
        let near = |other: &Vec<DVec2>| {
            one.iter()
                .map(|p| distance(other, *p))
                .chain(other.iter().map(|p| distance(one, *p)))
                .fold(f64::MAX, f64::min)
        };
        let neighbours =
            outlines.iter().enumerate().filter(|(j, other)| i != *j && near(other) <= 0.05);
        assert!(neighbours.count() >= 2, "block {} lies alone", i + 1);
    }
}

/// The least distance between two parallel lines about a polygon that lies in one plane.
fn width(polygon: &[DVec3]) -> f64 {
    let across = |i: usize| {
        let (a, b) = (polygon[i], polygon[(i + 1) % polygon.len()]);
        let along = (b - a).try_normalize()?;
        Some(
            polygon
                .iter()
                .map(|p| (*p - a).reject_from_normalized(along).length())
                .fold(0.0, f64::max),
        )
    };
    (0..polygon.len()).filter_map(across).fold(f64::MAX, f64::min)
}

#[test]
fn no_sole_that_lies_on_one_block_rests_on_another() {
    let blocks = blocks();
    for (i, below) in blocks.iter().enumerate() {
        let normal = below.rotation * DVec3::Z;
        let top = *below * dvec3(0.0, 0.0, HALF.z);
        let over = |point: DVec3| normal.dot(point - top);
        for (j, beside) in blocks
            .iter()
            .enumerate()
            .filter(|(j, beside)| i != *j && beside.translation.distance(below.translation) < 0.7)
        {
            let face = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)]
                .map(|(x, y)| *beside * (HALF * dvec3(x, y, 1.0)));
            let shared = cut(&cut(&face, |p| -over(p)), |p| over(p) + 3e-3);
            let carries = shared.len() >= 3 && width(&shared) >= 0.011;
            assert!(!carries, "a sole on block {} rests on block {}", i + 1, j + 1);
        }
    }
}

/// What of a block stands over another's top within a foot's height, seen along that top's normal,
/// in its frame.
fn obstacle(one: &Pose, other: &Pose) -> Vec<DVec2> {
    const FACES: [[usize; 4]; 6] =
        [[0, 1, 3, 2], [4, 6, 7, 5], [0, 4, 5, 1], [2, 3, 7, 6], [0, 2, 6, 4], [1, 5, 7, 3]];
    let corners = corners(other).map(|corner| one.inverse_transform_point(corner));
    let pieces = FACES.iter().flat_map(|face| {
        let outline = face.map(|i| corners[i]);
        cut(&cut(&outline, |p| p.z - HALF.z - 1e-3), |p| HALF.z + FOOT_HEIGHT - p.z)
    });
    hull(pieces.map(|point| point.truncate()).collect())
}

/// Whether a rectangle (centre, unit direction of its length, half sizes) and a convex polygon
/// overlap.
fn overlaps(centre: DVec2, along: DVec2, half: DVec2, polygon: &[DVec2]) -> bool {
    let local: Vec<DVec2> = polygon
        .iter()
        .map(|p| dvec2((*p - centre).dot(along), (*p - centre).dot(along.perp())))
        .collect();
    let beside = |pick: fn(&DVec2) -> f64, half: f64| {
        local.iter().all(|p| pick(p) >= half) || local.iter().all(|p| pick(p) <= -half)
    };
    if local.len() < 3 || beside(|p| p.x, half.x) || beside(|p| p.y, half.y) {
        return false;
    }
    let corners = [half, dvec2(-half.x, half.y), -half, dvec2(half.x, -half.y)];
    let sides = local.iter().enumerate().map(|(i, &a)| (a, local[(i + 1) % local.len()]));
    !sides.into_iter().any(|(a, b)| corners.iter().all(|c| (b - a).perp_dot(*c - a) <= 0.0))
}

/// A whole sole on a block's top.
#[derive(Debug, Clone, Copy)]
struct Foothold {
    centre: DVec3,
    /// Of the sole's length, modulo pi, rad.
    heading: f64,
}

/// All whole soles of a grid on a block, the sole made smaller by the grid's slack: where there is
/// none, no whole sole lies.
fn footholds(block: &Pose, obstacles: &[Vec<DVec2>]) -> Vec<Foothold> {
    let half = SOLE_HALF - DVec2::splat(SLACK);
    let mut found = Vec::new();
    for turn in (0..).map(|turn| GRID.1 * f64::from(turn)).take_while(|turn| *turn < PI) {
        let along = dvec2(libm::cos(turn), libm::sin(turn));
        let reach = dvec2(
            half.x * along.x.abs() + half.y * along.y.abs(),
            half.x * along.y.abs() + half.y * along.x.abs(),
        );
        let travel = (HALF.truncate() - reach) / GRID.0;
        let direction = block.rotation * along.extend(0.0);
        let heading = libm::atan2(direction.y, direction.x).rem_euclid(PI);
        let steps = |travel: f64| -(travel.floor() as i32)..=travel.floor() as i32;
        for (i, j) in steps(travel.x).flat_map(|i| steps(travel.y).map(move |j| (i, j))) {
            let centre = GRID.0 * dvec2(f64::from(i), f64::from(j));
            if !obstacles.iter().any(|polygon| overlaps(centre, along, half, polygon)) {
                found.push(Foothold { centre: *block * centre.extend(HALF.z), heading });
            }
        }
    }
    found
}

static FOOTHOLDS: LazyLock<Vec<Vec<Foothold>>> = LazyLock::new(|| {
    let blocks = blocks();
    let near = |one: &Pose| -> Vec<Vec<DVec2>> {
        let others = blocks
            .iter()
            .filter(|other| *other != one && other.translation.distance(one.translation) < 0.7);
        others.map(|other| obstacle(one, other)).filter(|polygon| polygon.len() >= 3).collect()
    };
    blocks.iter().map(|block| footholds(block, &near(block))).collect()
});

#[test]
fn a_third_of_the_tops_are_too_small_for_a_whole_sole() {
    let by_block = &*FOOTHOLDS;
    let without = by_block.iter().filter(|found| found.is_empty()).count();
    assert!(3 * without >= by_block.len(), "{without} of {}", by_block.len());
    assert!(without < by_block.len(), "there is something to stand on");
}

/// Whether footholds lead from floor to floor in steps that are not too long.
fn cross(footholds: &[DVec3]) -> bool {
    let mut reached: Vec<bool> = footholds.iter().map(|at| at.x - 2.0 <= LONGEST_STEP).collect();
    let mut open: Vec<usize> = (0..footholds.len()).filter(|&i| reached[i]).collect();
    while let Some(at) = open.pop() {
        if 4.4 - footholds[at].x <= LONGEST_STEP {
            return true;
        }
        for (next, reached) in reached.iter_mut().enumerate() {
            if !*reached && footholds[at].distance(footholds[next]) <= LONGEST_STEP {
                *reached = true;
                open.push(next);
            }
        }
    }
    false
}

#[test]
fn no_crossing_keeps_to_one_height_and_heading() {
    let turned = |a: f64, b: f64| (a - b + 0.5 * PI).rem_euclid(PI) - 0.5 * PI;
    let mut ways = Vec::new();
    for heading in (0..).map(|turn| GRID.1 * f64::from(turn)).take_while(|turn| *turn < PI) {
        // Whatever heading a crossing keeps to, a tried sole is within one step of the grid; the
        // same for heights, 1 mm for the slope.
        let alike: Vec<DVec3> = FOOTHOLDS
            .iter()
            .flatten()
            .filter(|f| turned(f.heading, heading).abs() <= GRID.1)
            .map(|f| f.centre)
            .collect();
        for height in (-40..40).map(|level| 5e-3 * f64::from(level)) {
            let even: Vec<DVec3> =
                alike.iter().copied().filter(|at| (at.z - height).abs() <= 2.5e-3 + 1e-3).collect();
            if cross(&even) {
                ways.push((heading, height));
            }
        }
    }
    assert!(ways.is_empty(), "{} ways of one height and heading: {ways:?}", ways.len());
    let one_each: Vec<DVec3> =
        FOOTHOLDS.iter().filter_map(|found| found.get(found.len() / 2)).map(|f| f.centre).collect();
    assert!(cross(&one_each), "with all heights and headings there is a way");
}
