//! `surefoot bench scale`: how cost grows with the length of the course (gauntlet_N) and with the
//! size of the world (mesh_terrain_K, made in memory).

use std::path::Path;

use serde::Serialize;

use crate::cli::bench_arguments::{ScaleArguments, ScalePart};
use crate::commands::bench::machine::Machine;
use crate::commands::bench::print_report::print_report;
use crate::commands::bench::row::Row;
use crate::commands::bench::scale::plot::{Curve, log_log};
use crate::commands::bench::scenarios::{self, SEARCHED};
use crate::commands::bench::table::{aligned, count, seconds};
use crate::commands::bench::terrain;
use crate::commands::bench::trial::TrialSetup;
use crate::input::inputs::Inputs;
use crate::input::output_files;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::memory;

/// Everything that is reported.
#[derive(Debug, Serialize)]
struct ScaleReport {
    schema: &'static str,
    machine: Machine,
    gauntlet: Vec<ScaleRow>,
    terrain: Vec<ScaleRow>,
}

/// One size.
#[derive(Debug, Serialize)]
struct ScaleRow {
    /// Copies of the course, or triangles of the world.
    size: u64,
    #[serde(flatten)]
    search: Row,
    /// Memory of the process while the planner is alive, after its last search, bytes.
    resident_bytes: u64,
    /// Mean processor time divided by that of the first row; for gauntlets also divided by the
    /// ratio of the sizes, so that 1 is linear.
    growth: Option<f64>,
}

/// Runs the command.
///
/// # Errors
/// When a scenario cannot be used, a file cannot be written, or a signal comes.
pub fn run(arguments: &ScaleArguments) -> Result<CommandOutcome, CommandError> {
    let wants = |part| arguments.part.is_none_or(|only| only == part);
    let gauntlets = if wants(ScalePart::Gauntlet) { load_gauntlets(arguments)? } else { vec![] };
    let flat = Inputs::load(&scenarios::path(&arguments.configs, "flat_walk"), SEARCHED)?;
    if let Some(folder) = &arguments.out {
        let unwritable = |error: std::io::Error| CommandError::Output {
            path: folder.clone(),
            reason: error.to_string(),
        };
        std::fs::create_dir_all(folder).map_err(unwritable)?;
    }
    let machine = Machine::this()?;
    let mut gauntlet = vec![];
    for (size, inputs) in &gauntlets {
        gauntlet.push(row(arguments, *size, inputs, &machine.program)?);
    }
    let terrain = if wants(ScalePart::Terrain) {
        terrains(arguments, &flat, &machine.program)?
    } else {
        vec![]
    };
    let report = ScaleReport {
        schema: "surefoot-bench-scale/1",
        machine,
        gauntlet: with_growth(gauntlet, |size| size),
        terrain: with_growth(terrain, |_| 1.0),
    };
    if let Some(folder) = &arguments.out {
        write_plots(&report, folder)?;
        output_files::write_json(&report, &folder.join("scale.json"))?;
    }
    print_report(&report, arguments.json, || text(&report))?;
    let complete = report
        .gauntlet
        .iter()
        .chain(&report.terrain)
        .all(|row| row.search.found == row.search.trials);
    Ok(if complete { CommandOutcome::Done } else { CommandOutcome::NoPlan })
}

fn load_gauntlets(arguments: &ScaleArguments) -> Result<Vec<(u64, Inputs)>, CommandError> {
    let load = |size: &u64| {
        Ok((
            *size,
            Inputs::load(
                &scenarios::path(&arguments.configs, &format!("gauntlet_{size}")),
                SEARCHED,
            )?,
        ))
    };
    arguments.gauntlets.iter().map(load).collect()
}

/// The terrains are made and planned on one after the other, since a large one fills much memory.
fn terrains(
    arguments: &ScaleArguments,
    flat: &Inputs,
    program: &str,
) -> Result<Vec<ScaleRow>, CommandError> {
    let row = |&triangles: &u64| {
        row(arguments, triangles, &on_terrain(flat, triangles as usize), program)
    };
    arguments.triangles.iter().map(row).collect()
}

