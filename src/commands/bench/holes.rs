//! `surefoot bench holes`: small worlds in which a search without one of its last resorts finds
//! nothing, searched with it and without it: docs/COMPLETENESS.md.

use std::num::NonZeroUsize;
use std::path::Path;

use glam::DVec3;
use serde::Serialize;
use surefoot_planner::Planner;
use surefoot_planner::pipeline::resorts::Resort;
use surefoot_planner::preparation::Preparation;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::config::MotionKind;
use surefoot_shared_types::world::load::load_world;

use crate::cli::bench_arguments::HolesArguments;
use crate::commands::bench::machine::Machine;
use crate::commands::bench::print_report::print_report;
use crate::commands::bench::statistics::mean;
use crate::commands::bench::table::{aligned, count, seconds};
use crate::commands::bench::trial::{Trial, TrialSetup};
use crate::input::inputs::{Inputs, Overrides};
use crate::report::command_error::{CommandError, CommandOutcome};

/// A small world in which the search needs one of its last resorts.
#[derive(Debug, Clone, Copy)]
struct Hole {
    world: &'static str,
    /// Where the walk ends along x and z, m.
    goal: [f64; 2],
    /// Work units of each search at most, unless the command allows fewer.
    work_max: u64,
}

/// A search of a world.
#[derive(Debug, Clone, Copy)]
struct Variant {
    hole: Hole,
    /// The last resort that is left out.
    without: Option<Resort>,
    live_routes: u32,
    /// Whether every search is to find a plan.
    is_required: bool,
}

const fn hole(world: &'static str, goal: [f64; 2], work_max: u64) -> Hole {
    Hole { world, goal, work_max }
}

const fn variant(hole: Hole, without: Option<Resort>, live_routes: u32) -> Variant {
    Variant { hole, without, live_routes, is_required: without.is_none() }
}

const LONG_WALL: Hole = hole("long_wall", [2.7, 0.0], 200_000);
const LOW_BEAM: Hole = hole("low_beam", [4.3, 0.0], 400_000);
const PILLORY: Hole = hole("pillory", [3.0, 0.0], 400_000);
const PEGS: Hole = hole("pegs", [4.5, 0.0], 400_000);
const DEAD_END: Hole = hole("dead_end", [5.3, 0.0], 400_000);
/// Each world with the last resort that it needs, and without; a dead end with more live routes.
const VARIANTS: [Variant; 11] = [
    variant(LONG_WALL, None, 1),
    variant(LONG_WALL, Some(Resort::WiderRegion), 1),
    variant(LOW_BEAM, None, 1),
    variant(LOW_BEAM, Some(Resort::LeaningRoot), 1),
    variant(PILLORY, None, 1),
    variant(PILLORY, Some(Resort::GoalPostures), 1),
    variant(PEGS, None, 1),
    variant(PEGS, Some(Resort::LeastMargins), 1),
    Variant { is_required: false, ..variant(DEAD_END, None, 1) },
    variant(DEAD_END, None, 2),
    variant(DEAD_END, None, 3),
];
/// Where every walk begins along x, m.
const START: f64 = 0.7;

/// The searches of one world with all last resorts, or without one.
#[derive(Debug, Serialize)]
struct HoleRow {
    world: &'static str,
    /// The resort that is left out.
    without: Option<&'static str>,
    live_routes: u32,
    trials: usize,
    found: usize,
    /// Of the searches that found a plan: seconds and work units.
    mean_seconds: Option<f64>,
    mean_work: Option<f64>,
    /// Plans that the controller checked, and that it refused.
    checked: usize,
    refused: usize,
    /// Digest over the digests of all plans in the order of the seeds.
    digest: String,
}

#[derive(Debug, Serialize)]
struct Report {
    schema: &'static str,
    machine: Machine,
    work_max: u64,
    rows: Vec<HoleRow>,
}

/// Runs the command.
///
/// # Errors
/// When an input cannot be used, or a signal comes.
pub fn run(arguments: &HolesArguments) -> Result<CommandOutcome, CommandError> {
    let machine = Machine::this()?;
    let is_chosen = |variant: &&Variant| variant.hole.world.contains(&arguments.world);
    let variants: Vec<&Variant> = VARIANTS.iter().filter(is_chosen).collect();
    let rows = variants
        .iter()
        .map(|variant| row(arguments, variant))
        .collect::<Result<Vec<HoleRow>, _>>()?;
    let report =
        Report { schema: "surefoot-bench-holes/1", machine, work_max: arguments.work, rows };
    print_report(&report, arguments.json, || text(&report))?;
    let is_whole =
        |(row, variant): (&HoleRow, &Variant)| !variant.is_required || row.found == row.trials;
    Ok(if report.rows.iter().any(|row| row.refused > 0) {
        CommandOutcome::Refused
    } else if report.rows.iter().zip(variants).all(is_whole) {
        CommandOutcome::Done
    } else {
        CommandOutcome::NoPlan
    })
}

