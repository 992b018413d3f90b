//! Planning anew after a chunk was refused: the checker knows a world with one more box in it.
//!
//! `cargo run --release --example replan`

#![allow(clippy::print_stdout, reason = "an example prints")]

use surefoot::{
    Checker, Event, Goal, Parameters, Planner, Pose, Prepared, Robot, Shape, Stance, World,
    WorldBuilder, WorldCorrection,
};

/// Half sides of the box that the planner does not know, m.
const HALF_SIDES: [f64; 3] = [0.1, 0.3, 0.04];

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = Robot::load("configs/robots/hubo/robot.toml")?;
    let parameters = Parameters::default();
    let prepared = Prepared::new(&robot, &parameters)?;
    let actual =
        floor().shape("box", Pose::at(1.5, 0.2, 0.04), Shape::cuboid(HALF_SIDES)).build()?;
    let mut checker = Checker::new(&robot, &actual, &parameters)?;

    let mut planner = Planner::builder(&prepared, &floor().build()?).threads(2).build()?;
    let plan = planner.plan(Stance::at(0.0, 0.0, 0.0), Goal::at(3.0, 0.0, 0.0))?;
    let Err((refused, violation)) = checker.check_plan(&plan) else {
        println!("the plan holds in the actual world");
        return Ok(());
    };
    println!("chunk {refused} of {} is refused: {violation}", plan.chunks().len());

    let begins = plan.chunks()[refused].waypoints()[0].time;
    let extra = WorldCorrection::extra(&Pose::at(1.5, 0.2, 0.04).into(), HALF_SIDES);
    let plan = planner.replan(&plan.sample(begins), &Event::WorldChanged(vec![extra]))?;
    let margins = checker.check_plan(&plan).map_err(|(_, violation)| violation)?;
    println!("{} footholds around it", plan.footholds().len());
    println!("collision margin {:.1} mm", 1e3 * margins.collision);
    Ok(())
}

fn floor() -> WorldBuilder {
    World::builder().shape("floor", Pose::at(0.0, 0.0, -0.25), Shape::cuboid([5.0, 1.0, 0.25]))
}
