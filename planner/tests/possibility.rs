//! Stage P on worlds with obstacles: the guide route leads around, over and under them.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use std::f64::consts::PI;

use common::{Case, preparation_for, repository};
use glam::DVec3;
use surefoot_planner::base::threads::Threads;
use surefoot_planner::collision::model::CollisionModel;
use surefoot_planner::constraints::constraints::Constraints;
use surefoot_planner::foot_placement::{FootPlacementConfig, Scratch, Surfaces};
use surefoot_planner::motion::mode_graph::ModeGraph;
use surefoot_planner::pipeline::FootholdSampler;
use surefoot_planner::possibility;
use surefoot_planner::possibility::Progress;
use surefoot_planner::possibility::{
    CrouchProfile, Label, MidFeetPose, RouteCondition, RouteSearch, StageContext, UpperBody,
};
use surefoot_planner::preparation::Preparation;
use surefoot_planner::robot::crouch::Crouch;
use surefoot_planner::robot::mechanism::Mechanism;
use surefoot_shared_types::base::spatial::{wrap_angle, yaw_of};
use surefoot_shared_types::world::load::load_world;

/// A case compiled for stage P.
struct Fixture {
    case: Case,
    constraints: Constraints,
    surfaces: Surfaces,
    upper_body: UpperBody,
    preparation: Preparation,
    threads: Threads,
}

impl Fixture {
    fn context(&self, seed: u64) -> StageContext<'_> {
        StageContext {
            constraints: &self.constraints,
            surfaces: &self.surfaces,
            upper_body: &self.upper_body,
            preparation: &self.preparation,
            postures: &[],
            seed,
            stance_width: self.case.scenario.start.stance_width,
            threads: &self.threads,
        }
    }
}

/// A case compiled for stage P, and its route search.
struct Compiled {
    fixture: Fixture,
    search: RouteSearch,
}

impl Compiled {
    fn new(case: Case) -> Self {
        Self::with_capacity(4096, case)
    }

    /// The same with trees of `vertices` vertices.
    fn with_capacity(vertices: usize, case: Case) -> Self {
        let config = &case.scenario.planner;
        let robot = Mechanism::new(&case.model, config).unwrap();
        let preparation = preparation_for(&case.model, config);
        let upper_body = UpperBody::new(&case.model, &robot, None);
        let collision = CollisionModel::new(&case.model, &case.world, config.clearance).unwrap();
        let placement = FootPlacementConfig::default();
        let (bounds, ends) =
            (collision.world_bounds(), [&case.scenario.start, &case.scenario.goal]);
        let width = preparation.step_limits().walking_width();
        let search = RouteSearch::new(
            ends,
            width,
            config.route_vertex_spacing,
            vertices,
            &bounds,
            &placement,
        );
        let surfaces = Surfaces::new(&case.world, placement).unwrap();
        let constraints = Constraints::new(robot, collision, config.clone());
        Self {
            fixture: Fixture {
                case,
                constraints,
                surfaces,
                upper_body,
                preparation,
                threads: Threads::default(),
            },
            search,
        }
    }

    /// Advances the search until it ends. Returns the result and the work spent.
    fn grow(&mut self, seed: u64) -> (Progress, u64) {
        let context = self.fixture.context(seed);
        let mut work = 0;
        loop {
            let (progress, spent) = self.search.advance(&context, u64::MAX);
            work += spent;
            if progress != Progress::Growing {
                return (progress, work);
            }
        }
    }

    fn poses(&self) -> Vec<MidFeetPose> {
        let route = self.search.route();
        (0..route.vertex_count()).map(|index| route.pose(index)).collect()
    }
}

fn walled(seed: u64) -> (Compiled, Progress, u64) {
    let mut compiled =
        Compiled::new(Case::shipped("flat_walk").with_box([2.0, 0.95, 1.0], [0.05, 1.0, 1.0]));
    let (progress, work) = compiled.grow(seed);
    (compiled, progress, work)
}

/// A wall across a floor and beyond, with an opening to the left that is lower than every crouch
/// that stage P tests, and higher than the root.
fn low_opening() -> Case {
    let mut case = Case::shipped("flat_walk");
    case.world.shapes.clear();
    case.scenario.start.position = DVec3::new(0.7, 0.0, 0.0);
    case.scenario.goal.position = DVec3::new(3.3, 0.0, 0.0);
    case.with_box([2.0, 0.0, -0.25], [2.0, 2.0, 0.25])
        .with_box([2.0, -2.5, 1.0], [0.1, 3.5, 1.0])
        .with_box([2.0, 3.5, 1.25], [0.1, 2.5, 0.75])
}

