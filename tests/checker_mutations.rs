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
use surefoot_shared_types::message::Check;
use surefoot_shared_types::plan_file::read::load_plan;
use surefoot_shared_types::plan_file::write::plan_from_chunks;
use surefoot_shared_types::robot::load::load_robot;
use surefoot_shared_types::scenario::load::load_scenario;
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

/// A scenario of two steps on level ground, for plans that are checked quickly.
fn short_walk(folder: &Path) -> PathBuf {
    let configs = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
    let path = folder.join("short_walk.toml");
    let text = format!(
        "robot = {:?}\nworld = {:?}\n[start]\nxyz = [0.5, 0.0, 0.0]\n[goal]\nxyz = [0.9, 0.0, 0.0]\n",
        configs.join("robots/hubo/robot.toml"),
        configs.join("worlds/flat_walk.toml")
    );
    std::fs::write(&path, text).unwrap();
    path
}

#[test]
fn plans_changed_at_random_are_refused_where_the_change_is_large() {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("accepted");
    std::fs::create_dir(&out).unwrap();
    let output = std::process::Command::new(env!("CARGO_BIN_EXE_surefoot"))
        .env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"))
        .args(["bench", "mutations", "--plans", "168", "--json", "--out"])
        .arg(&out)
        .arg("--scenario")
        .arg(short_walk(folder.path()))
        .output()
        .unwrap();
    let text = String::from_utf8_lossy(&output.stdout);
    assert_eq!(output.status.code(), Some(0), "{text}{output:?}");
    let report: serde_json::Value = serde_json::from_str(&text).unwrap();
    assert_eq!(
        report["plans"],
        serde_json::json!(["short_walk smooth", "short_walk quasi_static"])
    );
    let total = |field: &str| -> u64 {
        let kinds = report["kinds"].as_array().unwrap().iter();
        kinds.map(|kind| kind[field].as_u64().unwrap()).sum()
    };
    let accepted = report["accepted"].as_array().unwrap().len() as u64;
    assert_eq!((total("changed"), total("changed") - total("refused")), (168, accepted), "{text}");
    assert!(accepted > 10 && total("refused") > 84, "{text}");
    // Each accepted plan is a file that the command checks again, with the same result.
    let files: Vec<PathBuf> =
        std::fs::read_dir(&out).unwrap().map(|entry| entry.unwrap().path()).collect();
    assert_eq!(files.len() as u64, accepted);
    for file in &files[..3] {
        assert!(check_plan(&load_plan(file).unwrap(), file).unwrap().is_valid(), "{file:?}");
    }
}
