//! Queries do not allocate, and items dropped from full lists are counted.

#![allow(clippy::unwrap_used, reason = "a test ends where its world does not compile")]

#[path = "common/allocations.rs"]
mod allocations;
mod foot_placement_worlds;

use foot_placement_worlds::*;
use surefoot_planner::foot_placement::{
    FootPlacementConfig, PlacementQuery, SampleLimits, Scratch, Surfaces, propose,
};

#[test]
fn queries_do_not_allocate_and_count_what_they_drop() {
    let polygon = sole();
    let worlds = [vec![floor()], ibeams(), round_bars(12), stairs(), spiral(), vec![rubble(200)]];
    for (i, shapes) in worlds.into_iter().enumerate() {
        let surfaces = surfaces(shapes);
        let mut scratch = Scratch::new(surfaces.config());
        let before = allocations::count_of_thread();
        for object in 0..20 {
            let ideal = turned(0.05 * object as f64, 0.1, 0.2, 0.3 * object as f64);
            let limits = SampleLimits { sampled_max: 500, ..SampleLimits::default() };
            let query = PlacementQuery { object, limits, ..query(&polygon, ideal) };
            propose(&surfaces, &mut scratch, &query, &mut |_| true);
            let _either_way = surfaces.support(&mut scratch, &polygon, &ideal);
        }
        assert_eq!(allocations::count_of_thread() - before, 0, "world {i}");
    }
    a_small_scratch_counts_what_it_drops();
}

fn a_small_scratch_counts_what_it_drops() {
    let config = FootPlacementConfig {
        features_max: 2,
        planes_max: 1,
        candidates_max: 3,
        intersection_points_max: 5,
        ..Default::default()
    };
    let surfaces = Surfaces::new(&world(ibeams()), config.clone()).unwrap();
    let mut scratch = Scratch::new(&config);
    let polygon = sole();
    let before = allocations::count_of_thread();
    propose(&surfaces, &mut scratch, &query(&polygon, at(0.0, 0.0, 0.2)), &mut |_| true);
    assert_eq!(allocations::count_of_thread(), before);
    assert!(scratch.dropped() > 0);
}
