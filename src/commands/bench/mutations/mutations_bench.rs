//! Changes plans and checks them.

use std::path::{Path, PathBuf};

use surefoot_controller_sim::check_plan;
use surefoot_planner::Planner;
use surefoot_planner::base::random::{Random, Stream};
use surefoot_shared_types::config::MotionKind;
use surefoot_shared_types::plan_file::write::{plan_from_chunks, save};
use surefoot_shared_types::plan_format::blocks::PlanFile;

use super::kinds::KINDS;
use super::mutations_report::MutationsReport;
use super::subject::Subject;
use crate::cli::bench_arguments::MutationsArguments;
use crate::commands::bench::print_report::print_report;
use crate::commands::bench::scenarios;
use crate::commands::search_loop;
use crate::input::inputs::{Inputs, Overrides};
use crate::input::output_files;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::report::event::PlanResult;

/// The scenarios whose plans are changed, if none is named.
const SCENARIOS: [&str; 4] = ["bars_wide", "ibeam_gap", "stepping_stones", "stairs_bauzil"];

/// A plan as the planner made it.
struct Original {
    /// The scenario and the motion.
    name: String,
    plan: PlanFile,
}

/// Runs the command.
///
/// # Errors
/// When a scenario cannot be used, the controller refuses a plan as it is, an output cannot be
/// written, or a signal comes.
pub fn run(arguments: &MutationsArguments) -> Result<CommandOutcome, CommandError> {
    output_files::check_folder(arguments.out.as_deref())?;
    let folder = arguments.out.clone().unwrap_or_else(|| PathBuf::from("."));
    let mut report = MutationsReport::new(arguments.seed);
    let mut originals = Vec::new();
    for path in paths(arguments) {
        for motion in motions(arguments.motion) {
            originals.extend(planned(&path, *motion, &folder)?);
        }
    }
    if originals.is_empty() {
        return Ok(CommandOutcome::NoPlan);
    }
    report.plans = originals.iter().map(|original| original.name.clone()).collect();
    for number in 0..arguments.plans {
        CommandError::unless_interrupted()?;
        let original = &originals[number as usize % originals.len()];
        let Some((kind, size, plan)) = changed(original, arguments.seed, number) else { continue };
        let path = folder.join(format!("mutation_{number}.json"));
        let refusal = refusal(&plan, &path);
        if arguments.out.is_some() && refusal.is_none() {
            save(&plan, &path)?;
        }
        report.add(kind, refusal, (number, &original.name, size));
    }
    print_report(&report, arguments.json, || report.text())?;
    Ok(if report.has_wrong() { CommandOutcome::Refused } else { CommandOutcome::Done })
}

/// The files of the scenarios.
fn paths(arguments: &MutationsArguments) -> Vec<PathBuf> {
    let asked = &arguments.scenarios.scenarios;
    let names: Vec<&str> = if asked.is_empty() {
        SCENARIOS.into()
    } else {
        asked.iter().map(String::as_str).collect()
    };
    names.into_iter().map(|name| scenarios::path(&arguments.scenarios.configs, name)).collect()
}

fn motions(asked: Option<MotionKind>) -> &'static [MotionKind] {
    match asked {
        None => &[MotionKind::Smooth, MotionKind::QuasiStatic],
        Some(MotionKind::Smooth) => &[MotionKind::Smooth],
        Some(MotionKind::QuasiStatic) => &[MotionKind::QuasiStatic],
    }
}

/// The plan of a scenario, if there is one. The controller must accept it.
fn planned(
    path: &Path,
    motion: MotionKind,
    folder: &Path,
) -> Result<Option<Original>, CommandError> {
    let inputs = Inputs::load(path, Overrides { motion: Some(motion), ..Overrides::default() })?;
    let preparation = inputs.preparation(false)?;
    let Inputs { model, world, scenario, .. } = &inputs;
    let mut planner = Planner::builder(model, world, scenario, preparation).build()?;
    let planned = search_loop::run(&mut planner, scenario.planner.work_max, &mut |_| Ok(()))?;
    if planned.result != PlanResult::Found {
        return Ok(None);
    }
    let plan = plan_from_chunks(model, world, scenario, planner.chunks(), folder);
    let name = format!("{} {}", scenario.name, motion.name());
    match refusal(&plan, &folder.join("plan.json")) {
        None => Ok(Some(Original { name, plan })),
        Some(check) => Err(CommandError::Usage(format!("{name}: refused as it is: {check}"))),
    }
}

/// A change of a plan: its kind, its size and the plan. The kinds take turns; one that changes
/// nothing gives way to the next.
fn changed(original: &Original, seed: u64, number: u64) -> Option<(usize, f64, PlanFile)> {
    (0..KINDS.len()).find_map(|attempt| {
        let mut random = Random::new(seed, Stream::Preparation, number, attempt as u64);
        let index = (random.below(KINDS.len()) + attempt) % KINDS.len();
        let kind = &KINDS[index];
        let [low, high] = kind.sizes.map(libm::log);
        let size = libm::exp(random.uniform(low, high.max(low)));
        let mut subject = Subject { plan: original.plan.clone(), random };
        let is_changed = (kind.change)(&mut subject, size) && subject.plan != original.plan;
        is_changed.then_some((index, size, subject.plan))
    })
}

/// The check that a plan violates first, or why it cannot be checked.
fn refusal(plan: &PlanFile, path: &Path) -> Option<String> {
    let report = match check_plan(plan, path) {
        Ok(report) => report,
        Err(_) => return Some("file".to_owned()),
    };
    let first = report.violations().next().map(|found| found.violation.check.name().to_owned());
    let ends = [("start", &report.start), ("goal", &report.goal)];
    let end = ends.into_iter().find(|(_, end)| end.violation.is_some());
    first.or_else(|| end.map(|(name, _)| name.to_owned()))
}
