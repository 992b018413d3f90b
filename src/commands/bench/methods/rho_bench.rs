//! `surefoot bench rho`: figure 5.8 of the thesis, the mean time of w-RPG, or of the full planner
//! with placements in discs, over the radius of the discs [Grey 5.7.2].

use surefoot_planner::methods::method::{Method, MethodParameters};

use crate::cli::method_bench_arguments::RhoArguments;
use crate::commands::bench::machine::Machine;
use crate::commands::bench::methods::method_journal;
use crate::commands::bench::methods::method_report::MethodReport;
use crate::commands::bench::methods::method_row::MethodRow;
use crate::commands::bench::methods::method_trial::MethodSetup;
use crate::commands::bench::print_report::print_report;
use crate::commands::bench::scale::plot::{Curve, log_log};
use crate::commands::bench::scenarios;
use crate::input::output_files;
use crate::report::command_error::{CommandError, CommandOutcome};

/// The scenarios of figure 5.7.
const SCENARIOS: [&str; 3] = ["stepping_stones", "checkers", "pass_under"];
/// Where the plot draws an infinite radius, relative to R_max.
const INFINITE_AT: f64 = 10.0;

/// Runs the command.
///
/// # Errors
/// When a scenario cannot be used, a result cannot be written, or a signal comes.
pub fn run(arguments: &RhoArguments) -> Result<CommandOutcome, CommandError> {
    let scenarios = scenarios::load(&arguments.common.scenarios, &SCENARIOS)?;
    let (machine, series) = (Machine::this()?, &arguments.series);
    let mut journal = method_journal::open("rho", &arguments.common, series, &machine)?;
    let mut rows = vec![];
    for inputs in &scenarios {
        for &share in &arguments.shares {
            let samples = arguments.common.samples.parameters();
            let is_mmprm = arguments.method == Method::WRpg && share.is_infinite();
            let setup = MethodSetup {
                inputs,
                method: if is_mmprm { Method::Mmprm } else { arguments.method },
                parameters: MethodParameters { disc_radius_share: share, ..samples },
                work_max: arguments.common.work,
                threads: arguments.common.threads.count(),
                check: false,
            };
            let seeds = series.seeds(arguments.trials);
            let trials = setup.trials(seeds, &machine.program, &mut journal)?;
            rows.push(MethodRow::of(&setup, &trials));
        }
    }
    let schema = "surefoot-bench-rho/1";
    let report = MethodReport { schema, machine, work_max: arguments.common.work, rows };
    if let Some(folder) = &series.out {
        report.save(folder, "rho")?;
        output_files::write_text(&figure(arguments.method, &report.rows), &folder.join("rho.svg"))?;
    }
    print_report(&report, arguments.common.json, || report.table())?;
    Ok(CommandOutcome::Done)
}

/// Figure 5.8: mean time over rho / R_max, relative to the least of the scenario.
fn figure(method: Method, rows: &[MethodRow]) -> String {
    let mut curves: Vec<Curve> = vec![];
    for row in rows {
        let Some(seconds) = row.mean_seconds else { continue };
        let point = (row.disc_radius_share.unwrap_or(INFINITE_AT), seconds);
        match curves.iter_mut().find(|curve| curve.name == row.scenario) {
            Some(curve) => curve.points.push(point),
            None => curves.push(Curve { name: row.scenario.clone(), points: vec![point] }),
        }
    }
    for curve in &mut curves {
        let least = curve.points.iter().map(|point| point.1).fold(f64::INFINITY, f64::min);
        curve.points.iter_mut().for_each(|point| point.1 /= least);
    }
    let name = method.name();
    let title = format!("{name}: mean time of searches that found a walk, relative to the least");
    log_log(&title, "rho / R_max (10: infinite)", "time / least time", &curves)
}
