//! Legs without a closed form: the share of reachable soles that the iteration solves.

#![allow(
    clippy::unwrap_used,
    clippy::print_stdout,
    reason = "a test ends where a shipped file does not load; the long one reports"
)]

mod common;

use common::{hubo, random_positions, with_split_hip};
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::kinematics::Leg;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::RobotModel;

/// Margin to joint limits, rad.
const MARGIN: f64 = 0.005;

/// The share of soles of random postures that are solved from the standing posture. Postures
/// deviate at most by `deviation` (rad) from it.
fn share_solved(model: &RobotModel, deviation: f64, samples: u64) -> f64 {
    let leg = Leg::new(model, 0, MARGIN).unwrap();
    let mut solved = 0;
    for sample in 0..samples {
        let mut random = Random::new(9, Stream::Preparation, 0, sample);
        let mut sampled = random_positions(model, MARGIN, &mut random);
        for ((position, standing), joint) in
            sampled.iter_mut().zip(&model.standing_q).zip(&model.joints)
        {
            let (lower, upper) =
                (joint.lower.max(standing - deviation), joint.upper.min(standing + deviation));
            *position = random.uniform(lower + MARGIN, upper - MARGIN);
        }
        let sole = leg.root_from_sole(&sampled);
        let mut q = model.standing_q.clone();
        if leg.solve(&sole, &mut q) {
            solved += 1;
            assert!(
                leg.root_from_sole(&q).translation.distance(sole.translation) < 1e-8,
                "sample {sample}"
            );
            assert!(
                leg.joints().iter().all(|joint| joint.is_within_limits(q[joint.index])),
                "sample {sample}"
            );
        }
    }
    solved as f64 / samples as f64
}

#[test]
fn soles_of_walking_postures_are_solved_from_the_standing_posture() {
    let model = with_split_hip(&hubo());
    let (walking, anywhere) =
        (share_solved(&model, 0.7, 5_000), share_solved(&model, f64::INFINITY, 5_000));
    assert!(walking > 0.99 && anywhere > 0.8, "{walking} {anywhere}");
}

/// Run with
/// `SUREFOOT_ROBOTS=a/robot.toml:b/robot.toml cargo test --release -p surefoot-planner
/// --test kinematics_newton -- --ignored --nocapture`.
#[test]
#[ignore = "reports on other robots"]
fn shares_solved_for_other_robots() {
    println!("{:<16}{:>8}{:>10}{:>10}{:>10}", "robot", "closed", "0.4 rad", "0.7 rad", "anywhere");
    for path in std::env::var("SUREFOOT_ROBOTS")
        .unwrap_or_default()
        .split(':')
        .filter(|path| !path.is_empty())
    {
        let model = load_robot(path.as_ref()).unwrap();
        let closed = Leg::new(&model, 0, MARGIN).unwrap().is_closed_form();
        let [near, walking, anywhere] =
            [0.4, 0.7, f64::INFINITY].map(|deviation| share_solved(&model, deviation, 50_000));
        println!("{:<16}{closed:>8}{near:>10.4}{walking:>10.4}{anywhere:>10.4}", model.name);
    }
}
