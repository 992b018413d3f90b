//! The worlds of the first walk are what their description says, so that none is easier than it
//! claims to be.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/sole_support.rs"]
mod sole_support;

use std::path::Path;

use glam::{DVec3, dvec3};
use sole_support::{
    LONGEST_STEP, SOLE_SIZE, bounds, contacts, half_extents, named, rests_wholly, shape, sole_at,
    support_area, top_face, world,
};
use surefoot_shared_types::scenario::load::load_scenario;
use surefoot_shared_types::world::load::load_world;
use surefoot_shared_types::world::world::World;

const EPSILON: f64 = 1e-9;

fn assert_near(actual: f64, expected: f64, what: &str) {
    assert!((actual - expected).abs() < EPSILON, "{what}: {actual}, not {expected}");
}

fn files(folder: &str) -> Vec<std::path::PathBuf> {
    let entries = std::fs::read_dir(sole_support::configs(folder))
        .unwrap()
        .map(|entry| entry.unwrap().path());
    let mut files: Vec<_> = entries
        .filter(|path| path.extension().is_some_and(|extension| extension == "toml"))
        .collect();
    files.sort();
    files
}

#[test]
fn every_world_loads_with_one_friction_and_thick_floors() {
    let files = files("worlds");
    assert!(files.len() >= 6);
    for path in files {
        let world = load_world(&path).unwrap();
        assert_near(world.mu, 0.6, "mu");
        for floor in named(&world, "floor") {
            assert_near(half_extents(floor).z, 0.25, &floor.name);
            assert_near(bounds(floor).1.z, 0.0, &floor.name);
        }
    }
}

#[test]
fn every_start_and_goal_has_both_soles_wholly_on_the_ground() {
    let files = files("scenarios");
    assert!(files.len() >= 6);
    for path in files {
        let scenario = load_scenario(&path).unwrap();
        let world = load_world(&scenario.world_path).unwrap();
        // A scenario is named after its world, or after the folder of several.
        let (stem, folder) = (scenario.world_path.with_extension(""), scenario.world_path.parent());
        let names = [Some(stem.as_path()), folder].map(|path| path.and_then(Path::file_name));
        assert!(names.contains(&Some(scenario.name.as_ref())), "{}", scenario.name);
        assert_eq!(scenario.seed, 1);
        assert_near(scenario.goal_tolerance.position, 0.10, "position tolerance");
        assert_near(scenario.goal_tolerance.yaw, 0.35, "yaw tolerance");
        for stance in [scenario.start, scenario.goal] {
            assert_near(stance.stance_width, 0.2, "stance width");
            for sole in stance.world_from_soles() {
                assert!(
                    rests_wholly(&world, &sole),
                    "{}: a sole hangs over at {}",
                    scenario.name,
                    sole.translation
                );
            }
        }
    }
}

#[test]
fn flat_walk_is_ten_metres_of_floor() {
    let world = world("flat_walk");
    assert_eq!(world.shapes.len(), 1);
    let (low, high) = bounds(&world.shapes[0]);
    assert_near(high.x - low.x, 10.0, "length");
}

/// The two I-beams: their parts' sizes, and how they lie to each other. Returns the first beam's
/// centre x.
fn check_beams(world: &World, top: f64) -> f64 {
    let mut centres = Vec::new();
    for beam in ["beam_1", "beam_2"] {
        let [bottom, web, flange] = ["bottom_flange", "web", "top_flange"]
            .map(|part| bounds(shape(world, &format!("{beam}_{part}"))));
        for (low, high) in [bottom, flange] {
            assert_near(high.x - low.x, 0.05, "flange width");
            assert_near(high.z - low.z, 0.015, "flange thickness");
        }
        assert_near(web.1.x - web.0.x, 0.015, "web thickness");
        assert_near(web.0.z, bottom.1.z, "web meets the bottom flange");
        assert_near(web.1.z, flange.0.z, "web meets the top flange");
        assert_near(flange.1.z - bottom.0.z, 0.20, "beam height");
        assert_near(flange.1.z, top, "beam top");
        assert_near(flange.1.y - flange.0.y, 2.0, "beam length");
        centres.push(0.5 * (flange.0.x + flange.1.x));
    }
    assert_near(centres[1] - centres[0], 0.15, "centre distance");
    centres[0]
}

