//! `surefoot bench goals`: random goals near the start on a bare floor: turns on the spot, side
//! steps, backward steps and everything between.

use std::fmt::Write;
use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::Serialize;
use surefoot_planner::Planner;
use surefoot_planner::base::random::{Random, Stream};
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::config::builder::ScenarioContent;
use surefoot_shared_types::config::scenario::{Scenario, StancePose};
use surefoot_shared_types::config::{CheckerConfig, ExecutionConfig, PlannerConfig};
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::{World, WorldShape};
use surefoot_shared_types::{Pose, Shape};

use crate::cli::bench_arguments::GoalsArguments;
use crate::commands::bench::machine::Machine;
use crate::commands::bench::print_report::print_report;
use crate::commands::bench::statistics::Summary;
use crate::commands::bench::table::{aligned, count, seconds};
use crate::commands::search_loop;
use crate::input::output_files;
use crate::input::preparation_cache;
use crate::report::command_error::{CommandError, CommandOutcome};

/// Half the side of the floor, m.
const FLOOR: f64 = 6.0;

/// One goal and what became of it.
#[derive(Debug, Clone, Serialize)]
struct GoalTrial {
    /// Of the goal, from the start, m and rad.
    dx: f64,
    dy: f64,
    yaw: f64,
    outcome: String,
    steps: u64,
    work: u64,
    /// Time of the search, s.
    seconds: f64,
    /// Time until the first chunk was final, s.
    first_chunk_seconds: Option<f64>,
}

#[derive(Debug, Serialize)]
struct Report<'a> {
    schema: &'static str,
    machine: Machine,
    robot: &'a str,
    stance_width: f64,
    radius: f64,
    turn: f64,
    seed: u64,
    trials: usize,
    found: usize,
    /// Of all plans found.
    steps: u64,
    seconds_p50: Option<f64>,
    seconds_p99: Option<f64>,
    seconds_max: Option<f64>,
    first_chunk_p50: Option<f64>,
    first_chunk_p99: Option<f64>,
    work_p50: Option<f64>,
    work_p99: Option<f64>,
    work_max: Option<f64>,
    /// The goals without a plan.
    missed: Vec<&'a GoalTrial>,
}

/// Runs the command.
///
/// # Errors
/// When the robot cannot be used, an output cannot be written, or a signal comes.
pub fn run(arguments: &GoalsArguments) -> Result<CommandOutcome, CommandError> {
    output_files::check_folder(arguments.out.as_deref())?;
    let machine = Machine::this()?;
    let model = load_robot(&arguments.robot)?;
    let world = bare_floor();
    let trials = (0..arguments.trials)
        .map(|index| trial(arguments, (&model, &world), index))
        .collect::<Result<Vec<_>, _>>()?;
    if let Some(folder) = &arguments.out {
        write_csv(&trials, folder)?;
    }
    let report = report(arguments, machine, &model, &trials);
    print_report(&report, arguments.json, || text(&report))?;
    Ok(if report.found == report.trials { CommandOutcome::Done } else { CommandOutcome::NoPlan })
}

/// The robot on a bare floor, and one goal.
fn trial(
    arguments: &GoalsArguments,
    (model, world): (&RobotModel, &World),
    index: u64,
) -> Result<GoalTrial, CommandError> {
    let mut random = Random::new(arguments.goals_seed, Stream::Preparation, index, 0);
    let radius = arguments.radius * libm::sqrt(random.uniform(0.0, 1.0));
    let (sin, cos) = libm::sincos(random.uniform(0.0, std::f64::consts::TAU));
    let yaw = random.uniform(-arguments.turn, arguments.turn);
    let [dx, dy] = [radius * cos, radius * sin];
    let scenario = scenario(arguments, [dx, dy], yaw)?;
    let preparation = preparation_cache::obtain(model, &scenario.planner, true)?.preparation;
    let mut planner = Planner::builder(model, world, &scenario, preparation)
        .threads(arguments.threads.count())
        .in_parts()
        .build()?;
    let planned = search_loop::run(&mut planner, scenario.planner.work_max, &mut |_| Ok(()))?;
    Ok(GoalTrial {
        dx,
        dy,
        yaw,
        steps: planner.steps(),
        work: planned.work,
        seconds: planned.plan_seconds,
        first_chunk_seconds: planned.first_chunk_seconds,
        outcome: planned.outcome,
    })
}