/// A scenario's robot and parameters, walking over the middle of a terrain.
fn on_terrain(flat: &Inputs, triangles: usize) -> Inputs {
    let [start, goal] = terrain::STANCES;
    let mut scenario = flat.scenario.clone();
    scenario.name = format!("mesh_terrain_{triangles}");
    (scenario.start.position, scenario.start.yaw) = (start, 0.0);
    (scenario.goal.position, scenario.goal.yaw) = (goal, 0.0);
    let world = terrain::mesh_terrain(triangles);
    Inputs { scenario, model: flat.model.clone(), world, piped_scenario: None }
}

fn row(
    arguments: &ScaleArguments,
    size: u64,
    inputs: &Inputs,
    program: &str,
) -> Result<ScaleRow, CommandError> {
    let (mut trials, mut resident_bytes) = (vec![], 0);
    for seed in 1..=arguments.trials {
        let setup = TrialSetup { inputs, seed, threads: arguments.threads.count(), check: false };
        let (trial, planner) = setup.search(program)?;
        resident_bytes = memory::resident_bytes();
        drop(planner);
        trials.push(trial);
    }
    Ok(ScaleRow { size, search: Row::of(&trials), resident_bytes, growth: None })
}

/// Rows with their growth against the first, whose cost is taken to be proportional to
/// `expected(size)`.
fn with_growth(mut rows: Vec<ScaleRow>, expected: fn(f64) -> f64) -> Vec<ScaleRow> {
    let Some((size, Some(mean))) =
        rows.first().map(|first| (first.size as f64, first.search.processor_mean_seconds))
    else {
        return rows;
    };
    for row in &mut rows {
        row.growth = row
            .search
            .processor_mean_seconds
            .map(|time| time / mean / (expected(row.size as f64) / expected(size)));
    }
    rows
}

fn write_plots(report: &ScaleReport, folder: &Path) -> Result<(), CommandError> {
    for (name, rows, title, x_name) in [
        ("scale_gauntlet.svg", &report.gauntlet, "Cost of longer courses", "copies of the course"),
        ("scale_terrain.svg", &report.terrain, "Cost of larger worlds", "triangles"),
    ] {
        if rows.is_empty() {
            continue;
        }
        let curve = |name: &str, value: fn(&ScaleRow) -> Option<f64>| Curve {
            name: name.to_owned(),
            points: rows.iter().filter_map(|row| Some((row.size as f64, value(row)?))).collect(),
        };
        let curves = [
            curve("search, s", |row| row.search.mean_seconds),
            curve("get ready, s", |row| row.search.ready_mean_seconds),
            curve("work, million units", |row| row.search.mean_work.map(|work| work / 1e6)),
            curve("memory, GiB", |row| Some(row.resident_bytes as f64 / f64::from(1 << 30))),
        ];
        output_files::write_text(
            &log_log(title, x_name, "as the legend says", &curves),
            &folder.join(name),
        )?;
    }
    Ok(())
}

fn text(report: &ScaleReport) -> String {
    let mut parts = vec![format!("machine: {}", report.machine.describe())];
    for (rows, title) in [
        (&report.gauntlet, "Longer courses; growth 1 is linear"),
        (&report.terrain, "Larger worlds; growth is the time against the smallest"),
    ] {
        if !rows.is_empty() {
            parts.extend([String::new(), title.to_owned(), table(rows)]);
        }
    }
    parts.join("\n")
}

fn table(rows: &[ScaleRow]) -> String {
    let head = [
        "scenario",
        "size",
        "found",
        "search",
        "p95",
        "processor",
        "ready",
        "mean work",
        "memory",
        "arenas",
        "growth",
    ];
    let mib = |bytes: u64| format!("{:.0} MiB", bytes as f64 / f64::from(1 << 20));
    let mut cells = vec![head.map(str::to_owned).to_vec()];
    cells.extend(rows.iter().map(|row| {
        vec![
            row.search.scenario.clone(),
            row.size.to_string(),
            format!("{}/{}", row.search.found, row.search.trials),
            seconds(row.search.mean_seconds),
            seconds(row.search.p95_seconds),
            seconds(row.search.processor_mean_seconds),
            seconds(row.search.ready_mean_seconds),
            count(row.search.mean_work),
            mib(row.resident_bytes),
            mib(row.search.arena_bytes),
            row.growth.map_or("-".to_owned(), |growth| format!("{growth:.2}")),
        ]
    }));
    aligned(&cells)
}
