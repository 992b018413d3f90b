//! `surefoot bench footholds`: success rates of foot placement queries, on parallel bars as in
//! figure 4.10 and on single features.
//!
//! A query succeeds if one placement is found. Each world gets the same queries for four samplers:
//! Algorithm 1 as printed, Algorithm 1 with its initial samples, the geometric proposals, and the
//! whole sampler.

use crate::commands::bench::footholds::plot;
use crate::commands::bench::print_report::print_report;
use std::fmt::Write;
use std::path::Path;

use indicatif::{ProgressBar, ProgressStyle};
use serde::Serialize;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::world::load::load_world;

use crate::cli::bench_arguments::FootholdsArguments;
use crate::commands::bench::footholds::queries::{QueryResults, Sampler, run_queries};
use crate::commands::bench::machine::Machine;
use crate::input::output_files;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::{signals, terminal};

/// Outer spans of the parallel bars, in percent of the sole's length.
const SPANS: [u32; 15] = [60, 65, 70, 75, 80, 85, 90, 95, 100, 105, 110, 115, 120, 125, 130];
/// The further worlds.
const FEATURES: [&str; 11] = [
    "features/box_edge",
    "features/cylinder",
    "features/ibeam",
    "features/ramp_0_9",
    "features/ramp_1_1",
    "features/ring",
    "features/rubble_mesh",
    "features/sphere_cap",
    "features/staircase",
    "features/v_groove",
    "m_groove",
];
/// The thesis's own curve in words.
const THESIS: &str = "The thesis draws its curve (figure 4.10, Algorithm 1 with the limits 40, 10 and 20) without printing a number; its text \
                      says that placements become rarer the further the bars are apart, and that the margin shrinks beyond 100 %.";

/// One world's results.
#[derive(Debug, Serialize)]
struct Row {
    world: String,
    /// Of parallel bars: their outer span in percent of the sole's length.
    span_percent: Option<u32>,
    queries: u32,
    samplers: Vec<QueryResults>,
}

#[derive(Debug, Serialize)]
struct Report<'a> {
    schema: &'static str,
    machine: Machine,
    robot: &'a str,
    seed: u64,
    thesis: &'static str,
    rows: &'a [Row],
}

/// Runs the command.
///
/// # Errors
/// When the robot or a world cannot be used, an output cannot be written, or a signal comes.
pub fn run(arguments: &FootholdsArguments) -> Result<CommandOutcome, CommandError> {
    output_files::check_folder(arguments.out.as_deref())?;
    let machine = Machine::this()?;
    let model = load_robot(&arguments.robot)?;
    let sole = &model.feet[0].polygon;
    let spans = SPANS.map(|span| (format!("parallel_bars_{span}"), Some(span)));
    let names: Vec<(String, Option<u32>)> =
        spans.into_iter().chain(FEATURES.map(|name| (name.to_owned(), None))).collect();
    let bar = progress_bar((names.len() * Sampler::ALL.len()) as u64);
    let mut rows = Vec::new();
    for (name, span_percent) in names {
        let world = load_world(&arguments.worlds.join(format!("{name}.toml")))?;
        let mut samplers = Vec::new();
        for sampler in Sampler::ALL {
            bar.set_message(name.clone());
            samplers.push(run_queries(&world, sole, sampler, arguments.queries, arguments.seed)?);
            bar.inc(1);
            if let Some(signal) = signals::raised() {
                return Err(CommandError::Interrupted(signal));
            }
        }
        rows.push(Row { world: name, span_percent, queries: arguments.queries, samplers });
    }
    bar.finish_and_clear();
    if let Some(folder) = &arguments.out {
        write_files(folder, &rows)?;
    }
    let report = Report {
        schema: "surefoot-bench-footholds/1",
        machine,
        robot: &model.name,
        seed: arguments.seed,
        thesis: THESIS,
        rows: &rows,
    };
    print_report(&report, arguments.json, || table(&rows))?;
    Ok(CommandOutcome::Done)
}

fn progress_bar(length: u64) -> ProgressBar {
    if !terminal::is_watched() {
        return ProgressBar::hidden();
    }
    let style = ProgressStyle::with_template("{bar:20} {pos}/{len} {wide_msg}")
        .unwrap_or_else(|_| ProgressStyle::default_bar());
    ProgressBar::new(length).with_style(style)
}

fn table(rows: &[Row]) -> String {
    let mut text = format!("{:<24}", "success of queries");
    for sampler in Sampler::ALL {
        let _ = write!(text, "{:>22}", sampler.name());
    }
    for row in rows {
        let _ = write!(text, "\n{:<24}", row.world);
        for answers in &row.samplers {
            let _ = write!(
                text,
                "{:>12.1} %{:>5.0} us",
                100.0 * answers.share(row.queries),
                1e6 * answers.seconds_mean
            );
        }
    }
    let _ = write!(text, "\n{THESIS}");
    text
}

fn write_files(folder: &Path, rows: &[Row]) -> Result<(), CommandError> {
    let mut csv =
        "world,span_percent,sampler,queries,found,examined_mean,seconds_mean\n".to_owned();
    for row in rows {
        let span = row.span_percent.map(|span| span.to_string()).unwrap_or_default();
        for answers in &row.samplers {
            let QueryResults { sampler, found, examined_mean, seconds_mean } = answers;
            let _ = writeln!(
                csv,
                "{},{span},{sampler},{},{found},{examined_mean:.3},{seconds_mean:.9}",
                row.world, row.queries
            );
        }
    }
    output_files::write_text(&csv, &folder.join("footholds.csv"))?;
    let curve = |(index, sampler): (usize, Sampler)| {
        let points = rows.iter().filter_map(|row| {
            Some((f64::from(row.span_percent?), 100.0 * row.samplers[index].share(row.queries)))
        });
        plot::Curve { name: sampler.name(), points: points.collect() }
    };
    let curves: Vec<plot::Curve> = Sampler::ALL.into_iter().enumerate().map(curve).collect();
    output_files::write_text(&plot::figure_4_10(&curves), &folder.join("footholds.svg"))
}
