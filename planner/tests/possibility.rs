//! Stage P on worlds with something in the way: the guide route goes around, up and over, and never
//! through.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use std::f64::consts::PI;

use common::{Case, preparation_for};
use glam::DVec3;
use surefoot_planner::body::Body;
use surefoot_planner::collision::CollisionModel;
use surefoot_planner::constraint::Constraints;
use surefoot_planner::foot_placement::{FootPlacementConfig, Scratch, Surfaces};
use surefoot_planner::motion::graph::Graph;
use surefoot_planner::possibility::{
    self, Context, Growth, Label, Progress, Station, Stooping, Torso,
};
use surefoot_planner::prepare::Preparation;
use surefoot_planner::seeding::Seeding;
use surefoot_planner::stoop::Stoop;
use surefoot_planner::threads::Threads;
use surefoot_shared_types::spatial::{wrap_angle, yaw_of};

/// What stage P reads.
struct Site {
    case: Case,
    constraints: Constraints,
    surfaces: Surfaces,
    torso: Torso,
    preparation: Preparation<'static>,
    threads: Threads,
}

impl Site {
    fn context(&self, seed: u64) -> Context<'_> {
        Context {
            constraints: &self.constraints,
            surfaces: &self.surfaces,
            torso: &self.torso,
            preparation: &self.preparation,
            seed,
            feet_apart: self.case.scenario.start.feet_apart,
            threads: &self.threads,
            is_step: surefoot_planner::seeding::is_step,
        }
    }
}

/// A case, compiled for stage P alone.
struct Compiled {
    site: Site,
    growth: Growth,
}

impl Compiled {
    fn new(case: Case) -> Self {
        Self::with_room_for(4096, case)
    }

    /// The same with an arena of as many vertices.
    fn with_room_for(vertices: usize, case: Case) -> Self {
        let config = &case.scenario.planner;
        let body = Body::new(&case.model, config).unwrap();
        let preparation = preparation_for(&case.model, config);
        let torso = Torso::new(&case.model, &body);
        let collision = CollisionModel::new(&case.model, &case.world, config.clearance).unwrap();
        let placement = FootPlacementConfig::default();
        let (bounds, ends) =
            (collision.world_bounds(), [&case.scenario.start, &case.scenario.goal]);
        let growth = Growth::new(ends, config.station_spacing, vertices, &bounds, &placement);
        let surfaces = Surfaces::new(&case.world, placement).unwrap();
        let constraints = Constraints { body, collision, config: config.clone() };
        Self {
            site: Site {
                case,
                constraints,
                surfaces,
                torso,
                preparation,
                threads: Threads::default(),
            },
            growth,
        }
    }

    /// Advances to a route or to the end of all samples; answers which, and the work spent.
    fn grow(&mut self, seed: u64) -> (Progress, u64) {
        let context = self.site.context(seed);
        let mut work = 0;
        loop {
            let (progress, spent) = self.growth.advance(&context, u64::MAX);
            work += spent;
            if progress != Progress::Growing {
                return (progress, work);
            }
        }
    }

    fn stations(&self) -> Vec<Station> {
        let route = self.growth.route();
        (0..route.stations()).map(|index| route.station(index)).collect()
    }
}

fn walled(seed: u64) -> (Compiled, Progress, u64) {
    let mut compiled =
        Compiled::new(Case::shipped("flat_walk").with_box([2.0, 0.95, 1.0], [0.05, 1.0, 1.0]));
    let (progress, work) = compiled.grow(seed);
    (compiled, progress, work)
}

#[test]
fn an_open_floor_is_crossed_straight_without_a_sample() {
    let mut compiled = Compiled::new(Case::shipped("flat_walk"));
    assert_eq!(compiled.grow(1).0, Progress::Route);
    let (start, goal) = (compiled.site.case.scenario.start, compiled.site.case.scenario.goal);
    let stations = compiled.stations();
    assert_eq!(
        (stations[0], stations[stations.len() - 1]),
        (Station::on(&start), Station::on(&goal))
    );
    assert!(stations.iter().all(|station| station.position.y.abs() < 0.05), "{stations:?}");
}

#[test]
fn a_wall_is_walked_around_with_every_station_where_the_robot_has_room() {
    for seed in 1..6 {
        let (compiled, progress, _) = walled(seed);
        assert_eq!(progress, Progress::Route);
        let stations = compiled.stations();
        let context = compiled.site.context(seed);
        assert!(
            stations.iter().all(|station| context.has_room(station, true)),
            "seed {seed}: {stations:?}"
        );
        for face in [1.95, 2.05] {
            let crossing = stations
                .windows(2)
                .find(|pair| pair[0].position.x <= face && pair[1].position.x > face)
                .unwrap();
            let (from, to) = (crossing[0].position, crossing[1].position);
            let beside = from.lerp(to, (face - from.x) / (to.x - from.x));
            assert!(beside.y < -0.05, "through the wall: {crossing:?}");
        }
    }
}