fn scenario(
    arguments: &GoalsArguments,
    [dx, dy]: [f64; 2],
    yaw: f64,
) -> Result<Scenario, CommandError> {
    let stance_width = arguments.stance_width;
    let start = StancePose { position: DVec3::ZERO, yaw: 0.0, stance_width };
    let content = ScenarioContent {
        start,
        goal: StancePose { position: DVec3::new(dx, dy, 0.0), yaw, ..start },
        goal_position_tolerance: arguments.position_tolerance,
        goal_yaw_tolerance: arguments.yaw_tolerance,
        seed: arguments.seed,
        planner: PlannerConfig { work_max: arguments.work, ..PlannerConfig::default() },
        checker: CheckerConfig::default(),
        execution: ExecutionConfig::default(),
    };
    let scenario = content.build().map_err(|error| CommandError::Usage(error.to_string()))?;
    Ok(scenario.with_motion(arguments.motion))
}

fn bare_floor() -> World {
    let half_extents = DVec3::new(FLOOR, FLOOR, 0.25);
    World {
        mu: 0.6,
        shapes: vec![WorldShape {
            name: "floor".into(),
            world_from_shape: Pose::from_translation(-0.25 * DVec3::Z),
            shape: Shape::Box { half_extents },
        }],
        digest: Digest::of(&[b"bare floor"]),
    }
}

fn report<'a>(
    arguments: &GoalsArguments,
    machine: Machine,
    model: &'a RobotModel,
    trials: &'a [GoalTrial],
) -> Report<'a> {
    let summary =
        |value: fn(&GoalTrial) -> f64| Summary::of(&trials.iter().map(value).collect::<Vec<_>>());
    let times = summary(|trial| trial.seconds);
    let first_chunks: Vec<f64> =
        trials.iter().filter_map(|trial| trial.first_chunk_seconds).collect();
    let first_chunks = Summary::of(&first_chunks);
    let works = summary(|trial| trial.work as f64);
    let missed: Vec<&GoalTrial> = trials.iter().filter(|trial| trial.outcome != "found").collect();
    Report {
        schema: "surefoot-bench-goals/1",
        machine,
        robot: &model.name,
        stance_width: arguments.stance_width,
        radius: arguments.radius,
        turn: arguments.turn,
        seed: arguments.goals_seed,
        trials: trials.len(),
        found: trials.len() - missed.len(),
        steps: trials.iter().map(|trial| trial.steps).sum(),
        seconds_p50: times.map(|times| times.p50),
        seconds_p99: times.map(|times| times.p99),
        seconds_max: times.map(|times| times.max),
        first_chunk_p50: first_chunks.map(|times| times.p50),
        first_chunk_p99: first_chunks.map(|times| times.p99),
        work_p50: works.map(|works| works.p50),
        work_p99: works.map(|works| works.p99),
        work_max: works.map(|works| works.max),
        missed,
    }
}

fn write_csv(trials: &[GoalTrial], folder: &Path) -> Result<(), CommandError> {
    let mut csv = "dx,dy,yaw,outcome,steps,work,seconds,first_chunk_seconds\n".to_owned();
    for trial in trials {
        let GoalTrial { dx, dy, yaw, outcome, steps, work, seconds, first_chunk_seconds } = trial;
        let first = first_chunk_seconds.map_or_else(String::new, |first| format!("{first:.6}"));
        let _ =
            writeln!(csv, "{dx:.6},{dy:.6},{yaw:.6},{outcome},{steps},{work},{seconds:.6},{first}");
    }
    let path: PathBuf = folder.join("goals.csv");
    output_files::write_text(&csv, &path)
}

fn text(report: &Report<'_>) -> String {
    let head = [
        "robot",
        "goals",
        "found",
        "steps",
        "p50",
        "p99",
        "longest",
        "first chunk p50",
        "p99",
        "work p50",
        "p99",
        "most",
    ];
    let row = [
        report.robot.to_owned(),
        report.trials.to_string(),
        report.found.to_string(),
        report.steps.to_string(),
        seconds(report.seconds_p50),
        seconds(report.seconds_p99),
        seconds(report.seconds_max),
        seconds(report.first_chunk_p50),
        seconds(report.first_chunk_p99),
        count(report.work_p50),
        count(report.work_p99),
        count(report.work_max),
    ];
    let mut text = format!("machine: {}\n\n", report.machine.describe());
    text += &aligned(&[head.map(str::to_owned).to_vec(), row.to_vec()]);
    for GoalTrial { dx, dy, yaw, outcome, .. } in &report.missed {
        let _ = write!(text, "\nno plan to ({dx:.3}, {dy:.3}) m, {yaw:.3} rad: {outcome}");
    }
    text
}