#[test]
fn where_no_crouch_passes_the_necessary_condition_gives_a_route() {
    for seed in 1..4 {
        let mut compiled = Compiled::new(low_opening());
        assert_eq!(compiled.grow(seed).0, Progress::Exhausted, "seed {seed}");
        compiled.search.restart();
        assert_eq!(compiled.grow(seed).0, Progress::Route, "seed {seed}");
        assert_eq!(compiled.search.condition(), RouteCondition::Necessary);
        let context = compiled.fixture.context(seed);
        let poses = compiled.poses();
        // Vertices may lie before and behind the wall.
        let mut along = poses.windows(2).flat_map(|edge| {
            [0.0, 0.25, 0.5, 0.75].map(|fraction| edge[0].interpolate(&edge[1], fraction))
        });
        assert!(along.any(|pose| !context.is_free(&pose, RouteCondition::Root)), "{poses:?}");
        assert!(poses.iter().all(|pose| context.is_possible(pose, 0)), "seed {seed}: {poses:?}");
    }
}

/// The way between two walls that lean to the left.
fn slanted_slot() -> Case {
    let mut case = Case::shipped("flat_walk");
    case.world = load_world(&repository().join("configs/worlds/holes/slanted_slot.toml")).unwrap();
    case.scenario.start.position = 0.7 * DVec3::X;
    case.scenario.goal.position = 4.3 * DVec3::X;
    case
}

/// Searches with a leaning root that find a route through the slot, and the least roll of each.
fn rolls_through_the_slot(has_roll: bool) -> Vec<f64> {
    let mut rolls = vec![];
    for seed in 1..=16 {
        let mut compiled = Compiled::new(slanted_slot());
        if !has_roll {
            compiled.search.leave_out_roll();
        }
        assert!(compiled.search.begin_leaning());
        if compiled.grow(seed).0 == Progress::Route {
            let vertices = 0..compiled.search.route().vertex_count();
            let crouches = vertices.filter_map(|vertex| compiled.search.crouch(vertex));
            rolls.push(crouches.map(|crouch| crouch.roll).fold(0.0, f64::min));
        }
    }
    rolls
}

#[test]
fn more_searches_find_a_route_where_the_root_rolls() {
    let [rolls, level] = [true, false].map(rolls_through_the_slot);
    assert!(rolls.len() >= 14 && level.len() <= 10, "{rolls:?}, {level:?}");
    assert!(rolls.iter().all(|&roll| roll < -0.1), "to the left: {rolls:?}");
    assert!(level.iter().all(|&roll| roll == 0.0), "{level:?}");
}

#[test]
fn the_route_over_an_open_floor_is_straight_and_needs_no_sample() {
    let mut compiled = Compiled::new(Case::shipped("flat_walk"));
    assert_eq!(compiled.grow(1).0, Progress::Route);
    let (start, goal) = (compiled.fixture.case.scenario.start, compiled.fixture.case.scenario.goal);
    let poses = compiled.poses();
    assert_eq!(
        (poses[0], poses[poses.len() - 1]),
        (MidFeetPose::of_stance(&start), MidFeetPose::of_stance(&goal))
    );
    assert!(poses.iter().all(|pose| pose.position.y.abs() < 0.05), "{poses:?}");
}

#[test]
fn a_route_leads_around_a_wall_over_free_vertices() {
    for seed in 1..6 {
        let (compiled, progress, _) = walled(seed);
        assert_eq!(progress, Progress::Route);
        let poses = compiled.poses();
        let context = compiled.fixture.context(seed);
        assert!(
            poses.iter().all(|pose| context.is_free(pose, RouteCondition::Root)),
            "seed {seed}: {poses:?}"
        );
        for face in [1.95, 2.05] {
            let crossing = poses
                .windows(2)
                .find(|pair| pair[0].position.x <= face && pair[1].position.x > face)
                .unwrap();
            let (from, to) = (crossing[0].position, crossing[1].position);
            let beside = from.lerp(to, (face - from.x) / (to.x - from.x));
            assert!(beside.y < -0.05, "the route leads through the wall: {crossing:?}");
        }
    }
}

/// The pose and crouch at each vertex of a route under a bar with its underside at a height, m.
fn crouches_past_a_bar(underside: f64) -> (Vec<MidFeetPose>, Vec<Crouch>) {
    let mut compiled = Compiled::new(
        Case::shipped("flat_walk").with_box([1.6, 0.0, underside + 0.025], [0.025, 1.0, 0.025]),
    );
    assert_eq!(compiled.grow(1).0, Progress::Route);
    let (route, Fixture { constraints, upper_body, threads, .. }) =
        (compiled.search.route(), &compiled.fixture);
    let mut profile = CrouchProfile::new(route.vertex_count());
    profile.begin();
    if !route.is_upright() {
        let context = possibility::CrouchContext { constraints, upper_body, threads };
        while !profile.advance(&context, route, 1).1 {}
    }
    (compiled.poses(), (0..route.vertex_count()).map(|vertex| profile.crouch(vertex)).collect())
}

