//! `surefoot bench theory`: the bounds of chapter 5 for a plan, beside the failure rate of w-RPG
//! that is measured [Grey 5.6].

use serde::Serialize;
use surefoot_planner::methods::method::{Method, MethodParameters};
use surefoot_planner::theory::confidence::clopper_pearson;
use surefoot_planner::theory::coverage::{disc_radius_min, disc_radius_printed};
use surefoot_planner::theory::disc_union::tube_area;
use surefoot_planner::theory::mode_sampling::ModeSampling;
use surefoot_planner::theory::overall::{Overall, Samples, mode_failure_bound_printed};
use surefoot_planner::theory::route_sampling::{DIMENSIONS, RouteSampling, ball_radius_max};

use crate::cli::method_bench_arguments::TheoryArguments;
use crate::commands::bench::machine::Machine;
use crate::commands::bench::methods::method_trial::MethodSetup;
use crate::commands::bench::methods::theory_numbers::TheoryNumbers;
use crate::commands::bench::print_report::print_report;
use crate::commands::bench::scenarios;
use crate::commands::bench::table::aligned;
use crate::input::inputs::Inputs;
use crate::input::output_files;
use crate::report::command_error::{CommandError, CommandOutcome};

/// The scenarios of figure 5.7.
const SCENARIOS: [&str; 3] = ["stepping_stones", "checkers", "pass_under"];
/// Confidence level of the measured failure rate.
const LEVEL: f64 = 0.95;

/// The numbers, bounds and measurements of one scenario.
#[derive(Debug, Clone, Serialize)]
struct TheoryRow {
    scenario: String,
    numbers: TheoryNumbers,
    /// rho, m.
    disc_radius: f64,
    /// Epsilon, m.
    ball_radius: f64,
    /// The radius that lemma 3 asks for as printed, and the sufficient one, m.
    disc_radii_needed: [f64; 2],
    /// The tube's area for |F|, m2.
    area: f64,
    /// Equations 5.9, 5.2, and 5.14 as printed.
    bounds: [f64; 3],
    /// The sum of the first two, at most 1.
    bound: f64,
    trials: u64,
    failures: u64,
    /// Confidence limits of the failure rate.
    limits: [f64; 2],
}

/// Everything that was measured.
#[derive(Debug, Serialize)]
struct Report {
    schema: &'static str,
    machine: Machine,
    rows: Vec<TheoryRow>,
}

/// Runs the command.
///
/// # Errors
/// When a scenario cannot be used, a result cannot be written, or a signal comes.
pub fn run(arguments: &TheoryArguments) -> Result<CommandOutcome, CommandError> {
    output_files::check_folder(arguments.out.as_deref())?;
    let scenarios = scenarios::load(&arguments.common.scenarios, &SCENARIOS)?;
    let machine = Machine::this()?;
    let mut rows = vec![];
    for inputs in &scenarios {
        rows.extend(row(arguments, inputs)?);
    }
    let report = Report { schema: "surefoot-bench-theory/1", machine, rows };
    if let Some(folder) = &arguments.out {
        output_files::write_json(&report, &folder.join("theory.json"))?;
    }
    print_report(&report, arguments.common.json, || text(&report.rows))?;
    Ok(if report.rows.len() == scenarios.len() {
        CommandOutcome::Done
    } else {
        CommandOutcome::NoPlan
    })
}

/// The row of a scenario; none if the full planner finds no plan to measure.
fn row(arguments: &TheoryArguments, inputs: &Inputs) -> Result<Option<TheoryRow>, CommandError> {
    let samples = arguments.common.samples.parameters();
    let parameters = MethodParameters { rounds_max: 1, ..samples };
    let setup = |method| MethodSetup {
        inputs,
        method,
        parameters,
        work_max: arguments.common.work,
        threads: arguments.common.threads.count(),
        check: false,
    };
    let (trial, planner) = setup(Method::Rpg).search(1)?;
    if !trial.is_found() {
        return Ok(None);
    }
    let numbers = TheoryNumbers::of(&planner);
    let step_max = planner.preparation().step_limits().longest_level_step();
    drop(planner);
    let mut failures = 0;
    for seed in 1..=arguments.trials {
        failures += u64::from(!setup(Method::WRpg).search(seed)?.0.is_found());
    }
    Ok(Some(bounded(inputs, numbers, (parameters, step_max), (failures, arguments.trials))))
}

/// The bounds for these numbers, with `failures` of `trials`.
fn bounded(
    inputs: &Inputs,
    numbers: TheoryNumbers,
    (parameters, step_max): (MethodParameters, f64),
    (failures, trials): (u64, u64),
) -> TheoryRow {
    let disc_radius = parameters.disc_radius_share * step_max;
    let ball_radius = ball_radius_max(numbers.clearance, disc_radius);
    let area = tube_area(numbers.route_length, disc_radius);
    let (modes, cylinder) = (numbers.modes as f64, numbers.cylinder());
    let overall = Overall {
        route: RouteSampling {
            length: numbers.length,
            ball_radius,
            volume: numbers.volume,
            dimensions: DIMENSIONS,
        },
        modes: ModeSampling { modes, cylinder, area },
    };
    let samples = Samples {
        route: f64::from(parameters.route_samples),
        placements: f64::from(parameters.placements),
    };
    let along = (numbers.route_length, disc_radius);
    TheoryRow {
        scenario: inputs.scenario.name.clone(),
        numbers,
        disc_radius,
        ball_radius,
        disc_radii_needed: [
            disc_radius_printed(numbers.placement_distance),
            disc_radius_min(numbers.placement_distance, ball_radius),
        ],
        area,
        bounds: [
            overall.route.failure_bound(samples.route),
            overall.modes.failure_bound(samples.placements),
            mode_failure_bound_printed(modes, cylinder, along, samples.placements),
        ],
        bound: overall.failure_bound(samples).min(1.0),
        trials,
        failures,
        limits: clopper_pearson(failures, trials, LEVEL),
    }
}

fn text(rows: &[TheoryRow]) -> String {
    let head = [
        "scenario",
        "M",
        "r_m",
        "dtheta_m",
        "L",
        "R",
        "|C_N|",
        "h_m",
        "rho",
        "|F|",
        "5.9",
        "5.2",
        "5.14",
        "bound",
        "failed",
        "95 % limits",
    ];
    let cells = |row: &TheoryRow| {
        let numbers = &row.numbers;
        let short = |value: f64| format!("{value:.3}");
        let bound = |value: f64| format!("{value:.2e}");
        vec![
            row.scenario.clone(),
            numbers.modes.to_string(),
            short(numbers.cylinder_radius),
            short(numbers.cylinder_yaw_extent),
            short(numbers.length),
            short(numbers.clearance),
            short(numbers.volume),
            short(numbers.placement_distance),
            short(row.disc_radius),
            short(row.area),
            bound(row.bounds[0]),
            bound(row.bounds[1]),
            bound(row.bounds[2]),
            short(row.bound),
            format!("{}/{}", row.failures, row.trials),
            format!("{:.3}..{:.3}", row.limits[0], row.limits[1]),
        ]
    };
    let head = head.map(str::to_owned).to_vec();
    aligned(&std::iter::once(head).chain(rows.iter().map(cells)).collect::<Vec<_>>())
}
