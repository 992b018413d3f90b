//! A walk in twenty lines: robot from a file, world from memory, footsteps printed.
//!
//! `cargo run --release --example twenty_lines`

#![allow(clippy::print_stdout, reason = "an example prints")]

use surefoot::{Goal, Parameters, Planner, Pose, Prepared, Robot, Shape, Stance, World};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = Robot::load("configs/robots/hubo/robot.toml")?;
    let world = World::builder()
        .friction(0.6)
        .shape("floor", Pose::at(0.0, 0.0, -0.25), Shape::cuboid([5.0, 1.0, 0.25]))
        .build()?;
    let parameters = Parameters::default();
    let prepared = Prepared::new(&robot, &parameters)?;
    let mut planner = Planner::builder(&prepared, &world).threads(2).seed(7).build()?;
    let plan = planner.plan(Stance::at(0.0, 0.0, 0.0), Goal::at(3.0, 0.0, 0.0))?;
    for foothold in plan.footholds() {
        println!("{:?} {:?}", foothold.foot, foothold.position);
    }
    let middle = plan.sample(0.5 * plan.duration());
    println!("{} joints, digest {}", middle.q.len(), plan.digest());
    Ok(())
}