/// A sole that faces across the beams fits on both tops together, and not on one top
/// alone.
fn check_beam_support(world: &World, first_centre: f64, top: f64) {
    let (mut spanning, mut single) = (0, 0);
    for step in 0..600 {
        let x = first_centre - 0.2 + 1e-3 * f64::from(step);
        for yaw in [0.0, std::f64::consts::PI] {
            let sole = sole_at(dvec3(x, 0.0, top), yaw);
            let (touched, area) = (contacts(world, &sole), support_area(world, &sole));
            let on = |centre: f64| {
                touched.iter().any(|point| (point.x - centre).abs() <= 0.025 + EPSILON)
            };
            let whole = |centre: f64| {
                [-0.025, 0.025]
                    .iter()
                    .all(|edge| touched.iter().any(|p| (p.x - centre - edge).abs() < EPSILON))
            };
            if whole(first_centre) && whole(first_centre + 0.15) {
                spanning += 1;
                assert!(area >= 0.02, "across both tops, but only {area} m2 at x = {x}");
            } else if !(on(first_centre) && on(first_centre + 0.15)) {
                single += 1;
                assert!(area <= 0.008, "one top at most, but {area} m2 at x = {x}");
            }
        }
    }
    assert!(spanning >= 20 && single >= 100, "{spanning} and {single} placements tried");
}

#[test]
fn ibeam_hallway_offers_both_tops_together_and_neither_alone() {
    let world = world("ibeam_hallway");
    let (low, high) = bounds(shape(&world, "floor"));
    assert_near(high.x - low.x, 6.0, "hallway length");
    assert_near(low.x, 0.0, "start end");
    let (left, right) = (bounds(shape(&world, "wall_left")), bounds(shape(&world, "wall_right")));
    assert_near(left.0.y - right.1.y, 2.0, "hallway width");
    assert_near(left.1.z, 2.0, "left wall height");
    assert_near(right.1.z, 2.0, "right wall height");
    let first = check_beams(&world, 0.20);
    assert_near(first, 3.0, "first beam");
    check_beam_support(&world, first, 0.20);
}

#[test]
fn ibeam_gap_is_wider_than_the_longest_step() {
    let world = world("ibeam_gap");
    let (start, goal) = (bounds(shape(&world, "floor_start")), bounds(shape(&world, "floor_goal")));
    assert_near(goal.0.x - start.1.x, 1.0, "trench length");
    assert!(
        goal.0.x - start.1.x - SOLE_SIZE.x > LONGEST_STEP,
        "with both soles almost wholly over the edge it is still too wide"
    );
    let bottom = bounds(shape(&world, "trench_floor")).1.z;
    assert_near(bottom, -0.8, "trench depth");
    let first = check_beams(&world, 0.10);
    assert_near(first + 0.075, 0.5 * (start.1.x + goal.0.x), "the pair stands in the middle");
    check_beam_support(&world, first, 0.10);
    for post in named(&world, "post") {
        assert_near(bounds(post).0.z, bottom, "a post stands on the trench's floor");
        assert_near(bounds(post).1.z, -0.10, "a post carries its beam");
    }
    assert_eq!(named(&world, "post").len(), 4);
}

#[test]
fn ibeam_gap_has_nothing_else_to_step_on() {
    let world = world("ibeam_gap");
    let has_support = |x: f64, z: f64| support_area(&world, &sole_at(dvec3(x, 0.0, z), 0.0)) > 1e-6;
    for step in 0..100 {
        let x = 2.0 + 0.01 * f64::from(step);
        for height in [-0.4, -0.2, 0.0, 0.2] {
            let over_floor = height == 0.0 && !(2.09..=2.87).contains(&x);
            assert!(
                over_floor || !has_support(x, height),
                "something to stand on at x = {x}, z = {height}"
            );
        }
    }
}

#[test]
fn stepping_stones_have_their_size_and_lie_apart() {
    let world = world("stepping_stones");
    let (start, goal) = (bounds(shape(&world, "floor_start")), bounds(shape(&world, "floor_goal")));
    assert_near(goal.0.x - start.1.x, 3.0, "gap");
    let stones = named(&world, "stone");
    assert_eq!(stones.len() + 2, world.shapes.len(), "void below");
    for stone in &stones {
        let (low, high) = bounds(stone);
        assert_near(high.x - low.x, 0.28, "stone length");
        assert_near(high.y - low.y, 0.20, "stone width");
        assert_near(high.z, 0.0, "stone top");
    }
    for (at, one) in world.shapes.iter().enumerate() {
        for other in &world.shapes[at + 1..] {
            let ((low, high), (other_low, other_high)) = (bounds(one), bounds(other));
            let apart = low.cmpge(other_high - DVec3::splat(EPSILON))
                | high.cmple(other_low + DVec3::splat(EPSILON));
            assert!(apart.any(), "'{}' overlaps '{}'", one.name, other.name);
        }
    }
}