#[test]
fn the_robot_crouches_under_a_low_bar_and_nowhere_else() {
    assert!(crouches_past_a_bar(2.0).1.iter().all(|crouch| *crouch == Crouch::UPRIGHT));
    for underside in [1.4, 1.25, 1.15] {
        let (poses, crouches) = crouches_past_a_bar(underside);
        let is_low = |(pose, _): &(&MidFeetPose, &Crouch)| (pose.position.x - 1.6).abs() < 0.15;
        assert!(
            poses.iter().zip(&crouches).filter(is_low).all(|(_, crouch)| crouch.depth() > 0.0),
            "{underside} m: {crouches:?}"
        );
        assert_eq!(
            [crouches[0], crouches[crouches.len() - 1]],
            [Crouch::UPRIGHT; 2],
            "{underside} m: {crouches:?}"
        );
    }
}

/// Route poses inside a slit 0.45 m wide, which is too narrow for a robot that walks forward with
/// its arms at its sides.
fn poses_in_a_slit(seed: u64) -> (Compiled, Vec<MidFeetPose>) {
    let wall = |side: f64| ([2.0, side * (0.225 + 1.5), 1.0], [0.25, 1.5, 1.0]);
    let (left, right) = (wall(1.0), wall(-1.0));
    let mut compiled = Compiled::new(
        Case::shipped("ibeam_hallway").with_box(left.0, left.1).with_box(right.0, right.1),
    );
    assert_eq!(compiled.grow(seed).0, Progress::Route);
    let within =
        compiled.poses().into_iter().filter(|pose| (pose.position.x - 2.0).abs() < 0.2).collect();
    (compiled, within)
}

#[test]
fn a_robot_sidesteps_through_a_slit_narrower_than_its_shoulders() {
    let mut sideways = 0;
    for seed in 1..13 {
        let (compiled, within) = poses_in_a_slit(seed);
        let context = compiled.fixture.context(seed);
        let is_free = within.iter().all(|pose| context.is_free(pose, RouteCondition::UpperBody));
        let is_sideways = within.iter().all(|pose| libm::sin(pose.yaw).abs() > 0.7);
        assert!(!within.is_empty() && is_free == is_sideways, "seed {seed}: {within:?}");
        sideways += u32::from(is_sideways);
    }
    assert!(sideways >= 10, "{sideways} of 12");
}

#[test]
fn vertices_are_within_a_step_of_each_other_and_have_placements_for_both_feet() {
    let (compiled, _, _) = walled(3);
    let poses = compiled.poses();
    for (index, pair) in poses.windows(2).enumerate() {
        assert!(pair[0].horizontal_offset_to(&pair[1]).length() < 0.75, "{pair:?}");
        if index > 0 {
            let placements = compiled.search.placements(index);
            assert!(
                [0, 1]
                    .iter()
                    .all(|&limb| placements.iter().any(|placement| placement.limb == limb)),
                "vertex {index}"
            );
        }
    }
}

#[test]
fn a_route_has_no_gap_longer_than_a_step() {
    let mut long_edges = 0;
    for seed in 1..7 {
        let mut compiled = Compiled::new(Case::shipped("jungle_gym_spiral_route"));
        assert_eq!(compiled.grow(seed).0, Progress::Route);
        let context = compiled.fixture.context(seed);
        let route = compiled.poses();
        for (index, pair) in
            route.windows(2).enumerate().skip(1).filter(|(index, _)| index + 2 < route.len())
        {
            let [from, to] = [index, index + 1].map(|vertex| compiled.search.placements(vertex));
            long_edges += usize::from(
                pair[0].horizontal_offset_to(&pair[1]).length()
                    > 1.5 * compiled.fixture.case.scenario.planner.route_vertex_spacing,
            );
            assert!(context.has_step_between(from, to), "seed {seed}, vertex {index}: {pair:?}");
        }
    }
    assert!(long_edges > 0, "no edge is longer than 1.5 vertex spacings");
}

#[test]
fn the_elevation_follows_stairs_to_the_goal() {
    let mut compiled = Compiled::new(Case::shipped("stairs"));
    assert_eq!(compiled.grow(1).0, Progress::Route);
    let heights: Vec<f64> = compiled.poses().iter().map(|pose| pose.position.z).collect();
    assert!((heights[heights.len() - 1] - 1.32).abs() < 1e-9);
    assert!(heights.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.45), "{heights:?}");
}