/// The world of a hole, with the reference robot and quasi-static motion.
fn inputs(folder: &Path, variant: &Variant) -> Result<Inputs, CommandError> {
    let Hole { world, goal: [x, z], .. } = variant.hole;
    let overrides = Overrides { motion: Some(MotionKind::QuasiStatic), ..Overrides::default() };
    let mut inputs = Inputs::load(&folder.join("scenarios/flat_walk.toml"), overrides)?;
    inputs.world = load_world(&folder.join(format!("worlds/holes/{world}.toml")))?;
    inputs.scenario.name = world.to_owned();
    inputs.scenario.start.position = START * DVec3::X;
    inputs.scenario.goal.position = DVec3::new(x, 0.0, z);
    inputs.scenario.planner.live_routes = variant.live_routes;
    Ok(inputs)
}

/// Searches with the seeds from 1 on.
fn row(arguments: &HolesArguments, variant: &Variant) -> Result<HoleRow, CommandError> {
    let inputs = inputs(&arguments.folder, variant)?;
    let preparation = inputs.preparation(false)?;
    let trials = (1..=arguments.trials)
        .map(|seed| trial(arguments, (&inputs, &preparation), seed, variant))
        .collect::<Result<Vec<Trial>, _>>()?;
    let found: Vec<&Trial> = trials.iter().filter(|trial| trial.is_found()).collect();
    let of_found = |value: fn(&Trial) -> f64| {
        mean(&found.iter().map(|trial| value(trial)).collect::<Vec<f64>>())
    };
    let endings: Vec<&str> =
        trials.iter().map(|trial| trial.digest.as_deref().unwrap_or(&trial.outcome)).collect();
    Ok(HoleRow {
        world: variant.hole.world,
        without: variant.without.map(Resort::name),
        live_routes: variant.live_routes,
        trials: trials.len(),
        found: found.len(),
        mean_seconds: of_found(|trial| trial.seconds),
        mean_work: of_found(|trial| trial.work as f64),
        checked: trials.iter().filter(|trial| trial.check_result.is_some()).count(),
        refused: trials.iter().filter(|trial| trial.is_refused()).count(),
        digest: Digest::of(&endings.iter().map(|ending| ending.as_bytes()).collect::<Vec<_>>())
            .to_string(),
    })
}

/// One search; the controller checks a plan.
fn trial(
    arguments: &HolesArguments,
    (inputs, preparation): (&Inputs, &Preparation),
    seed: u64,
    variant: &Variant,
) -> Result<Trial, CommandError> {
    let Inputs { model, world, scenario, .. } = inputs;
    let scenario = scenario.clone().with_seed(seed);
    let threads = arguments.threads.count();
    let make = || {
        let mut planner = Planner::builder(model, world, &scenario, preparation.clone())
            .threads(threads)
            .build()?;
        planner.limit_work(arguments.work.min(variant.hole.work_max));
        if let Some(resort) = variant.without {
            planner.leave_out(resort);
            planner.search_on();
        }
        Ok(planner)
    };
    let setup = TrialSetup { inputs, seed, threads: NonZeroUsize::MIN, check: true };
    let (trial, planner) = setup.search_with("holes", &make)?;
    let check_result = if trial.is_found() { Some(setup.check_result(&planner)?) } else { None };
    Ok(Trial { check_result, ..trial })
}

fn text(report: &Report) -> String {
    let head = [
        "world",
        "without",
        "live routes",
        "searches",
        "found",
        "seconds",
        "work",
        "checked",
        "refused",
    ];
    let row = |row: &HoleRow| {
        vec![
            row.world.to_owned(),
            row.without.unwrap_or("").to_owned(),
            row.live_routes.to_string(),
            row.trials.to_string(),
            row.found.to_string(),
            seconds(row.mean_seconds),
            count(row.mean_work),
            row.checked.to_string(),
            row.refused.to_string(),
        ]
    };
    let rows: Vec<Vec<String>> = std::iter::once(head.map(str::to_owned).to_vec())
        .chain(report.rows.iter().map(row))
        .collect();
    format!("machine: {}\n\n{}", report.machine.describe(), aligned(&rows))
}