/// How the robot stoops at each station of a route past a bar across it, whose underside is so high
/// (m).
fn stoops_past_a_bar(underside: f64) -> (Vec<Station>, Vec<Stoop>) {
    let mut compiled = Compiled::new(
        Case::shipped("flat_walk").with_box([1.6, 0.0, underside + 0.025], [0.025, 1.0, 0.025]),
    );
    assert_eq!(compiled.grow(1).0, Progress::Route);
    let (route, Site { constraints, torso, threads, .. }) =
        (compiled.growth.route(), &compiled.site);
    let mut stooping = Stooping::new(route.stations());
    stooping.begin();
    if !route.is_upright() {
        let site = possibility::Site {
            body: &constraints.body,
            torso,
            collision: &constraints.collision,
            threads,
        };
        while !stooping.advance(&site, route, 1).1 {}
    }
    (compiled.stations(), (0..route.stations()).map(|station| stooping.stoop(station)).collect())
}

#[test]
fn the_robot_stoops_where_something_hangs_low_and_nowhere_else() {
    assert!(stoops_past_a_bar(2.0).1.iter().all(|stoop| *stoop == Stoop::UPRIGHT));
    for underside in [1.4, 1.25, 1.15] {
        let (stations, stoops) = stoops_past_a_bar(underside);
        let is_low = |(station, _): &(&Station, &Stoop)| (station.position.x - 1.6).abs() < 0.15;
        assert!(
            stations.iter().zip(&stoops).filter(is_low).all(|(_, stoop)| stoop.depth() > 0.0),
            "{underside} m: {stoops:?}"
        );
        assert_eq!(
            [stoops[0], stoops[stoops.len() - 1]],
            [Stoop::UPRIGHT; 2],
            "{underside} m: {stoops:?}"
        );
    }
}

/// Stations inside a slit 0.45 m wide: the robot does not pass it as it walks ahead, unless it
/// draws in its arms.
fn stations_in_a_slit(seed: u64) -> (Compiled, Vec<Station>) {
    let wall = |side: f64| ([2.0, side * (0.225 + 1.5), 1.0], [0.25, 1.5, 1.0]);
    let (left, right) = (wall(1.0), wall(-1.0));
    let mut compiled = Compiled::new(
        Case::shipped("ibeam_hallway").with_box(left.0, left.1).with_box(right.0, right.1),
    );
    assert_eq!(compiled.grow(seed).0, Progress::Route);
    let within = compiled
        .stations()
        .into_iter()
        .filter(|station| (station.position.x - 2.0).abs() < 0.2)
        .collect();
    (compiled, within)
}

#[test]
fn a_slit_narrower_than_the_shoulders_is_passed_sideways() {
    let mut sideways = 0;
    for seed in 1..13 {
        let (compiled, within) = stations_in_a_slit(seed);
        let context = compiled.site.context(seed);
        let has_room = within.iter().all(|station| context.has_room(station, false));
        let is_sideways = within.iter().all(|station| libm::sin(station.yaw).abs() > 0.7);
        assert!(!within.is_empty() && has_room == is_sideways, "seed {seed}: {within:?}");
        sideways += u32::from(is_sideways);
    }
    assert!(sideways >= 10, "{sideways} of 12");
}

#[test]
fn stations_are_within_a_step_of_each_other_and_have_placements_for_both_feet() {
    let (compiled, _, _) = walled(3);
    let stations = compiled.stations();
    for (index, pair) in stations.windows(2).enumerate() {
        assert!(pair[0].way_to(&pair[1]).length() < 0.75, "{pair:?}");
        if index > 0 {
            let placements = compiled.growth.placements(index);
            assert!(
                [0, 1].iter().all(|&limb| placements.iter().any(|placed| placed.limb == limb)),
                "station {index}"
            );
        }
    }
}

#[test]
fn a_gap_that_no_step_bridges_is_not_on_a_route() {
    let mut long = 0;
    for seed in 1..7 {
        let mut compiled = Compiled::new(Case::shipped("jungle_gym_spiral_route"));
        assert_eq!(compiled.grow(seed).0, Progress::Route);
        let context = compiled.site.context(seed);
        let route = compiled.stations();
        for (index, pair) in
            route.windows(2).enumerate().skip(1).filter(|(index, _)| index + 2 < route.len())
        {
            let [from, to] = [index, index + 1].map(|station| compiled.growth.placements(station));
            long += usize::from(
                pair[0].way_to(&pair[1]).length()
                    > 1.5 * compiled.site.case.scenario.planner.station_spacing,
            );
            assert!(context.has_step_between(from, to), "seed {seed}, station {index}: {pair:?}");
        }
    }
    assert!(long > 0, "no gap was bridged");
}

