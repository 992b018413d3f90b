//! The improvement of a plan: it never worsens one, keeps to its work, and gives the same bytes on
//! any number of threads and in steps of any size.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

mod common;

use std::num::NonZeroUsize;

use common::{Case, preparation_for};
use surefoot_planner::{Outcome, Planner, Status};
use surefoot_shared_types::message::PlanChunk;

/// Work units of most tests: several windows and a whole walk.
const WORK: u64 = 60_000;
/// Work by which a search exceeds its limit at most: the timing of one window is one piece.
const PIECE_MAX: u64 = 8_000;

fn planner(case: &Case, work: u64, threads: usize) -> Planner {
    let preparation = preparation_for(&case.model, &case.scenario.planner);
    Planner::builder(&case.model, &case.world, &case.scenario, preparation)
        .uncapped_threads(NonZeroUsize::new(threads).unwrap())
        .improve(work)
        .build()
        .unwrap()
}

fn found(planner: &mut Planner, work_per_step: u64) {
    loop {
        if let Status::Done(outcome) = planner.step(work_per_step) {
            assert_eq!(outcome, Outcome::Found);
            return;
        }
    }
}

fn seconds(planner: &Planner) -> f64 {
    planner.chunks().last().and_then(|chunk| chunk.waypoints().last()).unwrap().time
}

/// Whether the chunks are one stream.
fn is_joined(chunks: &[PlanChunk]) -> bool {
    let stream = |pair: &[PlanChunk]| pair[1].stream == pair[0].stream_after();
    let ends = |pair: &[PlanChunk]| {
        let (last, first) = (pair[0].waypoints().last().unwrap(), pair[1].waypoints()[0]);
        last == &first
    };
    let sequence = |(index, chunk): (usize, &PlanChunk)| chunk.sequence == index as u64;
    chunks.windows(2).all(|pair| stream(pair) && ends(pair))
        && chunks.iter().enumerate().all(sequence)
}

#[test]
fn walks_along_beams_take_less_time() {
    let improvements = [1, 2, 3, 4, 5].map(|seed| {
        let case = Case::smooth("ibeam_hallway").with_seed(seed);
        let mut first = planner(&case, 0, 1);
        found(&mut first, u64::MAX);
        assert_eq!(first.improvement(), None);
        let mut better = planner(&case, 100_000, 2);
        found(&mut better, u64::MAX);
        let improvement = better.improvement().unwrap();
        assert_eq!(improvement.first_seconds, seconds(&first));
        assert_eq!(improvement.first_work, first.stats().work);
        assert_eq!(improvement.seconds, seconds(&better));
        assert!(improvement.seconds <= improvement.first_seconds, "{improvement:?}");
        assert!(improvement.rounds > improvement.kept, "{improvement:?}");
        assert!(is_joined(better.chunks()));
        assert!(better.steps() > 0 && better.waypoints() > 0);
        let sum: u64 = better.stats().work_by_category.iter().sum();
        assert_eq!(sum, better.stats().work, "all work has a category");
        improvement
    });
    let before: f64 = improvements.iter().map(|improvement| improvement.first_seconds).sum();
    let after: f64 = improvements.iter().map(|improvement| improvement.seconds).sum();
    assert!(after < 0.97 * before, "{improvements:?}");
    let kept = improvements.iter().filter(|improvement| improvement.kept > 0).count();
    assert!(kept >= 3, "{improvements:?}");
}

#[test]
fn the_result_depends_on_neither_threads_nor_steps() {
    let case = Case::smooth("ibeam_hallway");
    let digests = [(1, u64::MAX), (2, 700), (4, u64::MAX), (1, 5_003)].map(|(threads, step)| {
        let mut planner = planner(&case, WORK, threads);
        found(&mut planner, step);
        (planner.digest(), planner.improvement())
    });
    assert!(digests.iter().all(|digest| *digest == digests[0]), "{digests:?}");
}

#[test]
fn no_work_gives_the_first_plan_and_none_gives_a_longer_walk() {
    let case = Case::smooth("stairs_bauzil");
    let mut first = planner(&case, 0, 1);
    found(&mut first, u64::MAX);
    let before = seconds(&first);
    for work in [1, 5_000, 40_000] {
        let mut planner = planner(&case, work, 2);
        found(&mut planner, u64::MAX);
        let improvement = planner.improvement().unwrap();
        assert!(seconds(&planner) <= before, "{work}: {improvement:?}");
        assert_eq!(improvement.kept > 0, planner.digest() != first.digest());
        assert!(improvement.work <= work + PIECE_MAX, "{improvement:?}");
    }
}

#[test]
fn the_limit_of_the_search_holds_for_its_improvement() {
    let case = Case::smooth("stairs_bauzil");
    let mut first = planner(&case, 0, 1);
    found(&mut first, u64::MAX);
    let work_max = first.stats().work + 20_000;
    let case = case.configured(|planner| planner.work_max = work_max);
    let mut planner = planner(&case, u64::MAX, 1);
    found(&mut planner, u64::MAX);
    assert!(planner.stats().work <= work_max + PIECE_MAX, "{}", planner.stats().work);
    assert!(seconds(&planner) <= seconds(&first));
}

#[test]
fn an_improvement_that_is_stopped_gives_the_best_plan_so_far() {
    let case = Case::smooth("ibeam_hallway");
    let mut planner = planner(&case, u64::MAX / 2, 2);
    assert!(!planner.stop_improving(), "there is no plan yet");
    while planner.improvement().is_none_or(|improvement| improvement.rounds < 4) {
        assert_eq!(planner.step(1_000), Status::Working);
        assert!(planner.final_chunks().is_empty(), "a chunk may still change");
    }
    assert!(planner.stop_improving() && !planner.stop_improving());
    assert_eq!(planner.step(1_000), Status::Done(Outcome::Found));
    let improvement = planner.improvement().unwrap();
    assert_eq!(improvement.seconds, seconds(&planner));
    assert!(improvement.seconds <= improvement.first_seconds && is_joined(planner.chunks()));
}
