//! The same inputs give the same plan, byte for byte: however often, on however many threads, in
//! however large steps, and in every build.
//!
//! The digests in `tests/data/golden_digests.txt` are those of the shipped scenarios with their
//! shipped seeds. After a change that is meant to change plans,
//! `SUREFOOT_BLESS=1 cargo test --release -p surefoot-planner --test determinism` rewrites them.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use std::collections::BTreeMap;
use std::path::PathBuf;
use std::sync::atomic::{AtomicBool, Ordering};

use common::{Case, WALKS, repository, run};
use surefoot_planner::Outcome;
use surefoot_planner::pipeline::SearchStats;
use surefoot_shared_types::base::digest::Digest;

const GOLDEN: &str = "tests/data/golden_digests.txt";
/// Searched in every build.
const QUICK: [&str; 15] = [
    "bars_thin",
    "bars_uneven",
    "bars_wide",
    "beam",
    "checkers",
    "cinder_blocks",
    "flat_walk",
    "hallway_high",
    "ibeam_gap",
    "ibeam_hallway",
    "monkey_bars",
    "rough_ground",
    "stairs",
    "stairs_bauzil",
    "stepping_stones",
];
/// Searched where the build is optimised; without, they take minutes.
const LONG: [&str; 24] = [
    "beam_narrow",
    "cinder_blocks_steep",
    "cluttered_beam",
    "cluttered_stairs",
    "detour_3",
    "gauntlet_1",
    "gauntlet_2",
    "gym_hard",
    "hallway_plates",
    "jungle_gym_full",
    "jungle_gym_spiral_route",
    "jungle_gym_stair_route",
    "no_way_ceiling",
    "no_way_island",
    "no_way_slope",
    "no_way_wall",
    "pass_under",
    "sl1m_complex",
    "spiral_high",
    "spiral_small",
    "spiral_steps",
    "stairs_nosing",
    "stairs_steep",
    "stairs_steepest",
];
/// Take long in every build: long walks, and a search that finds none.
const LEFT_OUT: [&str; 8] = [
    "detour_11",
    "detour_4",
    "detour_5",
    "detour_6",
    "detour_8",
    "gauntlet_4",
    "gauntlet_8",
    "pass_under_low",
];
const STEP: u64 = 20_000;

/// The scenarios that this build searches.
fn searched() -> Vec<&'static str> {
    if cfg!(debug_assertions) { QUICK.into() } else { [&QUICK[..], &LONG].concat() }
}

fn plan(case: &Case, threads: usize, step: u64) -> (Digest, SearchStats) {
    let mut planner = case.planner(threads);
    assert_eq!(run(&mut planner, step), Outcome::Found, "{}", case.scenario.name);
    (planner.digest(), planner.stats())
}

/// How a search ends, in one line: its outcome, and the digest of the plan or, where there is none,
/// of all that was counted.
fn ending(name: &str, threads: usize) -> String {
    let mut planner = Case::smooth(name).planner(threads);
    let outcome = run(&mut planner, STEP);
    let digest =
        if outcome == Outcome::Found { planner.digest() } else { digest_of(&planner.stats()) };
    format!("{} {digest}", outcome.name())
}

fn digest_of(stats: &SearchStats) -> Digest {
    let SearchStats {
        work,
        work_by_category,
        sequences,
        routes,
        sweeps,
        transitions_found,
        motions_found,
        ..
    } = stats;
    let counts = [
        &[*work, *sequences, *routes, *sweeps, *transitions_found, *motions_found][..],
        work_by_category,
        &stats.rejections,
    ]
    .concat();
    Digest::of(&[bytemuck::cast_slice(&counts)])
}

#[test]
fn a_plan_can_be_made_again() {
    for walk in WALKS {
        let case = Case::shipped(walk);
        assert_eq!(plan(&case, 2, STEP), plan(&case, 2, STEP), "{walk}");
    }
}

#[test]
fn the_number_of_threads_changes_nothing() {
    for walk in WALKS {
        let case = Case::shipped(walk);
        let alone = plan(&case, 1, STEP);
        for threads in [2, 3, 4] {
            assert_eq!(plan(&case, threads, STEP), alone, "{walk} on {threads} threads");
        }
    }
}

#[test]
fn a_smooth_plan_is_the_same_on_any_number_of_threads_and_in_any_steps() {
    for walk in ["stairs_bauzil", "ibeam_hallway"] {
        let case = Case::smooth(walk);
        let alone = plan(&case, 1, STEP);
        assert_eq!(alone.1.beyond_limits, 0, "{walk}");
        for (threads, step) in [(1, 7), (2, STEP), (4, 1_000)] {
            assert_eq!(plan(&case, threads, step), alone, "{walk} on {threads} threads");
        }
    }
}