#[test]
fn stepping_stones_are_two_irregular_columns() {
    let world = world("stepping_stones");
    for (column, y) in [("stone_left", 0.15), ("stone_right", -0.15)] {
        let centres: Vec<DVec3> =
            named(&world, column).iter().map(|stone| stone.world_from_shape.translation).collect();
        assert_eq!(centres.len(), 8);
        let spacings: Vec<f64> = centres.windows(2).map(|pair| pair[1].x - pair[0].x).collect();
        assert!(
            spacings.iter().all(|spacing| (0.28..=0.42).contains(spacing)),
            "{column}: {spacings:?}"
        );
        assert!(
            centres.iter().all(|centre| (centre.y - y).abs() <= 0.05),
            "{column} leaves its line"
        );
        let spread = |values: &[f64]| {
            values.iter().copied().fold(f64::MIN, f64::max)
                - values.iter().copied().fold(f64::MAX, f64::min)
        };
        assert!(spread(&spacings) > 0.02, "{column} is regular along x");
        assert!(
            spread(&centres.iter().map(|centre| centre.y).collect::<Vec<_>>()) > 0.02,
            "{column} is regular along y"
        );
    }
}

#[test]
fn stepping_stones_hold_a_whole_sole_each_but_not_the_whole_way() {
    let world = world("stepping_stones");
    for stone in named(&world, "stone") {
        let centred = stone.world_from_shape.translation.with_z(0.0) - dvec3(0.02, 0.0, 0.0);
        assert!(rests_wholly(&world, &sole_at(centred, 0.0)), "'{}' is too small", stone.name);
    }
    let shifted = (0..100).filter(|step| {
        !rests_wholly(&world, &sole_at(dvec3(2.1 + 0.028 * f64::from(*step), 0.0, 0.0), 0.0))
    });
    assert_eq!(shifted.count(), 100, "the middle line carries nothing");
}

#[test]
fn no_way_island_is_out_of_reach() {
    let world = world("no_way_island");
    assert_eq!(world.shapes.len(), 2);
    let (floor, island) = (bounds(shape(&world, "floor")), bounds(shape(&world, "island")));
    assert!(island.0.x - floor.1.x - SOLE_SIZE.x > LONGEST_STEP);
    let goal = load_scenario(&sole_support::configs("scenarios").join("no_way_island.toml"))
        .unwrap()
        .goal
        .position;
    assert!(
        goal.cmpge(island.0).all() && goal.cmple(island.1).all(),
        "the goal lies on the island"
    );
}

#[test]
fn no_way_wall_leaves_no_opening() {
    let world = world("no_way_wall");
    let [across, left, right, floor] =
        ["wall_across", "wall_left", "wall_right", "floor"].map(|name| bounds(shape(&world, name)));
    assert_near(across.1.y, left.0.y, "meets the left wall");
    assert_near(across.0.y, right.1.y, "meets the right wall");
    assert_near(across.0.z, floor.1.z, "meets the floor");
    assert!(across.1.z >= 2.0, "nobody climbs over");
    for side in [left, right] {
        assert!(side.0.x <= floor.0.x && side.1.x >= floor.1.x, "a side wall ends early");
    }
    let goal = load_scenario(&sole_support::configs("scenarios").join("no_way_wall.toml")).unwrap();
    assert!(goal.start.position.x < across.0.x && goal.goal.position.x > across.1.x);
}

#[test]
fn no_way_worlds_carry_a_budget_that_ends_soon() {
    let default = surefoot_shared_types::config::PlannerConfig::default().work_max;
    for path in files("scenarios").iter().filter(|path| path.to_string_lossy().contains("no_way_"))
    {
        assert!(load_scenario(path).unwrap().planner.work_max < default, "{}", path.display());
    }
}

#[test]
fn a_tilted_box_has_no_level_top() {
    let mut world = world("flat_walk");
    assert!(top_face(&world.shapes[0]).is_some());
    world.shapes[0].world_from_shape.rotation =
        surefoot_shared_types::base::spatial::rotation_from_rpy(0.01, 0.0, 0.0);
    assert!(top_face(&world.shapes[0]).is_none());
}