#[test]
fn a_route_leads_under_a_deck_with_enough_clearance_and_never_through_it() {
    // The lower deck is too high to step onto, and blocks the legs where the root is free above it.
    for (height, expected) in [(2.6, Progress::Route), (0.45, Progress::Exhausted)] {
        let mut compiled =
            Compiled::new(Case::shipped("flat_walk").with_box([2.0, 0.0, height], [0.6, 6.0, 0.1]));
        let progress = compiled.grow(1).0;
        assert_eq!(progress, expected, "a deck at {height} m");
        let is_under = |pose: &MidFeetPose| pose.position.z.abs() < 1e-9;
        assert!(
            expected == Progress::Exhausted || compiled.poses().iter().all(is_under),
            "the route leads up through the deck at {height} m"
        );
    }
}

#[test]
fn a_goal_on_a_deck_overhead_is_not_reached_from_below() {
    let mut case = Case::shipped("flat_walk").with_box([2.5, 0.0, 2.6], [3.5, 3.0, 0.05]);
    case.scenario.goal.position.z = 2.65;
    assert_eq!(Compiled::new(case).grow(1).0, Progress::Exhausted);
}

#[test]
fn a_route_avoids_blocked_regions() {
    let mut compiled = Compiled::new(Case::shipped("flat_walk"));
    compiled.grow(1);
    let poses = compiled.poses();
    let blocked = poses[poses.len() / 2];
    compiled.search.block(blocked, 0.25);
    // The first restarted route is walked backward.
    for _ in 0..2 {
        compiled.search.restart();
        assert_eq!(compiled.grow(1).0, Progress::Route);
    }
    assert!(!compiled.search.route().is_backward());
    assert!(compiled.poses().iter().all(|pose| pose.distance(&blocked) > 0.2));
}

#[test]
fn the_first_restarted_route_is_walked_backward_and_excludes_feet_that_face_forward() {
    let mut compiled = Compiled::new(Case::shipped("flat_walk"));
    compiled.grow(1);
    let ahead = compiled.poses();
    let (middle, sole) = (ahead[ahead.len() / 2], 0.1 * DVec3::Y);
    let beside = |pose: MidFeetPose, turn: f64| MidFeetPose {
        position: pose.position + sole,
        yaw: pose.yaw + turn,
    };
    assert!(
        [0.0, PI]
            .iter()
            .all(|&turn| compiled.search.route().is_aligned_with(&beside(middle, turn))),
        "a route that is walked forward accepts every heading"
    );
    compiled.search.restart();
    assert_eq!(compiled.grow(1).0, Progress::Route);
    let (route, backward) = (compiled.search.route(), compiled.poses());
    assert!(route.is_backward());
    assert_eq!(
        [backward[0].yaw, backward[backward.len() - 1].yaw],
        [ahead[0].yaw, ahead[ahead.len() - 1].yaw]
    );
    let is_turned = |pose: &MidFeetPose| wrap_angle(pose.yaw - middle.yaw).abs() > 3.0;
    let inside = |pose: &MidFeetPose| (2.0..8.0).contains(&pose.position.x);
    assert!(backward.iter().filter(|pose| inside(pose)).all(is_turned));
    assert!(
        route.is_aligned_with(&beside(middle, PI))
            && !route.is_aligned_with(&beside(middle, 0.0))
            && route.is_aligned_with(&beside(ahead[0], 0.0))
    );
}

#[test]
fn a_detour_changes_the_vertices_between_its_ends_and_no_others() {
    let mut compiled = Compiled::new(Case::shipped("flat_walk"));
    compiled.grow(1);
    let before = compiled.poses();
    compiled.search.block(before[14], 0.25);
    compiled.search.begin_detour([10, 18]);
    assert_eq!(compiled.grow(1).0, Progress::Route);
    let after = compiled.poses();
    assert_eq!(before[..=10], after[..=10]);
    assert_eq!(before[18..], after[after.len() - (before.len() - 18)..]);
    assert!(after.iter().all(|pose| pose.distance(&before[14]) > 0.2));
}

#[test]
fn a_goal_out_of_reach_exhausts_the_samples_or_fills_the_trees() {
    for (vertices, expected) in [(4096, Progress::Exhausted), (1024, Progress::Full)] {
        let mut compiled = Compiled::with_capacity(vertices, Case::shipped("no_way_island"));
        assert_eq!(compiled.grow(1).0, expected, "capacity for {vertices} vertices");
    }
}

