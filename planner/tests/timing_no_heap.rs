//! Timing allocates no memory once it is built. The test is alone in its file because the allocator
//! counts for the whole process.

#![allow(clippy::unwrap_used, reason = "a test ends where a shipped file does not load")]

#[path = "common/allocations.rs"]
mod allocations;
mod common;
#[path = "common/smooth_walk.rs"]
mod smooth_walk;
#[path = "common/walk_timing.rs"]
mod walk_timing;

use smooth_walk::smooth_walk;
use surefoot_planner::timing::load_sharing::LoadSchedule;
use surefoot_shared_types::config::ExecutionConfig;

#[test]
fn timing_allocates_no_memory() {
    let model = common::hubo();
    let walk = smooth_walk(&model, 2, 0.12);
    let path = walk.path();
    let mut timing = walk.timing(&model, &ExecutionConfig::default());
    let before = allocations::count_of_thread();
    let mut brake_after = 0.0;
    for _ in 0..2 {
        assert!(walk.solve(&mut timing));
        brake_after = 0.0;
        for span in 0..walk.spans.len() {
            let times = timing.span_times(span);
            for index in 0..=times.intervals {
                std::hint::black_box(timing.waypoint(
                    path,
                    span,
                    (&times, index),
                    &LoadSchedule::beside(&[], path.spans, span),
                ));
            }
            for chunk in 0..times.chunks() {
                brake_after = timing.stop(span, chunk).unwrap().brake_at;
            }
        }
    }
    assert_eq!(allocations::count_of_thread(), before);
    assert!(brake_after > 0.0);
    drop(std::hint::black_box(Box::new(1)));
    assert_eq!(allocations::count_of_thread(), before + 1, "the allocator counts");
}
