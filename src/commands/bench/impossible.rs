//! `surefoot bench impossible`: random worlds, and whether each that is called impossible is one in
//! which long searches by several methods find nothing.

use glam::DVec3;
use serde::Serialize;
use surefoot_planner::base::random::{Random, Stream};
use surefoot_planner::methods::method::{Method, MethodParameters};
use surefoot_planner::preparation::Preparation;
use surefoot_planner::{Outcome, Planner, Status};
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::config::builder::ScenarioContent;
use surefoot_shared_types::config::scenario::{Scenario, StancePose};
use surefoot_shared_types::config::{CheckerConfig, ExecutionConfig, PlannerConfig};
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::{World, WorldShape};
use surefoot_shared_types::{Pose, Shape};

use crate::cli::bench_arguments::ImpossibleArguments;
use crate::commands::bench::machine::Machine;
use crate::commands::bench::print_report::print_report;
use crate::commands::bench::statistics::Summary;
use crate::commands::bench::table::{aligned, seconds};
use crate::input::preparation_cache;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::clock::Stopwatch;
use crate::system::signals;

/// Work units between two checks for a signal.
const WORK_PER_STEP: u64 = 20_000;
/// The methods that search on where a world is called impossible.
const METHODS: [Method; 3] = [Method::Rpg, Method::AstarAdaptive, Method::RandomMmp];
/// Half the thickness of every floor, m.
const HALF_THICKNESS: f64 = 0.25;

/// How the search ended in one world.
#[derive(Debug, Clone, Serialize)]
struct WorldTrial {
    world: u64,
    outcome: &'static str,
    message: String,
    /// Time and work until the end, s and units.
    seconds: f64,
    work: u64,
    /// The methods that found a plan although the world is called impossible.
    contradicted_by: Vec<&'static str>,
}

#[derive(Debug, Serialize)]
struct Report {
    schema: &'static str,
    machine: Machine,
    worlds: u64,
    found: usize,
    impossible: usize,
    other: usize,
    /// Worlds that are called impossible and have a plan.
    contradicted: usize,
    /// Of the impossible ones, s.
    seconds_p50: Option<f64>,
    seconds_max: Option<f64>,
    trials: Vec<WorldTrial>,
}

/// Runs the command.
///
/// # Errors
/// When the robot cannot be used, or a signal comes.
pub fn run(arguments: &ImpossibleArguments) -> Result<CommandOutcome, CommandError> {
    let machine = Machine::this()?;
    let model = load_robot(&arguments.robot)?;
    let trials = (0..arguments.worlds)
        .map(|world| trial(arguments, &model, arguments.worlds_seed + world))
        .collect::<Result<Vec<_>, _>>()?;
    let count = |outcome: &str| trials.iter().filter(|trial| trial.outcome == outcome).count();
    let (found, impossible) = (count("found"), count("impossible"));
    let times: Vec<f64> = trials
        .iter()
        .filter(|trial| trial.outcome == "impossible")
        .map(|trial| trial.seconds)
        .collect();
    let summary = Summary::of(&times);
    let contradicted = trials.iter().filter(|trial| !trial.contradicted_by.is_empty()).count();
    let report = Report {
        schema: "surefoot-bench-impossible/1",
        machine,
        worlds: arguments.worlds,
        found,
        impossible,
        other: trials.len() - found - impossible,
        contradicted,
        seconds_p50: summary.map(|times| times.p50),
        seconds_max: summary.map(|times| times.max),
        trials,
    };
    print_report(&report, arguments.json, || text(&report))?;
    Ok(if contradicted == 0 { CommandOutcome::Done } else { CommandOutcome::Refused })
}

/// Searches in one world; where it is called impossible, searches on by every method.
fn trial(
    arguments: &ImpossibleArguments,
    model: &RobotModel,
    index: u64,
) -> Result<WorldTrial, CommandError> {
    let (world, start, goal) = random_world(index);
    let scenario = scenario([start, goal], arguments.work.max(arguments.search_on))?;
    let preparation = preparation_cache::obtain(model, &scenario.planner, true)?.preparation;
    let build = |method| planner((model, &world, &scenario), &preparation, method);
    let mut planner = build(Method::Rpg)?;
    planner.limit_work(arguments.work);
    let watch = Stopwatch::start();
    let outcome = finish(&mut planner)?;
    let seconds = watch.seconds();
    let mut contradicted_by = vec![];
    if let Outcome::Impossible(_) = outcome {
        for method in METHODS {
            let mut other = build(method)?;
            other.limit_work(arguments.search_on);
            other.search_on();
            if finish(&mut other)? == Outcome::Found {
                contradicted_by.push(method.name());
            }
        }
    }
    Ok(WorldTrial {
        world: index,
        outcome: outcome.name(),
        message: planner.describe(&outcome),
        seconds,
        work: planner.stats().work,
        contradicted_by,
    })
}

fn planner(
    (model, world, scenario): (&RobotModel, &World, &Scenario),
    preparation: &Preparation,
    method: Method,
) -> Result<Planner, CommandError> {
    Ok(Planner::builder(model, world, scenario, preparation.clone())
        .method(method, MethodParameters::default())
        .build()?)
}