#[test]
fn the_elevation_follows_stairs_to_the_goal() {
    let mut compiled = Compiled::new(Case::shipped("stairs"));
    assert_eq!(compiled.grow(1).0, Progress::Route);
    let heights: Vec<f64> = compiled.stations().iter().map(|station| station.position.z).collect();
    assert!((heights[heights.len() - 1] - 1.32).abs() < 1e-9);
    assert!(heights.windows(2).all(|pair| (pair[1] - pair[0]).abs() < 0.45), "{heights:?}");
}

#[test]
fn a_deck_is_walked_under_where_there_is_room_and_never_through() {
    // The lower one is too high to step onto, and bars the legs where the root has room above it.
    for (height, expected) in [(2.6, Progress::Route), (0.45, Progress::Exhausted)] {
        let mut compiled =
            Compiled::new(Case::shipped("flat_walk").with_box([2.0, 0.0, height], [0.6, 6.0, 0.1]));
        let progress = compiled.grow(1).0;
        assert_eq!(progress, expected, "a deck at {height} m");
        let is_under = |station: &Station| station.position.z.abs() < 1e-9;
        assert!(
            expected == Progress::Exhausted || compiled.stations().iter().all(is_under),
            "up through the deck at {height} m"
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
fn a_route_keeps_away_from_where_stage_m_gave_up() {
    let mut compiled = Compiled::new(Case::shipped("flat_walk"));
    compiled.grow(1);
    let stations = compiled.stations();
    let given_up = stations[stations.len() / 2];
    compiled.growth.give_up(given_up, 0.25);
    // The first one is walked backward.
    for _ in 0..2 {
        compiled.growth.begin_again();
        assert_eq!(compiled.grow(1).0, Progress::Route);
    }
    assert!(!compiled.growth.route().is_backward());
    assert!(compiled.stations().iter().all(|station| station.distance(&given_up) > 0.2));
}

#[test]
fn the_first_route_anew_is_walked_backward_and_suits_no_foot_that_faces_ahead() {
    let mut compiled = Compiled::new(Case::shipped("flat_walk"));
    compiled.grow(1);
    let ahead = compiled.stations();
    let (middle, sole) = (ahead[ahead.len() / 2], 0.1 * DVec3::Y);
    let beside = |station: Station, turn: f64| Station {
        position: station.position + sole,
        yaw: station.yaw + turn,
    };
    assert!(
        [0.0, PI].iter().all(|&turn| compiled.growth.route().suits(&beside(middle, turn))),
        "a way ahead suits all"
    );
    compiled.growth.begin_again();
    assert_eq!(compiled.grow(1).0, Progress::Route);
    let (route, backward) = (compiled.growth.route(), compiled.stations());
    assert!(route.is_backward());
    assert_eq!(
        [backward[0].yaw, backward[backward.len() - 1].yaw],
        [ahead[0].yaw, ahead[ahead.len() - 1].yaw]
    );
    let is_turned = |station: &Station| wrap_angle(station.yaw - middle.yaw).abs() > 3.0;
    let inside = |station: &Station| (2.0..8.0).contains(&station.position.x);
    assert!(backward.iter().filter(|station| inside(station)).all(is_turned));
    assert!(
        route.suits(&beside(middle, PI))
            && !route.suits(&beside(middle, 0.0))
            && route.suits(&beside(ahead[0], 0.0))
    );
}

#[test]
fn a_detour_changes_the_stations_between_its_ends_and_no_others() {
    let mut compiled = Compiled::new(Case::shipped("flat_walk"));
    compiled.grow(1);
    let before = compiled.stations();
    compiled.growth.give_up(before[14], 0.25);
    compiled.growth.begin_detour([10, 18]);
    assert_eq!(compiled.grow(1).0, Progress::Route);
    let after = compiled.stations();
    assert_eq!(before[..=10], after[..=10]);
    assert_eq!(before[18..], after[after.len() - (before.len() - 18)..]);
    assert!(after.iter().all(|station| station.distance(&before[14]) > 0.2));
}

#[test]
fn an_island_out_of_reach_spends_all_samples_or_fills_the_trees() {
    for (vertices, ending) in [(4096, Progress::Exhausted), (1024, Progress::Full)] {
        let mut compiled = Compiled::with_room_for(vertices, Case::shipped("no_way_island"));
        assert_eq!(compiled.grow(1).0, ending, "room for {vertices} vertices");
    }
}

#[test]
fn the_same_seed_grows_the_same_route_and_another_one_another() {
    let [first, again, other] = [3, 3, 4].map(|seed| {
        let (compiled, _, work) = walled(seed);
        (compiled.stations(), work)
    });
    assert_eq!(first, again);
    assert_ne!(first, other);
}

#[test]
fn edges_are_possible_where_there_is_room_for_primitives_and_nowhere_else() {
    let mut open = Compiled::new(Case::shipped("flat_walk"));
    assert_eq!(open.grow(1).0, Progress::Route);
    let labelled = open.growth.route().labelled();
    // Nobody said on what the robot stands at the ends.
    assert!(labelled.edges > 30 && labelled.possible + 2 == labelled.edges, "{labelled:?}");
    let mut barred =
        Compiled::new(Case::shipped("flat_walk").with_box([4.0, 0.0, 0.05], [0.02, 1.0, 0.05]));
    assert_eq!(barred.grow(1).0, Progress::Route);
    let route = barred.growth.route();
    for station in 2..route.stations() - 1 {
        let is_near = (route.station(station).position.x - 4.0).abs() < 0.1;
        let is_far = (route.station(station).position.x - 4.0).abs() > 1.0;
        assert!(!(is_near && route.label(station).is_possible()), "{station}");
        assert!(!is_far || matches!(route.label(station), Label::Primitive { .. }), "{station}");
    }
    assert!(barred.growth.labelled().possible < barred.growth.labelled().edges);
}

#[test]
fn what_stage_m_has_crossed_is_possible_and_used_again() {
    let mut compiled =
        Compiled::new(Case::shipped("flat_walk").with_box([2.0, 0.0, 0.05], [0.02, 1.0, 0.05]));
    assert_eq!(compiled.grow(1).0, Progress::Route);
    let before = compiled.stations();
    let indeterminate = (1..before.len())
        .find(|&station| compiled.growth.route().label(station) == Label::Indeterminate)
        .unwrap();
    let reached = indeterminate + 3;
    compiled.growth.note_crossed(reached);
    assert_eq!(compiled.growth.route().label(indeterminate), Label::Crossed);
    compiled.growth.give_up(before[reached + 5], 0.25);
    compiled.growth.begin_again();
    assert_eq!(compiled.grow(1).0, Progress::Route);
    let after = compiled.stations();
    assert_eq!(after[..=indeterminate], before[..=indeterminate]);
    assert!(after.iter().all(|station| station.distance(&before[reached + 5]) > 0.2));
    assert_eq!(compiled.growth.route().label(indeterminate), Label::Crossed);
}

/// The placements with the toes turned out along the route of a shipped scenario.
fn turned_out(name: &str) -> Graph {
    let mut compiled = Compiled::new(Case::shipped(name));
    assert_eq!(compiled.grow(1).0, Progress::Route);
    let Compiled { site, growth } = &compiled;
    let steps = site.preparation.possible_steps();
    let seeding =
        Seeding { constraints: &site.constraints, surfaces: &site.surfaces, steps, seed: 1 };
    let (mut graph, mut scratch) =
        (Graph::new(4096, 1, 1, 1.0), Scratch::new(&FootPlacementConfig::default()));
    for place in (0..growth.route().stations()).flat_map(|station| [(station, 0), (station, 1)]) {
        seeding.turn_out(growth.route(), place, 0, &mut graph, &mut scratch).unwrap();
    }
    graph
}

#[test]
fn toes_are_turned_out_on_steep_stairs_and_nowhere_else() {
    let graph = turned_out("stairs");
    let heights: Vec<f64> =
        graph.footholds().iter().map(|foothold| foothold.world_from_sole.translation.z).collect();
    assert!(
        (1..6).all(|step| heights
            .iter()
            .any(|height| (height - 0.22 * f64::from(step)).abs() < 1e-6)),
        "{heights:?}"
    );
    let out = |limb: usize| if limb == 0 { 1.0 } else { -1.0 };
    let turns = graph
        .footholds()
        .iter()
        .map(|foothold| out(foothold.limb) * yaw_of(foothold.world_from_sole.rotation));
    assert!(
        turns.clone().any(|turn| (turn - 0.5).abs() < 0.05)
            && turns.into_iter().all(|turn| turn > -0.35)
    );
    for level_or_low in ["flat_walk", "stairs_bauzil"] {
        assert_eq!(turned_out(level_or_low).footholds().len(), 0, "{level_or_low}");
    }
}
