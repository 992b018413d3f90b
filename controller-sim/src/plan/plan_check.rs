//! The checks on an exported plan, made by `surefoot check`.

use std::ops::Range;
use std::path::Path;

use surefoot_shared_types::InputError;
use surefoot_shared_types::base::limits::{JOINTS_MAX, POLYGON_VERTICES_MAX};
use surefoot_shared_types::base::spatial::Pose;
use surefoot_shared_types::message::Margins;
use surefoot_shared_types::message::chunk::ROOT_FREEDOMS;
use surefoot_shared_types::message::{Check, Contact, SupportMode, Waypoint};
use surefoot_shared_types::plan_file::ramps::fitting_chunks;
use surefoot_shared_types::plan_file::read::joint_order;
use surefoot_shared_types::plan_format::blocks::{
    ChunkBlock, ContactBlock, EndBlock, PhaseBlock, PlanFile, PoseBlock, WaypointBlock,
};
use surefoot_shared_types::robot::model::{ACCELERATION_DEFAULT, RobotModel};

use crate::check::checker::Checker;
use crate::check::checks::{PHYSICAL, PhysicalCheck};
use crate::check::course::{Course, Stop, is_resting};
use crate::check::segment::{MotionSegment, Reserves, SegmentReport, Violation};
use crate::chunk::continuity::{Stance, check_transition, contacts_match};
use crate::plan::endpoints::{EndpointReport, check_endpoint};
use crate::plan::problem::Problem;

/// Results of all checks of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct PlanReport {
    /// One result per check: the physical ones in their order, then continuity.
    pub checks: Vec<CheckResult>,
    /// Whether it begins at its declared start.
    pub start: EndpointReport,
    /// Whether it ends at its declared goal.
    pub goal: EndpointReport,
    /// The worst margins of the phases that pass.
    pub margins: Margins,
    /// The worst reserves.
    pub reserves: Reserves,
    /// Whose limits hold, the plan's entries that are not used, and the links that no collision
    /// check covers, one line each.
    pub notes: Vec<String>,
}

/// Result of one check of a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct CheckResult {
    /// The check.
    pub check: Check,
    /// The worst margin among the phases that pass, and the phase; nothing for checks that measure
    /// none.
    pub worst: Option<WorstMargin>,
    /// The first violation, and its phase; its waypoint counts from the plan's beginning.
    pub violation: Option<PhaseViolation>,
}

/// A margin and the phase in which it occurs.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct WorstMargin {
    /// As the field of [`Margins`], or as [`SegmentReport::acceleration`].
    pub margin: f64,
    /// The phase.
    pub phase: usize,
}

/// A violation within a plan.
#[derive(Debug, Clone, PartialEq)]
pub struct PhaseViolation {
    /// The phase.
    pub phase: usize,
    /// The violation, with its waypoint counted from the plan's beginning.
    pub violation: Violation,
}

impl PlanReport {
    /// Whether every check holds and the plan begins and ends where it declares.
    pub fn is_valid(&self) -> bool {
        self.violations().next().is_none()
            && self.start.violation.is_none()
            && self.goal.violation.is_none()
    }

    /// The first violation of each violated check.
    pub fn violations(&self) -> impl Iterator<Item = &PhaseViolation> {
        self.checks.iter().filter_map(|result| result.violation.as_ref())
    }

    /// A scenario names the poses of both soles at either end, so the plan stands on both there.
    fn require_both_feet(&mut self, phases: &[Phase]) {
        let ends = [
            (&mut self.start, phases.first(), "the plan begins on one foot"),
            (&mut self.goal, phases.last(), "the plan ends on one foot"),
        ];
        for (end, phase, reason) in ends {
            if phase.is_some_and(|phase| phase.mode != SupportMode::Double) {
                end.violation.get_or_insert_with(|| reason.to_owned());
            }
        }
    }

    fn add(&mut self, phase: usize, first_waypoint: usize, report: &mut SegmentReport) {
        self.margins = self.margins.min(&report.margins);
        self.reserves = self.reserves.min(&report.reserves);
        for (result, check) in self.checks.iter_mut().zip(PHYSICAL) {
            let margin = check.margin(report).map(|margin| *margin);
            if let Some(margin) = margin.filter(|margin| margin.is_finite())
                && result.worst.is_none_or(|worst| margin < worst.margin)
            {
                result.worst = Some(WorstMargin { margin, phase });
            }
        }
        for result in &mut self.checks {
            let found = report.violations.iter().find(|violation| violation.check == result.check);
            if let (None, Some(violation)) = (&result.violation, found) {
                let waypoint = first_waypoint + violation.waypoint;
                result.violation = Some(PhaseViolation {
                    phase,
                    violation: Violation { waypoint, ..violation.clone() },
                });
            }
        }
    }
}

