//! Omega_M: along the possible edges of a guide route the plan is made of primitives, and every one
//! of them meets every constraint [Grey 3.2, 4.4.5].

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
    let tally = planner.stats();
    assert!(
        tally.route_edges.edges > 30 && tally.route_edges.possible == tally.route_edges.edges,
        "{tally:?}"
    );
    // Each foot steps past the other; what pi_N adds is from the start and to the goal, where the
    // robot stands on both feet.
    assert_eq!(
        (tally.primitives, tally.primitives_failed, tally.transitions_found, tally.motions_found),
        (2 * planner.steps(), 0, 0, 2)
    );
}

#[test]
fn an_edge_beside_an_obstacle_is_left_to_the_search() {
    let open = Case::shipped("flat_walk");
    let mut planner = open.with_box([4.0, 0.0, 0.03], [0.03, 1.0, 0.03]).planner(1);
    assert_eq!(run(&mut planner, u64::MAX), Outcome::Found);
    let tally = planner.stats();
    assert!(
        tally.route_edges.possible < tally.route_edges.edges && tally.route_edges.possible > 10,
        "{tally:?}"
    );
    assert!(
        tally.primitives > 20 && tally.motions_found > 2 && tally.primitives_failed == 0,
        "{tally:?}"
    );
    assert!(self_check(planner.constraints(), planner.chunks()).is_ok());
}

/// The floor with boxes lying and standing about on it, and a box or two under the feet.
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
        let place = [random.uniform(1.2, 8.8), random.uniform(-0.9, 0.9), height];
        let half = [random.uniform(0.02, 0.5), random.uniform(0.02, 0.5), height];
        case = case.with_box(place, half);
    }
    case.planner(2)
}

/// Plans over littered floors and checks all of every plan; answers how many primitives there were.
fn primitives_hold(seeds: std::ops::Range<u64>) -> u64 {
    let mut primitives = 0;
    for seed in seeds {
        let mut planner = littered(seed);
        let outcome = run(&mut planner, u64::MAX);
        let tally = planner.stats();
        assert_eq!(tally.primitives_failed, 0, "seed {seed}");
        if outcome == Outcome::Found {
            let checked = self_check(planner.constraints(), planner.chunks());
            assert!(checked.is_ok(), "seed {seed}: {checked:?}");
            primitives += tally.primitives;
        }
    }
    primitives
}

#[test]
fn primitives_of_the_search_meet_every_constraint() {
    let primitives = primitives_hold(1..9);
    assert!(primitives > 150, "{primitives}");
}

/// `cargo test --release -p surefoot-planner --test primitive_stretches -- --ignored --nocapture`
#[test]
#[ignore = "takes minutes"]
fn thousands_of_primitives_of_the_search_hold() {
    let primitives = primitives_hold(100..300);
    println!("{primitives} primitives held");
    assert!(primitives > 4_000, "{primitives}");
}
