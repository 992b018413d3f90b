//! Planning inside a 1 kHz control loop: each cycle gives the search a fixed amount of work.
//!
//! `cargo run --release --example control_loop`

#![allow(clippy::print_stdout, clippy::disallowed_methods, reason = "a loop prints and waits")]

use std::time::{Duration, Instant};

use surefoot::{Goal, Parameters, Planner, Pose, Prepared, Robot, Shape, Stance, Step, World};

/// Length of a cycle.
const CYCLE: Duration = Duration::from_millis(1);
/// Work units of a cycle. A unit takes about ten microseconds.
const WORK_PER_CYCLE: u64 = 20;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = Robot::load("configs/robots/hubo/robot.toml")?;
    let floor = Shape::cuboid([5.0, 1.0, 0.25]);
    let world = World::builder().shape("floor", Pose::at(0.0, 0.0, -0.25), floor).build()?;
    let parameters = Parameters::default();
    let prepared = Prepared::new(&robot, &parameters)?;
    let mut planner = Planner::builder(&prepared, &world).build()?;

    planner.begin(Stance::at(0.0, 0.0, 0.0), Goal::at(3.0, 0.0, 0.0))?;
    let (mut cycles, mut longest) = (0, Duration::ZERO);
    let plan = loop {
        let begun = Instant::now();
        cycles += 1;
        let step = planner.step(WORK_PER_CYCLE);
        longest = longest.max(begun.elapsed());
        if let Step::Done(plan) = step {
            break plan?;
        }
        std::thread::sleep(CYCLE.saturating_sub(begun.elapsed()));
    };
    println!("planned in {cycles} cycles; the longest step took {longest:?}");

    let cycles = (plan.duration() / CYCLE.as_secs_f64()) as u64;
    let largest = |time: f64| plan.sample(time).q.iter().fold(0.0_f64, |most, q| most.max(q.abs()));
    let most =
        (0..cycles).map(|cycle| largest(cycle as f64 * CYCLE.as_secs_f64())).fold(0.0, f64::max);
    println!("{cycles} set-points; the largest joint position is {most:.3} rad");
    Ok(())
}
