//! The relaxed problem: names what makes a task impossible at once, and never calls a task
//! impossible that has a plan.

#![allow(missing_docs, clippy::unwrap_used, reason = "a test ends where a file does not load")]

use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::relaxation::{GroundGap, Obstruction};
use surefoot_planner::{Outcome, Planner, Status};

use surefoot_shared_types::base::spatial::rotation_about;
use surefoot_shared_types::world::world::WorldShape;
use surefoot_shared_types::{Pose, Shape};

use common::{Case, run};

mod common;

const STEP: u64 = 20_000;
/// Work units in which an impossible task ends: far less than a tenth of a second.
const WORK_MAX: u64 = 12_000;
/// Random worlds that are tried; `SUREFOOT_RANDOM_WORLDS` sets another number.
const RANDOM_WORLDS: u64 = 30;

/// How a case ends, its message and the planner.
fn ending(case: &Case) -> (Outcome, String, Planner) {
    let mut planner = case.planner(1);
    let outcome = run(&mut planner, STEP);
    let text = planner.describe(&outcome);
    (outcome, text, planner)
}

fn obstruction(case: &Case) -> Obstruction {
    match ending(case) {
        (Outcome::Impossible(obstruction), text, planner) => {
            assert!(planner.stats().work < WORK_MAX, "{} units: {text}", planner.stats().work);
            assert!(text.starts_with("no plan is possible: "), "{text}");
            obstruction
        }
        (other, text, _) => panic!("{}: {other:?}: {text}", case.scenario.name),
    }
}

fn gap(case: &Case) -> GroundGap {
    match obstruction(case) {
        Obstruction::Gap(gap) => gap,
        other => panic!("{}: {other:?}", case.scenario.name),
    }
}

#[test]
fn a_gap_is_measured() {
    let gap = gap(&Case::shipped("no_way_island"));
    let [width, rise] = gap.size();
    assert!((width - 1.5).abs() < 1e-6 && rise.abs() < 1e-6, "{gap:?}");
    assert!((gap.from.x - 3.0).abs() < 1e-6 && (gap.to.x - 4.5).abs() < 1e-6, "{gap:?}");
    assert!(gap.span_max < width && gap.steep.is_none(), "{gap:?}");
}

#[test]
fn ground_that_is_too_steep_is_named_with_its_angle_and_the_limit() {
    let gap = gap(&Case::shipped("no_way_slope"));
    let steep = gap.steep.unwrap();
    assert!((steep.angle - 0.702545).abs() < 1e-6, "{steep:?}");
    assert!(steep.limit < libm::atan(0.6) && steep.limit > 0.8 * libm::atan(0.6), "{steep:?}");
    let [width, rise] = gap.size();
    assert!((width - 3.0).abs() < 1e-3 && (rise - 2.54).abs() < 1e-2, "{gap:?}");
}

#[test]
fn a_step_that_is_too_high_is_measured() {
    let mut case = Case::shipped("flat_walk");
    case.scenario.goal.position.z = 1.5;
    let goal = case.scenario.goal.position;
    let gap = gap(&case.with_box([goal.x + 1.0, 0.0, 0.75], [2.0, 1.0, 0.75]));
    assert!((gap.size()[1] - 1.5).abs() < 1e-6, "{gap:?}");
}

#[test]
fn a_wall_around_the_goal_is_named() {
    let mut case = Case::shipped("flat_walk").configured(|planner| planner.work_max = 30_000);
    case.scenario.goal.position.x = 5.0;
    let goal = case.scenario.goal.position;
    for (x, y, half) in [(1.0, 0.0, [0.05, 1.0]), (-1.0, 0.0, [0.05, 1.0]), (0.0, 1.0, [1.0, 0.05])]
    {
        let half_extents = [half[0], half[1], 1.0];
        case = case.with_box([goal.x + x, goal.y + y, 1.0], half_extents);
    }
    let last = case.world.shapes.len();
    let case = case.with_box([goal.x, goal.y - 1.0, 1.0], [1.0, 0.05, 1.0]);
    let Obstruction::Blockage(blockage) = obstruction(&case) else { panic!("a blockage") };
    assert!((last - 3..=last).contains(&blockage.shape), "{blockage:?}");
    assert!((blockage.at - goal).truncate().abs().max_element() < 1.1, "{blockage:?}");
}

#[test]
fn the_size_of_steps_and_the_number_of_threads_change_nothing() {
    let case = Case::shipped("no_way_island");
    let search = |threads, step| {
        let mut planner = case.planner(threads);
        (run(&mut planner, step), planner.stats())
    };
    let alone = search(1, u64::MAX);
    assert_eq!(search(2, 1), alone);
    assert_eq!(search(2, 777), alone);
}

/// The obstruction that the relaxed problem shows at the start of a search.
fn shown(planner: &mut Planner) -> Option<Obstruction> {
    assert_eq!(planner.step(1), Status::Working);
    planner.obstruction()
}

