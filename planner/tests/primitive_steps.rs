//! Omega_M: along the possible edges of a guide route the plan consists of primitives, and each of
//! them meets every constraint [Grey 3.2, 4.4.5].

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test ends where a shipped file does not load; the long one reports"
)]

mod common;

use common::{Case, run};
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::plan::self_check::self_check;
use surefoot_planner::{Outcome, Planner};

#[test]
fn an_open_floor_is_walked_by_primitives_alone() {
    let mut planner = Case::shipped("flat_walk").planner(1);
    assert_eq!(run(&mut planner, u64::MAX), Outcome::Found);
    let stats = planner.stats();
    assert!(
        stats.route_edges.edges > 30 && stats.route_edges.possible == stats.route_edges.edges,
        "{stats:?}"
    );
    // Each foot steps past the other. pi_N adds the motions from the start and to the goal, where
    // the robot stands on both feet.
    assert_eq!(
        (stats.primitives, stats.primitives_failed, stats.transitions_found, stats.motions_found),
        (2 * planner.steps(), 0, 0, 2)
    );
}

#[test]
fn an_edge_beside_an_obstacle_is_left_to_the_search() {
    let open = Case::shipped("flat_walk");
    let mut planner = open.with_box([4.0, 0.0, 0.03], [0.03, 1.0, 0.03]).planner(1);
    assert_eq!(run(&mut planner, u64::MAX), Outcome::Found);
    let stats = planner.stats();
    assert!(
        stats.route_edges.possible < stats.route_edges.edges && stats.route_edges.possible > 10,
        "{stats:?}"
    );
    assert!(
        stats.primitives > 20 && stats.motions_found > 2 && stats.primitives_failed == 0,
        "{stats:?}"
    );
    assert!(self_check(planner.constraints(), planner.chunks()).is_ok());
}

/// The floor with low and high boxes on it, some of them under the feet.
fn littered(seed: u64) -> Planner {
    let mut random = Random::new(seed, Stream::Preparation, 9, 0);
    let mut case =
        Case::shipped("flat_walk").with_seed(seed).configured(|planner| planner.work_max = 60_000);
    for _ in 0..5 {
        let height = if random.below(3) == 0 {
            random.uniform(0.1, 0.9)
        } else {
            random.uniform(0.002, 0.06)
        };
        let position = [random.uniform(1.2, 8.8), random.uniform(-0.9, 0.9), height];
        let half = [random.uniform(0.02, 0.5), random.uniform(0.02, 0.5), height];
        case = case.with_box(position, half);
    }
    case.planner(2)
}

/// Plans over littered floors and checks every plan completely. Returns the number of primitives.
fn primitives_hold(seeds: std::ops::Range<u64>) -> u64 {
    let mut primitives = 0;
    for seed in seeds {
        let mut planner = littered(seed);
        let outcome = run(&mut planner, u64::MAX);
        let stats = planner.stats();
        assert_eq!(stats.primitives_failed, 0, "seed {seed}");
        if outcome == Outcome::Found {
            let checked = self_check(planner.constraints(), planner.chunks());
            assert!(checked.is_ok(), "seed {seed}: {checked:?}");
            primitives += stats.primitives;
        }
    }
    primitives
}

#[test]
fn primitives_of_the_search_meet_every_constraint() {
    let primitives = primitives_hold(1..9);
    assert!(primitives > 150, "{primitives}");
}

/// `cargo test --release -p surefoot-planner --test primitive_steps -- --ignored --nocapture`
#[test]
#[ignore = "takes minutes"]
fn thousands_of_primitives_of_the_search_hold() {
    let primitives = primitives_hold(100..300);
    println!("{primitives} primitives held");
    assert!(primitives > 4_000, "{primitives}");
}