#[test]
fn equal_seeds_give_equal_routes_and_different_seeds_different_ones() {
    let [first, again, other] = [3, 3, 4].map(|seed| {
        let (compiled, _, work) = walled(seed);
        (compiled.poses(), work)
    });
    assert_eq!(first, again);
    assert_ne!(first, other);
}

#[test]
fn edges_are_possible_where_primitives_fit_and_nowhere_else() {
    let mut open = Compiled::new(Case::shipped("flat_walk"));
    assert_eq!(open.grow(1).0, Progress::Route);
    let labelled = open.search.route().labelled();
    // Start and goal have no pairs of placements here.
    assert!(labelled.edges > 30 && labelled.possible + 2 == labelled.edges, "{labelled:?}");
    let mut barred =
        Compiled::new(Case::shipped("flat_walk").with_box([4.0, 0.0, 0.05], [0.02, 1.0, 0.05]));
    assert_eq!(barred.grow(1).0, Progress::Route);
    let route = barred.search.route();
    for vertex in 2..route.vertex_count() - 1 {
        let is_near = (route.pose(vertex).position.x - 4.0).abs() < 0.1;
        let is_far = (route.pose(vertex).position.x - 4.0).abs() > 1.0;
        assert!(!(is_near && route.label(vertex).is_possible()), "{vertex}");
        assert!(!is_far || matches!(route.label(vertex), Label::Primitive { .. }), "{vertex}");
    }
    assert!(barred.search.labelled().possible < barred.search.labelled().edges);
}

#[test]
fn traversed_edges_are_possible_and_reused() {
    let mut compiled =
        Compiled::new(Case::shipped("flat_walk").with_box([2.0, 0.0, 0.05], [0.02, 1.0, 0.05]));
    assert_eq!(compiled.grow(1).0, Progress::Route);
    let before = compiled.poses();
    let indeterminate = (1..before.len())
        .find(|&vertex| compiled.search.route().label(vertex) == Label::Indeterminate)
        .unwrap();
    let reached = indeterminate + 3;
    compiled.search.mark_traversed(reached);
    assert_eq!(compiled.search.route().label(indeterminate), Label::Traversed);
    compiled.search.block(before[reached + 5], 0.25);
    compiled.search.restart();
    assert_eq!(compiled.grow(1).0, Progress::Route);
    let after = compiled.poses();
    assert_eq!(after[..=indeterminate], before[..=indeterminate]);
    assert!(after.iter().all(|pose| pose.distance(&before[reached + 5]) > 0.2));
    assert_eq!(compiled.search.route().label(indeterminate), Label::Traversed);
}

/// The footholds with a toe-out angle along the route of a shipped scenario.
fn toe_out_placements(name: &str) -> ModeGraph {
    let mut compiled = Compiled::new(Case::shipped(name));
    assert_eq!(compiled.grow(1).0, Progress::Route);
    let Compiled { fixture, search } = &compiled;
    let steps = fixture.preparation.step_limits();
    let sampler = FootholdSampler {
        constraints: &fixture.constraints,
        surfaces: &fixture.surfaces,
        steps,
        seed: 1,
    };
    let (mut graph, mut scratch) =
        (ModeGraph::new(4096, 1, 1, 1.0), Scratch::new(&FootPlacementConfig::default()));
    for sampled in (0..search.route().vertex_count()).flat_map(|vertex| [(vertex, 0), (vertex, 1)])
    {
        sampler.toe_out(search.route(), sampled, 0, &mut graph, &mut scratch).unwrap();
    }
    graph
}

#[test]
fn toe_out_is_used_on_steep_stairs_and_nowhere_else() {
    let graph = toe_out_placements("stairs");
    let heights: Vec<f64> =
        graph.footholds().iter().map(|foothold| foothold.world_from_sole.translation.z).collect();
    assert!(
        (1..6).all(|step| heights
            .iter()
            .any(|height| (height - 0.22 * f64::from(step)).abs() < 1e-6)),
        "{heights:?}"
    );
    let outward = |limb: usize| if limb == 0 { 1.0 } else { -1.0 };
    let turns = graph
        .footholds()
        .iter()
        .map(|foothold| outward(foothold.limb) * yaw_of(foothold.world_from_sole.rotation));
    assert!(
        turns.clone().any(|turn| (turn - 0.5).abs() < 0.05)
            && turns.into_iter().all(|turn| turn > -0.35)
    );
    for level_or_low in ["flat_walk", "stairs_bauzil"] {
        assert_eq!(toe_out_placements(level_or_low).footholds().len(), 0, "{level_or_low}");
    }
}