#[test]
fn no_shipped_scenario_with_a_plan_is_called_impossible() {
    let folder = common::repository().join("configs/scenarios");
    let mut names: Vec<String> = std::fs::read_dir(folder)
        .unwrap()
        .map(|entry| entry.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
        .filter(|name| !name.starts_with("no_way"))
        .collect();
    names.sort();
    assert!(names.len() > 20);
    for name in names {
        let mut planner = Case::shipped(&name).planner(1);
        assert_eq!(shown(&mut planner), None, "{name}");
    }
}

/// A walk from a floor to another 1.5 m away, with shapes between them.
fn over_a_void(between: impl IntoIterator<Item = (glam::DVec3, Shape)>) -> Case {
    let mut case = Case::shipped("flat_walk").configured(|planner| planner.work_max = 60_000);
    case.world.shapes.clear();
    case = case.with_box([0.0, 0.0, -0.25], [1.0, 0.8, 0.25]);
    case = case.with_box([3.5, 0.0, -0.25], [1.0, 0.8, 0.25]);
    for (index, (at, shape)) in between.into_iter().enumerate() {
        // The axis of a cylinder lies along y.
        let turn = rotation_about(glam::DVec3::X, std::f64::consts::FRAC_PI_2);
        let is_round = matches!(shape, Shape::Cylinder { .. });
        let rotation = if is_round { turn } else { glam::DQuat::IDENTITY };
        case.world.shapes.push(WorldShape {
            name: format!("piece {index}"),
            world_from_shape: Pose::from_parts(at, rotation),
            shape,
        });
    }
    case.scenario.start.position = glam::DVec3::new(0.3, 0.0, 0.0);
    case.scenario.goal.position = glam::DVec3::new(3.2, 0.0, 0.0);
    case
}

/// Boxes as high as the floors over the void: of half a length and half a width (m) that begin at
/// x = 1 m, with the first as far from the floor as the distance between two.
fn planks(half_length: f64, half_width: f64, distance: f64) -> Case {
    let half_extents = glam::DVec3::new(half_length, half_width, 0.05);
    let pitch = 2.0 * half_length + distance;
    let count = ((1.5 - distance) / pitch).round() as usize;
    over_a_void((0..count).map(|index| {
        let x = 1.0 + distance + half_length + pitch * index as f64;
        (glam::DVec3::new(x, 0.0, -0.05), Shape::Box { half_extents })
    }))
}

/// The largest extent of the robot's soles, m.
fn sole_length(case: &Case) -> f64 {
    let corners = case.model.feet.iter().flat_map(|foot| {
        foot.polygon.iter().flat_map(|a| foot.polygon.iter().map(|b| a.distance(*b)))
    });
    corners.fold(0.0, f64::max)
}

#[test]
fn pieces_of_ground_farther_apart_than_a_sole_is_long_carry_none() {
    let case = planks(0.007, 0.6, 0.292);
    let length = sole_length(&case);
    let gap = gap(&case);
    let bare = gap.bare.unwrap();
    assert!((bare.sole_length - length).abs() < 1e-9 && length < 0.292, "{bare:?}");
    assert!((bare.spacing - 0.292).abs() < 1e-4, "{bare:?}");
    let (_, text, planner) = ending(&case);
    assert!(text.contains("0.292 m, more than the length of a sole"), "{text}");
    assert!(planner.stats().work < 1_000, "{} units", planner.stats().work);
}

#[test]
fn posts_that_are_too_small_alone_carry_no_sole() {
    let gap = gap(&planks(0.01, 0.01, 0.28));
    assert!(gap.bare.is_some_and(|bare| bare.spacing < f64::INFINITY), "{gap:?}");
}

#[test]
fn ground_under_a_row_of_bare_bars_does_not_hide_the_gap_if_no_step_reaches_it() {
    let mut case = planks(0.007, 0.6, 0.292);
    let (below, far_below) = (-0.6, -1.0);
    case = case.with_box([1.75, 0.0, far_below - 0.25], [3.0, 0.8, 0.25]);
    assert!(gap(&case).bare.is_some());
    let mut planner = case.with_box([1.75, 0.0, below - 0.25], [3.0, 0.8, 0.25]).planner(1);
    assert_eq!(shown(&mut planner), None);
}

#[test]
fn narrow_ground_on_which_a_sole_rests_is_not_called_bare() {
    let bars = |radius: f64, distance: f64, rise: f64| {
        let count = (1.5 / distance) as usize;
        over_a_void((1..count).map(|index| {
            let z = if index % 2 == 0 { rise } else { 0.0 } - radius;
            let at = glam::DVec3::new(1.0 + distance * index as f64, 0.0, z);
            (at, Shape::Cylinder { radius, half_length: 0.6 })
        }))
    };
    let cases = [
        ("bars", bars(0.02, 0.1, 0.0)),
        ("bars a sole spans", bars(0.01, 0.2, 0.0)),
        ("bars of two heights", bars(0.02, 0.1, 0.015)),
        ("thick bars", bars(0.15, 0.3, 0.0)),
        ("planks", planks(0.03, 0.6, 0.1)),
        ("wide planks", planks(0.06, 0.6, 0.25)),
        ("a beam", planks(0.75, 0.05, 0.0)),
        ("posts", planks(0.02, 0.02, 0.06)),
        ("stones", planks(0.1, 0.08, 0.3)),
    ];
    for (name, case) in cases {
        assert_eq!(shown(&mut case.planner(1)), None, "{name}");
    }
}

/// A random course between two floors: boxes of random sizes, some of them high, far apart or with
/// a wall on them.
fn random_course(seed: u64) -> Case {
    let mut random = Random::new(seed, Stream::Possibility, 0, 0);
    let mut case = Case::shipped("flat_walk").configured(|planner| {
        planner.work_max = 4_000;
        (planner.footholds_max, planner.transitions_max) = (4_000, 40_000);
        (planner.configurations_max, planner.tree_vertices_max) = (8_000, 1_024);
    });
    case.world.shapes.clear();
    let mut edge = 1.0;
    case = case.with_box([0.0, 0.0, -0.25], [edge, 1.0, 0.25]);
    let mut height: f64 = 0.0;
    for _ in 0..2 {
        let mut is_hard = || random.uniform(0.0, 1.0) < 0.15;
        let [is_far, is_high, is_walled] = [is_hard(), is_hard(), is_hard()];
        let gap = if is_far { random.uniform(0.4, 2.0) } else { random.uniform(0.0, 0.15) };
        let rise = if is_high { 1.6 } else { 0.1 };
        height += random.uniform(-rise, rise);
        let half_length = random.uniform(0.3, 0.6);
        edge += gap + 2.0 * half_length;
        let center = [edge - half_length, random.uniform(-0.1, 0.1), height - 0.25];
        case = case.with_box(center, [half_length, random.uniform(0.5, 1.0), 0.25]);
        if is_walled {
            let half_height = random.uniform(0.02, 1.2);
            let wall = [edge - half_length, 0.0, height + half_height];
            case = case.with_box(wall, [0.05, random.uniform(0.3, 2.0), half_height]);
        }
    }
    case = case.with_box([edge + 1.0, 0.0, height - 0.25], [1.0, 1.0, 0.25]);
    case.scenario.start.position = glam::DVec3::new(0.4, 0.0, 0.0);
    case.scenario.goal.position = glam::DVec3::new(edge + 0.6, 0.0, height);
    case
}

#[test]
fn no_random_course_with_a_plan_is_called_impossible() {
    let worlds = std::env::var("SUREFOOT_RANDOM_WORLDS");
    let worlds = worlds.map_or(RANDOM_WORLDS, |count| count.parse().unwrap());
    let (mut found, mut impossible) = (0, 0);
    for seed in 0..worlds {
        let mut planner = random_course(seed).planner(1);
        let is_obstructed = shown(&mut planner).is_some();
        if is_obstructed {
            impossible += 1;
            planner.limit_work(2_500);
            planner.search_on();
        }
        let is_found = run(&mut planner, STEP) == Outcome::Found;
        found += u64::from(is_found);
        assert!(!(is_obstructed && is_found), "seed {seed}");
    }
    println!("{worlds} courses: {found} with a plan, {impossible} impossible");
    assert!(4 * found >= worlds && 10 * impossible >= worlds, "{found} {impossible}");
}

#[test]
fn a_wall_across_a_corridor_is_named() {
    let case = Case::shipped("no_way_wall");
    let Obstruction::Enclosure(enclosure) = obstruction(&case) else { panic!("an enclosure") };
    assert_eq!(case.world.shapes[enclosure.shape].name, "wall_across");
    assert!((enclosure.at.x - 3.0).abs() < 0.1, "{enclosure:?}");
    assert!(enclosure.leg > 0.759 && enclosure.leg < 1.2, "{enclosure:?}");
}

#[test]
fn an_opening_in_a_wall_across_a_corridor_is_seen() {
    let closed = Case::shipped("no_way_wall");
    let across = closed.world.shapes.iter().position(|shape| shape.name == "wall_across").unwrap();
    let shown = |half_width: f64, half_height: f64, center_y: f64| {
        let mut case = closed.clone();
        let wall = &mut case.world.shapes[across];
        wall.shape = Shape::Box { half_extents: glam::DVec3::new(0.05, half_width, half_height) };
        wall.world_from_shape =
            Pose::from_translation(glam::DVec3::new(3.0, center_y, half_height));
        shown(&mut case.planner(1))
    };
    assert!(shown(1.0, 1.0, 0.0).is_some());
    assert_eq!(shown(0.85, 1.0, -0.15), None, "0.3 m wide, beside the wall");
    assert_eq!(shown(1.0, 0.45, 0.0), None, "above a wall of 0.9 m");
}
