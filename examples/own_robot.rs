//! A robot of one's own: the URDF, and a `robot.toml` beside it that names the feet.
//!
//! `cargo run --release --example own_robot [robot.toml]`

#![allow(clippy::print_stdout, reason = "an example prints")]

use std::path::{Path, PathBuf};

use surefoot::{Goal, Parameters, Planner, Pose, Prepared, Robot, Shape, Stance, World};

/// Lateral distance between the feet, m.
const WIDTH: f64 = 0.2;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = tempfile::tempdir()?;
    let path = match std::env::args().nth(1) {
        Some(path) => PathBuf::from(path),
        None => write_robot(folder.path())?,
    };
    let robot = Robot::load(&path)?;
    let joints: Vec<&str> = robot.joint_names().collect();
    println!("{}: {} joints: {}", robot.name(), joints.len(), joints.join(", "));
    let parameters = Parameters::default();
    let prepared = Prepared::new(&robot, &parameters)?;
    prepared.write(std::fs::File::create(folder.path().join("robot.prepared"))?)?;
    let floor = Shape::cuboid([3.0, 1.0, 0.25]);
    let world = World::builder().shape("floor", Pose::at(0.0, 0.0, -0.25), floor).build()?;
    let mut planner = Planner::builder(&prepared, &world).build()?;
    let goal = Goal { stance: Stance::at(1.0, 0.0, 0.0).with_width(WIDTH), ..Goal::at(0., 0., 0.) };
    let plan = planner.plan(Stance::at(0.0, 0.0, 0.0).with_width(WIDTH), goal)?;
    println!("{} footholds in {:.1} s", plan.footholds().len(), plan.duration());
    Ok(())
}

/// Copies the URDF that stands for one's own, and writes the `robot.toml` that goes with it.
fn write_robot(folder: &Path) -> std::io::Result<PathBuf> {
    std::fs::copy("configs/robots/hubo/hubo.urdf", folder.join("own.urdf"))?;
    let text = std::fs::read_to_string("configs/robots/hubo/robot.toml")?;
    let path = folder.join("robot.toml");
    std::fs::write(&path, text.replace("hubo.urdf", "own.urdf"))?;
    Ok(path)
}