#[test]
fn helpers_that_come_and_go_change_nothing() {
    /// Ends the busy loops when it is dropped, also by a panic.
    struct LoopGuard<'a>(&'a AtomicBool);
    impl Drop for LoopGuard<'_> {
        fn drop(&mut self) {
            self.0.store(true, Ordering::Relaxed);
        }
    }
    let is_over = AtomicBool::new(false);
    std::thread::scope(|scope| {
        let _guard = LoopGuard(&is_over);
        for _ in 0..4 {
            scope.spawn(|| {
                while !is_over.load(Ordering::Relaxed) {
                    std::hint::spin_loop();
                }
            });
        }
        for walk in WALKS {
            let case = Case::shipped(walk);
            let alone = plan(&case, 1, STEP);
            for threads in [2, 3] {
                assert_eq!(plan(&case, threads, STEP), alone, "{walk} on {threads} threads");
            }
        }
    });
}

#[test]
fn the_size_of_steps_changes_nothing() {
    for walk in WALKS {
        let case = Case::shipped(walk);
        let smallest = plan(&case, 2, 1);
        for step in [1_000, u64::MAX] {
            assert_eq!(plan(&case, 2, step), smallest, "{walk} in steps of {step}");
        }
    }
}

#[test]
fn an_unsuccessful_search_can_be_made_again() {
    let case = Case::shipped("no_way_ceiling").configured(|planner| planner.work_max = 20_000);
    let search = |threads, step| {
        let mut planner = case.planner(threads);
        (run(&mut planner, step), planner.stats())
    };
    let alone = search(1, u64::MAX);
    assert_eq!(search(4, 1), alone);
    assert_eq!(search(2, 777), alone);
}

#[test]
fn another_seed_gives_another_plan() {
    let digests: Vec<Digest> =
        [1, 2, 3].map(|seed| plan(&Case::shipped("ibeam_gap").with_seed(seed), 2, STEP).0).into();
    assert!(digests[0] != digests[1] && digests[1] != digests[2] && digests[0] != digests[2]);
}

#[test]
fn another_seed_moves_the_robot_otherwise_where_it_must_sample() {
    let waypoints = |seed| {
        let mut planner = Case::shipped("stairs").with_seed(seed).planner(2);
        assert_eq!(run(&mut planner, STEP), Outcome::Found);
        let waypoints = planner.chunks().iter().flat_map(|chunk| chunk.waypoints().to_vec());
        waypoints.map(|waypoint| waypoint.root_position).collect::<Vec<_>>()
    };
    let first = waypoints(1);
    assert!(
        (2..=5).any(|seed| waypoints(seed) != first),
        "five seeds, one motion: does the search draw from its streams?"
    );
}

/// The golden file: how the search of each scenario ends.
fn golden() -> (PathBuf, BTreeMap<String, String>) {
    let path = repository().join(GOLDEN);
    let text = std::fs::read_to_string(&path).unwrap_or_default();
    let lines = text.lines().filter_map(|line| line.split_once(' '));
    (path, lines.map(|(name, ending)| (name.to_owned(), ending.to_owned())).collect())
}

#[test]
fn every_build_makes_the_plans_it_always_made() {
    let (path, mut endings) = golden();
    let before = endings.clone();
    endings.retain(|name, _| QUICK.iter().chain(&LONG).any(|known| known == name));
    // The number of threads goes round, so that each occurs.
    let searched = searched().into_iter().zip((1..=4).cycle());
    endings.extend(searched.map(|(name, threads)| (name.to_owned(), ending(name, threads))));
    if std::env::var_os("SUREFOOT_BLESS").is_some() {
        let lines: String =
            endings.iter().map(|(name, ending)| format!("{name} {ending}\n")).collect();
        std::fs::write(&path, lines).unwrap();
    } else {
        assert_eq!(
            endings, before,
            "plans have changed; if they were meant to, bless {GOLDEN} as this test's file says"
        );
    }
}

#[test]
fn every_shipped_scenario_has_a_golden_digest_or_is_known_to_take_too_long() {
    let files = std::fs::read_dir(repository().join("configs/scenarios")).unwrap();
    let mut shipped: Vec<String> = files
        .map(|file| file.unwrap().path().file_stem().unwrap().to_string_lossy().into_owned())
        .collect();
    shipped.sort_unstable();
    let mut known = [&QUICK[..], &LONG, &LEFT_OUT].concat();
    known.sort_unstable();
    assert_eq!(shipped, known);
}
