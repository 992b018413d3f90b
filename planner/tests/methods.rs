//! The methods that the planner is compared with: what they find, what they cannot express, and
//! that they keep the planner's promises.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

mod common;

use std::num::NonZeroUsize;

use common::{Case, preparation_for, run};
use surefoot_planner::methods::method::{Method, MethodParameters};
use surefoot_planner::{Outcome, Planner};
use surefoot_shared_types::base::digest::Digest;

/// A short walk over a floor.
fn floor() -> Case {
    let mut case = Case::shipped("flat_walk");
    case.scenario.goal.position = case.scenario.start.position + 0.9 * glam::DVec3::X;
    case.configured(|planner| planner.work_max = 400_000)
}

fn planner(case: &Case, method: Method, parameters: MethodParameters, threads: usize) -> Planner {
    let preparation = preparation_for(&case.model, &case.scenario.planner);
    Planner::builder(&case.model, &case.world, &case.scenario, preparation)
        .uncapped_threads(NonZeroUsize::new(threads).unwrap())
        .method(method, parameters)
        .build()
        .unwrap()
}

/// The outcome, and the digest of the plan.
fn plan(case: &Case, method: Method, threads: usize, work: u64) -> (Outcome, Digest) {
    let mut planner = planner(case, method, MethodParameters::default(), threads);
    let outcome = run(&mut planner, work);
    (outcome, planner.digest())
}

#[test]
fn every_method_walks_over_a_floor() {
    let case = floor();
    let mut digests = vec![];
    for method in Method::ALL {
        let (outcome, digest) = plan(&case, method, 1, u64::MAX);
        assert_eq!(outcome, Outcome::Found, "{}", method.name());
        let others = [plan(&case, method, 2, 5_000), plan(&case, method, 4, u64::MAX)];
        assert_eq!(others, [(outcome, digest); 2], "{} on other threads", method.name());
        digests.push(digest);
    }
    let count = digests.len();
    digests.sort_unstable_by_key(|digest| digest.0);
    digests.dedup();
    assert_eq!(digests.len(), count - 1, "on a level floor nothing is adapted: both A* agree");
}

#[test]
fn threads_change_no_method_in_harder_worlds_either() {
    for (name, work_max) in [("stepping_stones", 12_000), ("pass_under", 6_000)] {
        let case = Case::shipped(name).configured(|planner| planner.work_max = work_max);
        for method in Method::ALL {
            let ending = |threads, work| {
                let mut planner = planner(&case, method, MethodParameters::default(), threads);
                (run(&mut planner, work), planner.digest(), planner.stats().work)
            };
            let alone = ending(1, u64::MAX);
            assert_eq!([ending(2, 1_000), ending(4, u64::MAX)], [alone; 2], "{name} {method:?}");
        }
    }
}

#[test]
fn w_rpg_fails_where_its_samples_hold_no_walk() {
    let few = MethodParameters { placements: 3, rounds_max: 1, ..MethodParameters::default() };
    let mut planner = planner(&floor(), Method::WRpg, few, 1);
    let outcome = run(&mut planner, u64::MAX);
    assert_eq!(outcome, Outcome::MethodExhausted("its samples hold no walk"));
    assert!(planner.stats().routes == 1 && planner.chunks().is_empty());
    assert!(planner.stats().work < 100_000, "{} units", planner.stats().work);
}

#[test]
fn discs_smaller_than_the_steps_still_cover_the_route() {
    let parameters = MethodParameters { disc_radius_share: 0.375, ..MethodParameters::default() };
    for seed in 1..=2 {
        let case = Case::shipped("stepping_stones").with_seed(seed);
        let case = case.configured(|planner| planner.work_max = 60_000);
        let outcome = run(&mut planner(&case, Method::WRpg, parameters, 2), u64::MAX);
        assert_eq!(outcome, Outcome::Found, "seed {seed}");
    }
}

#[test]
fn w_rpg_and_mmprm_say_that_they_cannot_express_stairs() {
    let case = Case::shipped("stairs");
    for method in [Method::WRpg, Method::Mmprm] {
        let (outcome, _) = plan(&case, method, 1, u64::MAX);
        assert!(matches!(outcome, Outcome::NotExpressible(_)), "{outcome:?}");
        assert!(outcome.describe().contains("level ground"), "{}", outcome.describe());
    }
}

#[test]
fn footsteps_climb_regular_stairs() {
    let case = Case::shipped("stairs_bauzil").configured(|planner| planner.work_max = 400_000);
    assert_eq!(plan(&case, Method::AstarAdaptive, 2, u64::MAX).0, Outcome::Found);
}

#[test]
fn bounding_boxes_take_primitives_alone() {
    let free = floor();
    let mut planner = planner(&free, Method::BoundingBox, MethodParameters::default(), 1);
    assert_eq!(run(&mut planner, u64::MAX), Outcome::Found);
    // A sill that a foot steps over needs more than the expanded geometry allows.
    let start = free.scenario.start.position;
    let sill = floor().with_box([start.x + 0.45, start.y, 0.06], [0.03, 3.0, 0.06]);
    let (outcome, _) = plan(&sill, Method::BoundingBox, 1, u64::MAX);
    assert_ne!(outcome, Outcome::Found, "{outcome:?}");
}

#[test]
fn names_are_those_of_the_command_line() {
    for method in Method::ALL {
        assert_eq!(Method::from_name(method.name()), Some(method));
    }
    assert_eq!(Method::from_name("other"), None);
}