fn finish(planner: &mut Planner) -> Result<Outcome, CommandError> {
    loop {
        if let Status::Done(outcome) = planner.step(WORK_PER_STEP) {
            return Ok(outcome);
        }
        if let Some(signal) = signals::raised() {
            return Err(CommandError::Interrupted(signal));
        }
    }
}

fn scenario([start, goal]: [DVec3; 2], work_max: u64) -> Result<Scenario, CommandError> {
    let stance = |position| StancePose { position, yaw: 0.0, stance_width: 0.2 };
    let planner = PlannerConfig {
        work_max,
        footholds_max: 16_000,
        transitions_max: 200_000,
        configurations_max: 16_000,
        tree_vertices_max: 4_096,
        ..PlannerConfig::default()
    };
    let content = ScenarioContent {
        start: stance(start),
        goal: stance(goal),
        goal_position_tolerance: 0.1,
        goal_yaw_tolerance: 0.35,
        seed: 1,
        planner,
        checker: CheckerConfig::default(),
        execution: ExecutionConfig::default(),
    };
    content.build().map_err(|error| CommandError::Usage(error.to_string()))
}

/// A course of floors between start and goal, with gaps, rises, and walls and blocks of random
/// sizes on them; some in a corridor. Returns the world, the start and the goal.
fn random_world(index: u64) -> (World, DVec3, DVec3) {
    let mut random = Random::new(index, Stream::Preparation, 0, 1);
    let mut course = Course { shapes: vec![], edge: 1.2, height: 0.0 };
    course.add([0.0, 0.0, -HALF_THICKNESS], [1.2, 1.0, HALF_THICKNESS]);
    let is_corridor = random.uniform(0.0, 1.0) < 0.4;
    for _ in 0..2 {
        course.extend(&mut random);
    }
    let end = course.edge;
    course.add([end + 1.0, 0.0, course.height - HALF_THICKNESS], [1.0, 1.0, HALF_THICKNESS]);
    if is_corridor {
        for side in [-1.05, 1.05] {
            course.add([0.5 * end, side, 1.0], [0.5 * end + 2.0, 0.05, 2.0]);
        }
    }
    let goal = DVec3::new(end + 0.9, 0.0, course.height);
    let world =
        World { mu: 0.6, shapes: course.shapes, digest: Digest::of(&[&index.to_le_bytes()]) };
    (world, DVec3::new(-0.5, 0.0, 0.0), goal)
}

/// A course that is being built.
struct Course {
    shapes: Vec<WorldShape>,
    /// Where its last floor ends along x, m.
    edge: f64,
    /// Height of that floor, m.
    height: f64,
}

impl Course {
    fn add(&mut self, center: [f64; 3], half_extents: [f64; 3]) {
        self.shapes.push(WorldShape {
            name: format!("box_{}", self.shapes.len()),
            world_from_shape: Pose::from_translation(center.into()),
            shape: Shape::Box { half_extents: half_extents.into() },
        });
    }

    /// Adds a floor, after a gap and a rise, and perhaps a wall or a block on it.
    fn extend(&mut self, random: &mut Random) {
        let mut one_of_four = || random.uniform(0.0, 1.0) < 0.25;
        let [is_far, is_high, is_walled, is_blocked] = [(); 4].map(|()| one_of_four());
        let gap = if is_far { random.uniform(0.4, 1.8) } else { random.uniform(0.0, 0.15) };
        let rise = if is_high { 1.2 } else { 0.1 };
        self.height += random.uniform(-rise, rise);
        let half_length = random.uniform(0.35, 0.7);
        self.edge += gap + 2.0 * half_length;
        let (x, top) = (self.edge - half_length, self.height);
        let half_width = random.uniform(0.5, 1.0);
        self.add([x, 0.0, top - HALF_THICKNESS], [half_length, half_width, HALF_THICKNESS]);
        if is_walled {
            let half_height = random.uniform(0.1, 1.2);
            let half_width = random.uniform(0.4, 1.2);
            self.add([x, 0.0, top + half_height], [0.05, half_width, half_height]);
        }
        if is_blocked {
            let half = random.uniform(0.05, 0.3);
            let y = random.uniform(-0.6, 0.6);
            self.add([x, y, top + half], [half, half, half]);
        }
    }
}

fn text(report: &Report) -> String {
    let head = ["worlds", "found", "impossible", "other", "contradicted", "p50", "longest"];
    let row = [
        report.worlds.to_string(),
        report.found.to_string(),
        report.impossible.to_string(),
        report.other.to_string(),
        report.contradicted.to_string(),
        seconds(report.seconds_p50),
        seconds(report.seconds_max),
    ];
    let mut text = format!("machine: {}\n\n", report.machine.describe());
    text += &aligned(&[head.map(str::to_owned).to_vec(), row.to_vec()]);
    for trial in report.trials.iter().filter(|trial| !trial.contradicted_by.is_empty()) {
        let methods = trial.contradicted_by.join(", ");
        text += &format!("\nworld {}: found by {methods}, yet {}", trial.world, trial.message);
    }
    text
}
