//! Reads and validates scenarios.

use std::path::{Path, PathBuf};

use serde::Deserialize;
use toml::Spanned;

use crate::base::digest::Digest;
use crate::base::input_error::InputError;
use crate::base::text_file::{TEXT_BYTES_MAX, TextFile, check_numbers, check_positive};

use crate::config::planner::{CheckerConfig, PlannerConfig};
use crate::config::scenario::{Scenario, StancePose};
use crate::config::validation::check_relations;

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
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawStart {
    xyz: [f64; 3],
    #[serde(default)]
    yaw: f64,
    #[serde(default = "default_stance_width")]
    stance_width: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawGoal {
    xyz: [f64; 3],
    #[serde(default)]
    yaw: f64,
    #[serde(default = "default_stance_width")]
    stance_width: f64,
    #[serde(default = "default_position_tolerance")]
    position_tolerance: f64,
    #[serde(default = "default_yaw_tolerance")]
    yaw_tolerance: f64,
}

/// Loads a scenario file.
///
/// The file names `robot` and `world` (paths relative to it), `seed` (default 1), `[start]` and
/// `[goal]` (`xyz` in m, `yaw` in rad, `stance_width` in m; the goal also `position_tolerance` in m
/// and `yaw_tolerance` in rad), and optionally `[planner]` ([`PlannerConfig`]) and `[checker]`
/// ([`CheckerConfig`]). The robot and the world themselves are not opened.
///
/// # Errors
/// When the file cannot be read, a number is out of range, or a planner margin is not strictly
/// stronger than what the checker tolerates.
pub fn load_scenario(path: &Path) -> Result<Scenario, InputError> {
    let source = TextFile::read(path, TEXT_BYTES_MAX)?;
    let raw: RawScenario = source.parse_toml()?;
    let (start_location, goal_location) =
        (source.location(raw.start.span().start), source.location(raw.goal.span().start));
    let spans = [raw.planner.as_ref().map(Spanned::span), raw.checker.as_ref().map(Spanned::span)];
    let [planner_span, checker_span] = &spans;
    let config_location = |field: &str| {
        let of_its_table = if field.starts_with("checker.") { checker_span } else { planner_span };
        let table = of_its_table.as_ref().or(planner_span.as_ref()).or(checker_span.as_ref());
        source.location(table.map_or(0, |span| span.start))
    };
    let (start, goal) = (raw.start.into_inner(), raw.goal.into_inner());
    let planner = raw.planner.map(Spanned::into_inner).unwrap_or_default();
    let checker = raw.checker.map(Spanned::into_inner).unwrap_or_default();
    let start_stance = stance_pose(start.xyz, start.yaw, start.stance_width)
        .map_err(|message| start_location.error("[start]", message))?;
    let goal_stance = stance_pose(goal.xyz, goal.yaw, goal.stance_width)
        .and_then(|stance| {
            check_positive("position_tolerance", &[goal.position_tolerance]).map(|()| stance)
        })
        .and_then(|stance| check_positive("yaw_tolerance", &[goal.yaw_tolerance]).map(|()| stance))
        .map_err(|message| goal_location.error("[goal]", message))?;
    check_relations(&planner, &checker)
        .map_err(|(field, message)| config_location(&field).error(field, message))?;
    let base_dir = path.parent().unwrap_or(Path::new(""));
    let scenario = Scenario {
        name: path.file_stem().map(|stem| stem.to_string_lossy().into_owned()).unwrap_or_default(),
        path: path.to_owned(),
        robot_path: base_dir.join(raw.robot),
        world_path: base_dir.join(raw.world),
        start: start_stance,
        goal: goal_stance,
        goal_position_tolerance: goal.position_tolerance,
        goal_yaw_tolerance: goal.yaw_tolerance,
        seed: raw.seed,
        planner,
        checker,
        digest: Digest::default(),
    };
    Ok(scenario.with_seed(raw.seed))
}

fn stance_pose(xyz: [f64; 3], yaw: f64, stance_width: f64) -> Result<StancePose, String> {
    check_numbers("xyz", &xyz)?;
    check_numbers("yaw", &[yaw])?;
    check_positive("stance_width", &[stance_width])?;
    Ok(StancePose { position: xyz.into(), yaw, stance_width })
}

fn default_seed() -> u64 {
    1
}

fn default_stance_width() -> f64 {
    0.2
}

fn default_position_tolerance() -> f64 {
    0.10
}

fn default_yaw_tolerance() -> f64 {
    0.35
}
