//! The relations that must hold within and between the planner's and the checker's parameters.

use crate::source::NUMBER_MAX;

use super::{CheckerConfig, PlannerConfig};

/// Most entries of any arena that a scenario may ask for.
const COUNT_MAX: u32 = 1 << 24;

/// A parameter's name and what is wrong with it.
type Complaint = (String, String);

/// Complains about the first parameter that is out of range, or not strictly stronger than what the checker tolerates.
pub(super) fn check_relations(planner: &PlannerConfig, checker: &CheckerConfig) -> Result<(), Complaint> {
    check_planner(planner)?;
    check_checker(checker)?;
    check_margins(planner, checker)
}

fn check_planner(planner: &PlannerConfig) -> Result<(), Complaint> {
    if planner.work_max == 0 {
        return complain("planner.work_max", "is 0; it must be positive");
    }
    for (field, count) in [
        ("planner.stations_max", planner.stations_max),
        ("planner.footholds_max", planner.footholds_max),
        ("planner.transitions_max", planner.transitions_max),
        ("planner.configurations_max", planner.configurations_max),
        ("planner.waypoints_max", planner.waypoints_max),
    ] {
        if !(2..=COUNT_MAX).contains(&count) {
            return complain(field, format!("is {count}; it must lie between 2 and {COUNT_MAX}"));
        }
    }
    not_negative("planner.polish_share", planner.polish_share)?;
    positive("planner.clearance", planner.clearance)?;
    share("planner.effort_share", planner.effort_share)?;
    not_negative("planner.joint_margin", planner.joint_margin)?;
    not_negative("planner.com_margin", planner.com_margin)?;
    positive("planner.waypoint_joint_step", planner.waypoint_joint_step)?;
    positive("planner.collision_step", planner.collision_step)?;
    positive("planner.support_area_min", planner.support_area_min)?;
    positive("planner.station_spacing", planner.station_spacing)
}

fn check_checker(checker: &CheckerConfig) -> Result<(), Complaint> {
    positive("checker.foot_position_max", checker.foot_position_max)?;
    positive("checker.foot_rotation_max", checker.foot_rotation_max)?;
    positive("checker.contact_gap_max", checker.contact_gap_max)?;
    positive("checker.contact_tilt_max", checker.contact_tilt_max)?;
    not_negative("checker.support_area_min", checker.support_area_min)?;
    not_negative("checker.penetration_max", checker.penetration_max)?;
    not_negative("checker.com_margin", checker.com_margin)?;
    share("checker.effort_share", checker.effort_share)?;
    positive("checker.joint_step_max", checker.joint_step_max)?;
    positive("checker.root_step_max", checker.root_step_max)
}

fn check_margins(planner: &PlannerConfig, checker: &CheckerConfig) -> Result<(), Complaint> {
    above("com_margin", planner.com_margin, checker.com_margin)?;
    above("support_area_min", planner.support_area_min, checker.support_area_min)?;
    if planner.effort_share >= checker.effort_share {
        return complain(
            "planner.effort_share",
            format!("is {}; it must be below checker.effort_share, {}", planner.effort_share, checker.effort_share),
        );
    }
    if planner.waypoint_joint_step >= checker.joint_step_max {
        return complain(
            "planner.waypoint_joint_step",
            format!("is {}; it must be below checker.joint_step_max, {}", planner.waypoint_joint_step, checker.joint_step_max),
        );
    }
    if planner.clearance <= 0.5 * planner.collision_step {
        return complain(
            "planner.clearance",
            format!("is {}; it must be above half of planner.collision_step, {}", planner.clearance, planner.collision_step),
        );
    }
    Ok(())
}

fn above(field: &str, planner: f64, checker: f64) -> Result<(), Complaint> {
    if planner > checker {
        return Ok(());
    }
    complain(&format!("planner.{field}"), format!("is {planner}; it must be above checker.{field}, {checker}"))
}

fn positive(field: &str, value: f64) -> Result<(), Complaint> {
    if value > 0.0 && value <= NUMBER_MAX {
        return Ok(());
    }
    complain(field, format!("is {value}; it must be positive and finite"))
}

fn not_negative(field: &str, value: f64) -> Result<(), Complaint> {
    if (0.0..=NUMBER_MAX).contains(&value) {
        return Ok(());
    }
    complain(field, format!("is {value}; it must be finite and not negative"))
}

fn share(field: &str, value: f64) -> Result<(), Complaint> {
    if value > 0.0 && value <= 1.0 {
        return Ok(());
    }
    complain(field, format!("is {value}; a share lies above 0 and at most at 1"))
}

fn complain(field: &str, message: impl Into<String>) -> Result<(), Complaint> {
    Err((field.to_owned(), message.into()))
}