/// Checks a plan that was loaded from `plan_path`, by its own robot and world and with the
/// checker's default tolerances.
///
/// # Errors
/// Its robot or world cannot be loaded, or the plan does not fit them.
pub fn check_plan(plan: &PlanFile, plan_path: &Path) -> Result<PlanReport, InputError> {
    check_plan_in(plan, plan_path, &Problem::of_plan(plan, plan_path)?)
}

/// Checks a plan that was loaded from `plan_path` as an answer to `problem`.
///
/// # Errors
/// The plan does not fit the robot, or the robot or the world cannot be checked.
pub fn check_plan_in(
    plan: &PlanFile,
    plan_path: &Path,
    problem: &Problem,
) -> Result<PlanReport, InputError> {
    refuse_disturbed(plan, plan_path)?;
    let Problem { model, world, config, start, goal, goal_turn_max, mut notes } = problem.clone();
    let parsed = ParsedPlan::new(plan, &model, plan_path)?;
    let input_error = |error| InputError::element(plan_path, "robot", format!("{error}"));
    let checker = Checker::new(model, world, config).map_err(input_error)?;
    let mut checker = fitted(checker, plan, &parsed, &mut notes);
    let endpoint = |block: &EndBlock, waypoint: &Waypoint, turn_max: Option<f64>| {
        check_endpoint(checker.model(), block, waypoint, &parsed.joint_order, turn_max)
    };
    let result = |check| CheckResult { check, worst: None, violation: None };
    let physical = PHYSICAL.map(PhysicalCheck::check);
    let mut report = PlanReport {
        checks: physical.into_iter().chain([Check::Continuity]).map(result).collect(),
        start: endpoint(&start, &parsed.waypoints[0], None),
        goal: endpoint(&goal, &parsed.waypoints[parsed.waypoints.len() - 1], goal_turn_max),
        margins: Margins::UNMEASURED,
        reserves: Reserves::UNMEASURED,
        notes,
    };
    if goal_turn_max.is_some() {
        report.require_both_feet(&parsed.phases);
    }
    let mut before: Option<Phase> = None;
    for (index, phase) in parsed.phases.into_iter().enumerate() {
        let segment = MotionSegment {
            mode: phase.mode,
            contacts: &phase.contacts,
            waypoints: &parsed.waypoints[phase.range.clone()],
            course: if parsed.is_smooth { Course::Smooth(&phase.stops) } else { Course::Straight },
        };
        let mut found = checker.check_all(&segment);
        let kept = before.take();
        found.violations.extend(kept.as_ref().and_then(|kept| transition_violation(kept, &phase)));
        if let Some(kept) = kept.as_ref().filter(|_| parsed.is_smooth) {
            let begin = &parsed.waypoints[phase.range.start];
            found.violations.extend(check_change(&mut checker, kept, &phase, begin).err());
        }
        found.violations.extend(motion_at_end(&parsed.waypoints, &phase.range));
        report.add(index, phase.range.start, &mut found);
        before = Some(phase.keeping_contacts_of(kept));
    }
    Ok(report)
}

/// The checker as it fits a plan. Notes what it does not see, and what it allows.
fn fitted(
    mut checker: Checker,
    plan: &PlanFile,
    parsed: &ParsedPlan,
    notes: &mut Vec<String>,
) -> Checker {
    notes.extend(checker.unshaped_links().map(|link| {
        format!("not checked for collisions: link {link} has mass and no collision shape")
    }));
    notes.extend(checker.hollow_soles().map(|sole| sole.to_string()));
    checker.excuse_none_clear_in(&parsed.waypoints[0]);
    let checker = with_stops_of(plan, parsed.is_smooth, checker, notes);
    notes.extend(checker.allowed_overlaps().iter().chain(checker.idle_overlaps()).cloned());
    checker
}

