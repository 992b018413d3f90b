//! A valid plan is damaged in many ways, one at a time. The checker must refuse every one, for the
//! right reason.

#![allow(clippy::unwrap_used, reason = "a panic fails the test")]

#[path = "checker_mutations/damage.rs"]
mod damage;
#[path = "checker_mutations/damages.rs"]
mod damages;
#[path = "../planner/tests/common/preparation.rs"]
mod preparation;

use std::path::{Path, PathBuf};

use damage::DamagedPlan;
use preparation::preparation_for;
use surefoot_controller_sim::{PlanReport, check_plan};
use surefoot_planner::{Outcome, Planner, Status};
use surefoot_shared_types::config::MotionKind;
use surefoot_shared_types::config::load::load_scenario;
use surefoot_shared_types::message::Check;
use surefoot_shared_types::plan_file::read::load_plan;
use surefoot_shared_types::plan_file::write::plan_from_chunks;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::world::load::load_world;

/// Why a damaged plan must be refused.
#[derive(Debug, Clone, Copy, PartialEq)]
enum Reason {
    /// The file itself is refused, with this text in the error.
    File(&'static str),
    /// This check is violated, with this text in the detail.
    Violates(Check, &'static str),
    /// It does not begin at its declared start.
    Start,
    /// It does not end at its declared goal.
    Goal,
}

fn planned(scenario: &str, folder: &Path) -> DamagedPlan {
    let path =
        Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("configs/scenarios/{scenario}.toml"));
    let scenario = load_scenario(&path).unwrap().with_motion(MotionKind::QuasiStatic);
    let (model, world) =
        (load_robot(&scenario.robot_path).unwrap(), load_world(&scenario.world_path).unwrap());
    let mut planner =
        Planner::builder(&model, &world, &scenario, preparation_for(&model, &scenario.planner))
            .build()
            .unwrap();
    assert_eq!(planner.step(u64::MAX), Status::Done(Outcome::Found));
    DamagedPlan {
        plan: plan_from_chunks(&model, &world, &scenario, planner.chunks(), folder),
        folder: folder.to_owned(),
    }
}

/// Result of `surefoot check` on a plan file: the report, or the error.
fn check_exported(damaged: &DamagedPlan) -> Result<PlanReport, String> {
    let path: PathBuf = damaged.folder.join("plan.json");
    std::fs::write(&path, serde_json::to_vec(&damaged.plan).unwrap()).unwrap();
    let plan = load_plan(&path).map_err(|error| error.to_string())?;
    check_plan(&plan, &path).map_err(|error| error.to_string())
}

/// Describes a wrong answer to a damage; nothing if the answer is right.
fn miss(reason: Reason, answer: &Result<PlanReport, String>) -> Option<String> {
    let right = match (reason, answer) {
        (Reason::File(text), Err(error)) => error.contains(text),
        (Reason::Violates(check, text), Ok(report)) => report
            .violations()
            .any(|found| found.violation.check == check && found.violation.detail.contains(text)),
        (Reason::Start, Ok(report)) => report.start.violation.is_some(),
        (Reason::Goal, Ok(report)) => report.goal.violation.is_some(),
        _ => false,
    };
    (!right).then(|| match answer {
        Err(error) => error.clone(),
        Ok(report) => format!(
            "{:?}",
            report.violations().map(|found| found.violation.to_string()).collect::<Vec<_>>()
        ),
    })
}

#[test]
fn every_damage_is_refused_for_its_own_reason() {
    let folder = tempfile::tempdir().unwrap();
    let whole = planned("stepping_stones", folder.path());
    let report = check_exported(&whole).unwrap();
    assert!(report.is_valid(), "{report:#?}");
    let damages = damages::all();
    assert!(damages.len() >= 30, "only {} damages", damages.len());
    let missed: Vec<String> = damages
        .into_iter()
        .filter_map(|(name, reason, damage)| {
            let mut damaged =
                DamagedPlan { plan: whole.plan.clone(), folder: whole.folder.clone() };
            damage(&mut damaged);
            assert_ne!(damaged.plan, whole.plan, "{name} changes nothing");
            miss(reason, &check_exported(&damaged))
                .map(|answer| format!("{name}: expected {reason:?}, got {answer}"))
        })
        .collect();
    assert!(missed.is_empty(), "{}", missed.join("\n"));
}
