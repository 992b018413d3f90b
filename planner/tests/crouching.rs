//! Under obstacles lower than the robot is tall, a crouch profile makes the walk possible.

mod common;

use common::{Case, run};
use surefoot_planner::Outcome;

/// Limit of the search, work units. Without a crouch profile 4 million find no plan.
const WORK_MAX: u64 = 400_000;

/// `pass_under` with its bars 0.1 m lower: two at 1.20 m and one at 1.10 m, for a robot 1.5 to
/// 1.6 m tall.
fn lowered() -> Case {
    let mut case = Case::shipped("pass_under").configured(|config| config.work_max = WORK_MAX);
    let bars: Vec<_> =
        case.world.shapes.iter_mut().filter(|shape| shape.name.starts_with("bar_")).collect();
    assert_eq!(bars.len(), 3);
    bars.into_iter().for_each(|bar| bar.world_from_shape.translation.z -= 0.1);
    case
}

/// A level floor with a slab above its middle 1.4 m, its underside at a height, m.
fn under_a_slab(underside: f64) -> Case {
    Case::shipped("flat_walk")
        .with_box([1.5, 0.0, underside + 0.1], [0.7, 1.0, 0.1])
        .configured(|config| config.work_max = WORK_MAX)
}

#[test]
fn a_robot_passes_under_lowered_bars() {
    for seed in 1..5 {
        let mut planner = lowered().with_seed(seed).planner(1);
        assert_eq!(run(&mut planner, 4096), Outcome::Found, "seed {seed}");
        let is_low = |chunk: &surefoot_shared_types::message::PlanChunk| {
            chunk.waypoints().iter().any(|waypoint| waypoint.world_from_root().translation.z < 0.7)
        };
        assert!(planner.chunks().iter().any(is_low), "seed {seed}: the root stays high");
    }
}

#[test]
fn a_robot_walks_under_a_low_slab() {
    for seed in 1..4 {
        assert_eq!(
            run(&mut under_a_slab(1.25).with_seed(seed).planner(1), 4096),
            Outcome::Found,
            "seed {seed}"
        );
    }
}

#[test]
fn threads_do_not_change_the_crouch_profile() {
    let digests = [1, 2].map(|threads| {
        let mut planner = lowered().planner(threads);
        run(&mut planner, 1 + 4095 * (threads as u64 - 1));
        (planner.digest(), planner.stats().work)
    });
    assert_eq!(digests[0], digests[1]);
}
