//! The facts of a plan: its steps, its pace, and its tightest margins with their places.

use std::path::Path;

use glam::{DQuat, DVec3};
use surefoot_controller_sim::plan::plan_check::CheckResult;
use surefoot_controller_sim::{Problem, check_plan_in};
use surefoot_shared_types::message::SupportMode;
use surefoot_shared_types::plan_format::blocks::{PhaseBlock, PlanFile, PoseBlock};

use crate::report::command_error::CommandError;
use crate::report::margins::with_unit;
use crate::report::walk_facts::{WalkFacts, add_place};

/// Where a foot stands.
#[derive(Debug, Clone, Copy)]
struct Landing {
    position: DVec3,
    yaw: f64,
}

/// A step: a foot from one place to the next.
#[derive(Debug, Clone, Copy)]
struct Step {
    length: f64,
    rise: f64,
    turn: f64,
}

/// The facts, one line each.
///
/// # Errors
/// The plan's robot or world cannot be used.
pub(super) fn lines(plan: &PlanFile, path: &Path) -> Result<Vec<String>, CommandError> {
    let report = check_plan_in(plan, path, &Problem::of_plan(plan, path)?)?;
    let mut lines = vec![walk(plan)];
    lines.extend(extremes(&steps(plan)));
    let mut tight: Vec<&CheckResult> = report.checks.iter().collect();
    tight.retain(|check| check.worst.is_some() && check.violation.is_none());
    lines.extend(tight.iter().map(|check| margin(plan, check)));
    let violations = report.checks.iter().filter_map(|check| {
        let placed = check.violation.as_ref()?;
        let place = place(plan, placed.phase);
        Some(format!("violated: {}, {place}: {}", check.check.name(), placed.violation))
    });
    lines.extend(violations);
    for (name, end) in [("start", &report.start), ("goal", &report.goal)] {
        lines.extend(end.violation.as_ref().map(|violation| format!("{name}: {violation}")));
    }
    lines.push(if report.is_valid() {
        "the controller's checks accept this plan".to_owned()
    } else {
        "the controller's checks refuse this plan".to_owned()
    });
    Ok(lines)
}

/// Duration, distance and pace.
fn walk(plan: &PlanFile) -> String {
    let time = |index: usize| plan.waypoints.get(index).map_or(0.0, |waypoint| waypoint.t);
    let root = plan.waypoints.iter().map(|waypoint| (waypoint.t, waypoint.root_xyz.into()));
    let mut feet = [Vec::new(), Vec::new()];
    for contact in plan.phases.iter().flat_map(|phase| &phase.contacts) {
        let foot = usize::from(contact.foot == "right");
        add_place(&mut feet[foot], contact.sole_pose.xyz.into());
    }
    let modes = plan.phases.iter().filter_map(|phase| SupportMode::from_name(&phase.mode));
    let facts = WalkFacts::new(root, feet, modes);
    let double = plan.phases.iter().filter(|phase| phase.mode == "double");
    let double: f64 = double.map(|phase| time(phase.last) - time(phase.first)).sum();
    let share = if facts.seconds > 0.0 { double / facts.seconds } else { 0.0 };
    format!("{}, on both feet for {:.0} % of the time", facts.describe(), 100.0 * share)
}

/// The steps in their order.
fn steps(plan: &PlanFile) -> Vec<Step> {
    let mut stands: [Option<Landing>; 2] = [None; 2];
    let mut steps = Vec::new();
    for contact in plan.phases.iter().flat_map(|phase| &phase.contacts) {
        let now = landing(&contact.sole_pose);
        let foot = usize::from(contact.foot == "right");
        if let Some(before) = stands[foot].filter(|before| before.position != now.position) {
            let way = now.position - before.position;
            let turn = (now.yaw - before.yaw + std::f64::consts::PI)
                .rem_euclid(std::f64::consts::TAU)
                - std::f64::consts::PI;
            steps.push(Step { length: way.truncate().length(), rise: way.z, turn });
        }
        stands[foot] = Some(now);
    }
    steps
}

fn landing(pose: &PoseBlock) -> Landing {
    let ahead = DQuat::from_array(pose.quat_xyzw) * DVec3::X;
    Landing { position: pose.xyz.into(), yaw: libm::atan2(ahead.y, ahead.x) }
}

/// The longest, highest, lowest and most turned step.
fn extremes(steps: &[Step]) -> Option<String> {
    let most = |value: fn(&Step) -> f64| steps.iter().map(value).reduce(f64::max);
    Some(format!(
        "the longest step is {:.2} m, the highest {:.2} m up, the lowest {:.2} m down, the most \
         turned {:.0} degrees",
        most(|step| step.length)?,
        most(|step| step.rise)?.max(0.0),
        most(|step| -step.rise)?.max(0.0),
        most(|step| step.turn.abs())?.to_degrees()
    ))
}

fn margin(plan: &PlanFile, check: &CheckResult) -> String {
    let (name, worst) = (check.check.name(), check.worst);
    let (margin, phase) = worst.map_or((f64::NAN, 0), |worst| (worst.margin, worst.phase));
    format!("tightest {name}: {}, {}", with_unit(name, margin), place(plan, phase))
}

/// When and where a phase is.
fn place(plan: &PlanFile, phase: usize) -> String {
    let Some(PhaseBlock { first, last, mode, contacts }) = plan.phases.get(phase) else {
        return format!("phase {phase}");
    };
    let time = |index: &usize| plan.waypoints.get(*index).map_or(0.0, |waypoint| waypoint.t);
    let feet = if mode == "double" { "both feet".to_owned() } else { format!("the {mode} foot") };
    let at = contacts.first().map_or_else(String::new, |contact| {
        let [x, y, z] = contact.sole_pose.xyz;
        format!(" near ({x:.2}, {y:.2}, {z:.2})")
    });
    format!("at {:.1} to {:.1} s on {feet}{at} (phase {phase})", time(first), time(last))
}