/// The checker for the stops that a plan names. Those that it cannot check are noted.
fn with_stops_of(
    plan: &PlanFile,
    is_smooth: bool,
    mut checker: Checker,
    notes: &mut Vec<String>,
) -> Checker {
    if let Err(reason) = fitting_chunks(plan) {
        checker = checker.keeping_default_accelerations();
        notes.push(format!(
            "the stops of the plan's chunks are not checked: {reason}; the plan was edited, and \
             accelerations stay within {ACCELERATION_DEFAULT} where the robot file states no limit"
        ));
    }
    if is_smooth && plan.chunks.is_empty() {
        notes.push("the plan names no chunks, so it has no stops to be checked".to_owned());
    }
    if plan.executed {
        checker = checker.with_stops_in_motion();
        notes.push(
            "a walk as it was executed, with its stops: its feed-forward torques are checked less \
             closely than those of a plan"
                .to_owned(),
        );
    }
    checker
}

/// Refuses a walk as it was executed with misplaced feet, whose motion is not continuous, and one
/// with the chunks of a plan.
fn refuse_disturbed(plan: &PlanFile, plan_path: &Path) -> Result<(), InputError> {
    if plan.executed && !plan.chunks.is_empty() {
        let message = "a walk as it was executed has taken its stops, and names no chunks";
        return Err(InputError::element(plan_path, "executed", message.to_owned()));
    }
    let Some(seed) = plan.disturb_seed else { return Ok(()) };
    let message = format!(
        "the walk set feet down off their places (--disturb {seed}), so legs leap where a foot \
         lands, which no check of a plan allows; check the plan itself, as --export writes it"
    );
    Err(InputError::element(plan_path, "disturb_seed", message))
}

fn transition_violation(before: &Phase, after: &Phase) -> Option<Violation> {
    let detail = check_transition(&before.stance(), &after.stance()).err()?;
    Some(Violation::new(Check::Continuity, 0, detail))
}

/// The checks of a smooth motion where one phase ends and the next one begins.
fn check_change(
    checker: &mut Checker,
    before: &Phase,
    after: &Phase,
    begin: &Waypoint,
) -> Result<(), Violation> {
    if after.lands_after(before) {
        checker.check_landing(&after.contacts, begin)?;
    }
    if after.mode == before.mode {
        checker.check_going_on(&after.contacts, begin)?;
    }
    Ok(())
}

/// A plan in the checker's own types.
struct ParsedPlan {
    waypoints: Vec<Waypoint>,
    phases: Vec<Phase>,
    joint_order: Vec<usize>,
    is_smooth: bool,
}

struct Phase {
    mode: SupportMode,
    contacts: Vec<Contact>,
    /// Its waypoints, both ends included.
    range: Range<usize>,
    /// The stops of the plan's chunks that take place in it.
    stops: Vec<Stop>,
}

impl Phase {
    fn stance(&self) -> Stance<'_> {
        Stance { mode: self.mode, contacts: &self.contacts }
    }

    /// Whether a foot is set down where this phase begins.
    fn lands_after(&self, before: &Self) -> bool {
        self.mode == SupportMode::Double && before.mode != SupportMode::Double
    }

    /// The same phase with each foot that has stayed since the phase before where it was set down,
    /// so that the deviation allowed from one phase to the next does not add up.
    fn keeping_contacts_of(mut self, before: Option<Self>) -> Self {
        for old in before.into_iter().flat_map(|before| before.contacts) {
            if let Some(new) = self.contacts.iter_mut().find(|new| new.limb == old.limb) {
                *new = old;
            }
        }
        self
    }
}

impl ParsedPlan {
    fn new(plan: &PlanFile, model: &RobotModel, plan_path: &Path) -> Result<Self, InputError> {
        let joint_order = joint_order(plan, model, plan_path)?;
        let input_error =
            |element: String, message: &str| InputError::element(plan_path, element, message);
        if plan.waypoints.is_empty() || plan.phases.is_empty() || joint_order.len() > JOINTS_MAX {
            let message = format!("needs waypoints, phases and at most {JOINTS_MAX} joints");
            return Err(InputError::file(plan_path, message));
        }
        if let Some(index) =
            plan.waypoints.iter().position(|waypoint| waypoint.q.len() != joint_order.len())
        {
            return Err(input_error(
                format!("waypoint {index}"),
                "q has not one entry per joint name",
            ));
        }
        let chunks = fitting_chunks(plan).unwrap_or_default();
        let phase = |(index, block)| {
            phase(model, block, &plan.waypoints, chunks)
                .map_err(|message| input_error(format!("phase {index}"), message))
        };
        Ok(Self {
            waypoints: plan.waypoints.iter().map(|block| waypoint(block, &joint_order)).collect(),
            phases: plan.phases.iter().enumerate().map(phase).collect::<Result<_, _>>()?,
            joint_order,
            is_smooth: plan.waypoints.iter().any(|waypoint| !waypoint.velocity.is_empty()),
        })
    }
}

