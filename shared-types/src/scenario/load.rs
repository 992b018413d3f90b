//! Reads and validates scenarios.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::Spanned;

use crate::base::digest::Digest;
use crate::base::exactly::Exactly;
use crate::base::file_kind::FileKind;
use crate::base::input_error::InputError;
use crate::base::text_file::{TextFile, check_angles, check_numbers, check_positive};
use crate::config::execution::ExecutionConfig;
use crate::config::planner::{CheckerConfig, PlannerConfig};
use crate::config::scenario::{GoalTolerance, Scenario, StancePose};
use crate::config::scenario_source::ScenarioSource;
use crate::config::validation::check_relations;
use crate::robot::load::load_robot;
use crate::robot::model::RobotModel;

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawScenario {
    robot: PathBuf,
    world: PathBuf,
    #[serde(default = "default_seed")]
    seed: u64,
    start: Spanned<RawStart>,
    goal: Spanned<RawGoal>,
    planner: Option<Spanned<PlannerConfig>>,
    checker: Option<Spanned<CheckerConfig>>,
    execution: Option<Spanned<ExecutionConfig>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawStart {
    xyz: Exactly<f64, 3>,
    #[serde(default)]
    yaw: f64,
    stance_width: Option<f64>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawGoal {
    xyz: Exactly<f64, 3>,
    #[serde(default)]
    yaw: f64,
    stance_width: Option<f64>,
    #[serde(default = "default_position_tolerance")]
    position_tolerance: f64,
    #[serde(default = "default_yaw_tolerance")]
    yaw_tolerance: f64,
}

/// Loads a scenario file.
///
/// The file names `robot` and `world` (paths relative to it), `seed` (default 1), `[start]` and
/// `[goal]` (`xyz` in m, `yaw` in rad, `stance_width` in m; the goal also `position_tolerance` in m
/// and `yaw_tolerance` in rad), and optionally `[planner]` ([`PlannerConfig`]), `[checker]`
/// ([`CheckerConfig`]) and `[execution]` ([`ExecutionConfig`]). Where a `stance_width` is missing,
/// the robot's file is read: it is the distance at which the robot stands. The world's file is not
/// opened.
///
/// # Errors
/// The file cannot be read, a number is out of range, the goal is more than a kilometre from the
/// start, or a margin of the planner is not strictly stronger than the checker's tolerance. Those
/// of [`load_robot`] where a width is missing.
pub fn load_scenario(path: &Path) -> Result<Scenario, InputError> {
    scenario_of(&ScenarioSource::read(path)?)
}

/// As [`load_scenario`], of a text that was read already.
///
/// # Errors
/// As [`load_scenario`].
pub fn scenario_of(source: &ScenarioSource) -> Result<Scenario, InputError> {
    Ok(read(source)?.0)
}

/// As [`scenario_of`], with its robot.
///
/// # Errors
/// As [`load_scenario`] and [`load_robot`].
pub fn scenario_and_robot(source: &ScenarioSource) -> Result<(Scenario, RobotModel), InputError> {
    let (scenario, robot) = read(source)?;
    let robot = robot.map_or_else(|| load_robot(&scenario.robot_path), Ok)?;
    Ok((scenario, robot))
}

/// A scenario, and its robot if that says how wide a stance is.
fn read(source: &ScenarioSource) -> Result<(Scenario, Option<RobotModel>), InputError> {
    let ScenarioSource { file: source, folder, .. } = source;
    let path = &source.path;
    let raw: RawScenario = source.parse_toml(FileKind::Scenario)?;
    let robot_path = folder.join(&raw.robot);
    let widths = [raw.start.get_ref().stance_width, raw.goal.get_ref().stance_width];
    let needs_robot = widths.contains(&None);
    let robot = needs_robot.then(|| load_robot(&robot_path)).transpose()?;
    let width = robot.as_ref().map_or(0.0, RobotModel::stance_width);
    let start = start_stance(&raw.start, width, source)?;
    let goal = goal_stance(&raw.goal, width, &start, source)?;
    let (planner, checker, execution) = configs(raw.planner, raw.checker, raw.execution, source)?;
    let raw_goal = raw.goal.into_inner();
    let scenario = Scenario {
        name: path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default(),
        path: path.to_owned(),
        robot_path,
        world_path: folder.join(raw.world),
        start,
        goal,
        goal_tolerance: GoalTolerance {
            position: raw_goal.position_tolerance,
            yaw: raw_goal.yaw_tolerance,
        },
        seed: raw.seed,
        planner,
        checker,
        execution,
        digest: Digest::default(),
    };
    Ok((scenario.with_seed(raw.seed), robot))
}

fn start_stance(
    start: &Spanned<RawStart>,
    width: f64,
    source: &TextFile,
) -> Result<StancePose, InputError> {
    let RawStart { xyz: Exactly(xyz), yaw, stance_width } = *start.get_ref();
    stance_pose(xyz, yaw, stance_width.unwrap_or(width))
        .map_err(|message| source.location(start.span().start).error("[start]", message))
}

fn goal_stance(
    goal: &Spanned<RawGoal>,
    width: f64,
    start: &StancePose,
    source: &TextFile,
) -> Result<StancePose, InputError> {
    let RawGoal { xyz: Exactly(xyz), yaw, stance_width, position_tolerance, yaw_tolerance } =
        *goal.get_ref();
    let stance = || {
        let stance = stance_pose(xyz, yaw, stance_width.unwrap_or(width))?;
        check_positive("position_tolerance", &[position_tolerance])?;
        check_positive("yaw_tolerance", &[yaw_tolerance])?;
        start.check_walk_to(&stance)?;
        Ok(stance)
    };
    stance().map_err(|message: String| source.location(goal.span().start).error("[goal]", message))
}

/// All tables with their defaults. An error names the table of the parameter, or another one if
/// that table does not exist.
fn configs(
    planner: Option<Spanned<PlannerConfig>>,
    checker: Option<Spanned<CheckerConfig>>,
    execution: Option<Spanned<ExecutionConfig>>,
    source: &TextFile,
) -> Result<(PlannerConfig, CheckerConfig, ExecutionConfig), InputError> {
    let planner_start = planner.as_ref().map(|table| table.span().start);
    let checker_start = checker.as_ref().map(|table| table.span().start);
    let execution_start = execution.as_ref().map(|table| table.span().start);
    let planner = planner.map(Spanned::into_inner).unwrap_or_default();
    let checker = checker.map(Spanned::into_inner).unwrap_or_default();
    let execution = execution.map(Spanned::into_inner).unwrap_or_default();
    check_relations(&planner, &checker, &execution).map_err(|(field, message)| {
        let own = match field.split_once('.') {
            Some(("checker", _)) => checker_start,
            Some(("execution", _)) => execution_start,
            _ => planner_start,
        };
        let start = own.or(planner_start).or(checker_start).unwrap_or(0);
        source.location(start).error(field, message)
    })?;
    Ok((planner, checker, execution))
}

fn stance_pose(xyz: [f64; 3], yaw: f64, stance_width: f64) -> Result<StancePose, String> {
    check_numbers("xyz", &xyz)?;
    check_angles("yaw", &[yaw])?;
    check_positive("stance_width", &[stance_width])?;
    Ok(StancePose { position: xyz.into(), yaw, stance_width })
}

fn default_seed() -> u64 {
    1
}

fn default_position_tolerance() -> f64 {
    0.10
}

fn default_yaw_tolerance() -> f64 {
    0.35
}
