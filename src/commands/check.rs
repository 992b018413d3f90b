//! `surefoot check`: the controller's checks on an exported plan.

use serde::Serialize;
use surefoot_controller_sim::plan::EndpointReport;
use surefoot_controller_sim::plan::plan_check::CheckResult;
use surefoot_controller_sim::{PlanReport, Problem, Reserves, check_plan_in};
use surefoot_shared_types::config::scenario_source::ScenarioSource;
use surefoot_shared_types::plan_file::read::load_plan;
use surefoot_shared_types::scenario::load::scenario_and_robot;

use crate::cli::arguments::CheckArguments;
use crate::input::shipped::scenario_path;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::report::margins::{WorstMargins, with_unit};
use crate::system::terminal;

/// Runs the command.
///
/// # Errors
/// When the plan, its robot or its world cannot be used.
pub fn run(arguments: &CheckArguments) -> Result<CommandOutcome, CommandError> {
    let plan = load_plan(&arguments.plan)?;
    let problem = match &arguments.scenario {
        Some(path) => {
            let source = ScenarioSource::read(&scenario_path(path)?)?;
            let (scenario, model) = scenario_and_robot(&source)?;
            Problem::of_scenario(&scenario, model, &plan, &arguments.plan)?
        }
        None => Problem::of_plan(&plan, &arguments.plan)?,
    };
    let report = check_plan_in(&plan, &arguments.plan, &problem)?;
    if arguments.json {
        let text = serde_json::to_string_pretty(&JsonReport::from(&report));
        terminal::print_result(&text.unwrap_or_else(|error| error.to_string()));
    } else {
        terminal::print_result(&table(&report));
    }
    Ok(if report.is_valid() { CommandOutcome::Done } else { CommandOutcome::Refused })
}

fn table(report: &PlanReport) -> String {
    let mut rows = vec![format!("{:<16}{:<14}where", "check", "worst margin")];
    rows.extend(report.checks.iter().map(row));
    rows.extend(
        [("start", &report.start), ("goal", &report.goal)].map(|(name, end)| end_row(name, end)),
    );
    let Reserves { friction, least_squares_torque } = report.reserves;
    let reserves = [("friction unused", friction), ("least-sq torque", least_squares_torque)];
    rows.extend(reserves.map(|(name, reserve)| reserve_row(name, reserve)));
    rows.extend(report.notes.iter().cloned());
    rows.push(if report.is_valid() { "accepted".to_owned() } else { "refused".to_owned() });
    rows.join("\n")
}

fn row(line: &CheckResult) -> String {
    let name = line.check.name();
    let margin = line.worst.map_or("-".to_owned(), |worst| with_unit(name, worst.margin));
    let place = match (&line.violation, line.worst) {
        (Some(placed), _) => format!("VIOLATED in phase {}: {}", placed.phase, placed.violation),
        (None, Some(worst)) => format!("phase {}", worst.phase),
        (None, None) => "holds".to_owned(),
    };
    format!("{name:<16}{margin:<14}{place}")
}

fn end_row(name: &str, end: &EndpointReport) -> String {
    let margin = with_unit(name, end.limit - end.error);
    let place = end
        .violation
        .as_ref()
        .map_or_else(|| "reached".to_owned(), |violation| format!("VIOLATED: {violation}"));
    format!("{name:<16}{margin:<14}{place}")
}

/// A margin that is reported and not enforced.
fn reserve_row(name: &str, reserve: f64) -> String {
    let share =
        if reserve.is_finite() { format!("{:.1} %", 100.0 * reserve) } else { "-".to_owned() };
    format!("{name:<16}{share:<14}reported, not enforced")
}

#[derive(Serialize)]
struct JsonReport {
    outcome: &'static str,
    margins: WorstMargins,
    reserves: JsonReserves,
    checks: Vec<JsonCheck>,
    start: JsonEnd,
    goal: JsonEnd,
    notes: Vec<String>,
}

/// See `surefoot_controller_sim::Reserves`.
#[derive(Serialize)]
struct JsonReserves {
    friction: Option<f64>,
    least_squares_torque: Option<f64>,
}

#[derive(Serialize)]
struct JsonCheck {
    check: &'static str,
    margin: Option<f64>,
    phase: Option<usize>,
    violation: Option<JsonViolation>,
}

#[derive(Serialize)]
struct JsonViolation {
    phase: usize,
    waypoint: usize,
    detail: String,
}

#[derive(Serialize)]
struct JsonEnd {
    error: Option<f64>,
    limit: f64,
    violation: Option<String>,
}

impl From<&PlanReport> for JsonReport {
    fn from(report: &PlanReport) -> Self {
        Self {
            outcome: if report.is_valid() { "accepted" } else { "refused" },
            margins: (&report.margins).into(),
            reserves: JsonReserves {
                friction: finite(report.reserves.friction),
                least_squares_torque: finite(report.reserves.least_squares_torque),
            },
            checks: report.checks.iter().map(JsonCheck::from).collect(),
            start: (&report.start).into(),
            goal: (&report.goal).into(),
            notes: report.notes.clone(),
        }
    }
}

impl From<&CheckResult> for JsonCheck {
    fn from(line: &CheckResult) -> Self {
        let violation = line.violation.as_ref().map(|placed| JsonViolation {
            phase: placed.phase,
            waypoint: placed.violation.waypoint,
            detail: placed.violation.detail.clone(),
        });
        let worst = line.worst;
        Self {
            check: line.check.name(),
            margin: worst.map(|worst| worst.margin),
            phase: worst.map(|worst| worst.phase),
            violation,
        }
    }
}

impl From<&EndpointReport> for JsonEnd {
    fn from(end: &EndpointReport) -> Self {
        Self { error: finite(end.error), limit: end.limit, violation: end.violation.clone() }
    }
}

fn finite(number: f64) -> Option<f64> {
    Some(number).filter(|number| number.is_finite())
}