/// A violation if a plan of these waypoints does not begin, or end, at rest within `range`.
fn motion_at_end(waypoints: &[Waypoint], range: &Range<usize>) -> Option<Violation> {
    let last = waypoints.len() - 1;
    let at = [0, last].into_iter().find(|at| range.contains(at) && !is_resting(&waypoints[*at]))?;
    let detail = "the plan begins or ends in motion";
    Some(Violation::new(Check::Continuity, at - range.start, detail))
}

fn waypoint(block: &WaypointBlock, joint_order: &[usize]) -> Waypoint {
    let mut q = [0.0; JOINTS_MAX];
    q.iter_mut().zip(joint_order).for_each(|(position, &place)| *position = block.q[place]);
    let rotation = glam::DQuat::from_array(block.root_quat_xyzw).normalize();
    let root = Pose::from_parts(block.root_xyz.into(), rotation);
    let mut waypoint = Waypoint::at_rest(block.t, &root, &q);
    let root_rates = [
        (&mut waypoint.root_velocity, &block.velocity),
        (&mut waypoint.root_acceleration, &block.acceleration),
    ];
    for (slots, numbers) in root_rates {
        slots.iter_mut().zip(numbers).for_each(|(slot, number)| *slot = *number);
    }
    let joint_rates = [
        (&mut waypoint.joint_velocity, block.velocity.get(ROOT_FREEDOMS..)),
        (&mut waypoint.joint_acceleration, block.acceleration.get(ROOT_FREEDOMS..)),
        (&mut waypoint.torque, block.torque.get(..)),
        (&mut waypoint.rest_torque, block.rest_torque.get(..)),
        (&mut waypoint.rate_change_torque, block.rate_change_torque.get(..)),
    ];
    for (slots, numbers) in joint_rates {
        let Some(numbers) = numbers.filter(|numbers| !numbers.is_empty()) else { continue };
        slots.iter_mut().zip(joint_order).for_each(|(slot, &place)| *slot = numbers[place]);
    }
    waypoint
}

fn phase(
    model: &RobotModel,
    block: &PhaseBlock,
    waypoints: &[WaypointBlock],
    chunks: &[ChunkBlock],
) -> Result<Phase, &'static str> {
    let modes = [SupportMode::Left, SupportMode::Right, SupportMode::Double];
    let mode = modes
        .into_iter()
        .find(|mode| mode.name() == block.mode)
        .ok_or("its mode is none of left, right, double")?;
    if block.last < block.first || block.last >= waypoints.len() {
        return Err("it covers waypoints that are not there");
    }
    let contacts: Vec<Contact> = block
        .contacts
        .iter()
        .map(|block| contact(model, block))
        .collect::<Option<_>>()
        .ok_or("a contact of an unknown foot")?;
    if !contacts_match(&Stance { mode, contacts: &contacts }) {
        return Err("its contacts are not those of its mode");
    }
    let (begin, end) = (waypoints[block.first].t, waypoints[block.last].t);
    let stops = chunks.iter().map(|chunk| Stop {
        brake_at: chunk.brake_at,
        seconds: chunk.brake_duration,
        resume_seconds: chunk.resume_duration,
    });
    let stops = stops.filter(|stop| stop.concerns(begin, end)).collect();
    Ok(Phase { mode, contacts, range: block.first..block.last + 1, stops })
}

fn contact(model: &RobotModel, block: &ContactBlock) -> Option<Contact> {
    let limb = model.feet.iter().position(|foot| foot.name == block.foot)?;
    let sole = &model.feet[limb].polygon;
    let mut polygon = [[0.0; 2]; POLYGON_VERTICES_MAX];
    polygon.iter_mut().zip(sole).for_each(|(vertex, at)| *vertex = at.to_array());
    let PoseBlock { xyz, quat_xyzw } = block.sole_pose;
    let rotation = glam::DQuat::from_array(quat_xyzw).normalize().to_array();
    Some(Contact {
        limb: limb as u32,
        polygon_len: sole.len().min(POLYGON_VERTICES_MAX) as u32,
        position: xyz,
        rotation,
        polygon,
    })
}
