//! A world from memory: a floor, a log, and a terrain mesh made from a height function.
//!
//! `cargo run --release --example world_from_memory`

#![allow(clippy::print_stdout, clippy::disallowed_methods, reason = "a terrain needs a sine")]

use std::f64::consts::FRAC_PI_2;

use surefoot::{Goal, Parameters, Planner, Pose, Prepared, Robot, Shape, Stance, World};

/// Vertices along x and y.
const SIZE: [u32; 2] = [41, 21];
/// Distance between neighbouring vertices, m.
const CELL: f64 = 0.1;
/// Distance from the terrain's corner to the middle of the way, m.
const LEFT: f64 = 1.0;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let robot = Robot::load("configs/robots/hubo/robot.toml")?;
    let height = |x: f64, y: f64| 0.02 * (x + y).sin();
    let (vertices, triangles) = terrain(height);
    let world = World::builder()
        .friction(0.7)
        .mesh("terrain", Pose::at(0.0, -LEFT, 0.0), &vertices, &triangles)
        .shape(
            "log",
            Pose::at(1.5, 0.0, 0.02).with_rpy(FRAC_PI_2, 0.0, 0.0),
            Shape::cylinder(0.05, 1.5),
        )
        .build()?;
    let parameters = Parameters::default();
    let prepared = Prepared::new(&robot, &parameters)?;
    let mut planner = Planner::builder(&prepared, &world).threads(2).build()?;
    let start = Stance::at(0.5, 0.0, height(0.5, LEFT));
    let plan = planner.plan(start, Goal::at(3.0, 0.0, height(3.0, LEFT)))?;
    for foothold in plan.footholds() {
        let [x, y, z] = foothold.position;
        println!(
            "{:>5.1} s {:<5} {x:6.3} {y:6.3} {z:6.3}",
            foothold.time,
            format!("{:?}", foothold.foot)
        );
    }
    let stats = planner.stats();
    println!("{} work units, {} sequences", stats.work, stats.sequences);
    Ok(())
}

/// A mesh of a height function (m), counter-clockwise seen from above.
fn terrain(height: impl Fn(f64, f64) -> f64) -> (Vec<[f64; 3]>, Vec<[u32; 3]>) {
    let [columns, rows] = SIZE;
    let at = |column, row| row * columns + column;
    let vertex = |index: u32| {
        let (x, y) = (CELL * f64::from(index % columns), CELL * f64::from(index / columns));
        [x, y, height(x, y)]
    };
    let cell = |(column, row): (u32, u32)| {
        let [a, b] = [at(column, row), at(column + 1, row)];
        let [c, d] = [at(column + 1, row + 1), at(column, row + 1)];
        [[a, b, c], [a, c, d]]
    };
    let cells = (0..rows - 1).flat_map(|row| (0..columns - 1).map(move |column| (column, row)));
    ((0..columns * rows).map(vertex).collect(), cells.flat_map(cell).collect())
}
