//! Ranges of the parameters, and the relations between the planner's and the checker's.

use crate::base::text_file::NUMBER_MAX;
use crate::config::planner::{
    CONTACT_GAP_MAX, CONTACT_TILT_MAX, CheckerConfig, FOOT_DRIFT_MAX, FOOT_TURN_MAX, PlannerConfig,
};

/// Smallest `waypoint_joint_step` and `collision_step`, rad or m. Smaller steps add work without
/// use.
const STEP_MIN: f64 = 1e-3;
/// Smallest `support_area_min` of the planner, m2.
const AREA_MIN: f64 = 1e-6;
/// Smallest `route_vertex_spacing`, m.
const SPACING_MIN: f64 = 0.02;
/// Largest `joint_margin`, rad or m.
const JOINT_MARGIN_MAX: f64 = 0.5;

/// A parameter's name and its error.
type FieldError = (String, String);

/// The first parameter that is out of range, or of which the planner's value is not strictly
/// stronger than the checker's.
pub(crate) fn check_relations(
    planner: &PlannerConfig,
    checker: &CheckerConfig,
) -> Result<(), FieldError> {
    check_planner(planner)?;
    check_checker(checker)?;
    check_margins(planner, checker)?;
    check_tolerances(checker)
}

fn check_planner(planner: &PlannerConfig) -> Result<(), FieldError> {
    if planner.work_max == 0 {
        return field_error("planner.work_max", "is 0; it must be positive");
    }
    // Each arena fits into a few GiB.
    for (field, count, most) in [
        ("planner.tree_vertices_max", planner.tree_vertices_max, 1 << 18),
        ("planner.footholds_max", planner.footholds_max, 1 << 20),
        ("planner.transitions_max", planner.transitions_max, 1 << 24),
        ("planner.configurations_max", planner.configurations_max, 1 << 20),
        ("planner.waypoints_max", planner.waypoints_max, 1 << 21),
    ] {
        if !(2..=most).contains(&count) {
            return field_error(field, format!("is {count}; it must lie between 2 and {most}"));
        }
    }
    not_negative("planner.shortcut_work_share", planner.shortcut_work_share)?;
    positive("planner.clearance", planner.clearance)?;
    fraction("planner.effort_share", planner.effort_share)?;
    between("planner.joint_margin", planner.joint_margin, 0.0, JOINT_MARGIN_MAX)?;
    not_negative("planner.com_margin", planner.com_margin)?;
    between("planner.waypoint_joint_step", planner.waypoint_joint_step, STEP_MIN, NUMBER_MAX)?;
    between("planner.collision_step", planner.collision_step, STEP_MIN, NUMBER_MAX)?;
    between("planner.support_area_min", planner.support_area_min, AREA_MIN, NUMBER_MAX)?;
    between("planner.route_vertex_spacing", planner.route_vertex_spacing, SPACING_MIN, NUMBER_MAX)
}

fn check_checker(checker: &CheckerConfig) -> Result<(), FieldError> {
    positive("checker.foot_position_max", checker.foot_position_max)?;
    positive("checker.foot_rotation_max", checker.foot_rotation_max)?;
    positive("checker.contact_gap_max", checker.contact_gap_max)?;
    positive("checker.contact_tilt_max", checker.contact_tilt_max)?;
    not_negative("checker.support_area_min", checker.support_area_min)?;
    not_negative("checker.penetration_max", checker.penetration_max)?;
    not_negative("checker.com_margin", checker.com_margin)?;
    fraction("checker.effort_share", checker.effort_share)?;
    positive("checker.joint_step_max", checker.joint_step_max)?;
    positive("checker.root_step_max", checker.root_step_max)
}

fn check_margins(planner: &PlannerConfig, checker: &CheckerConfig) -> Result<(), FieldError> {
    stronger("com_margin", planner.com_margin, checker.com_margin)?;
    stronger("support_area_min", planner.support_area_min, checker.support_area_min)?;
    if planner.effort_share >= checker.effort_share {
        return field_error(
            "planner.effort_share",
            format!(
                "is {}; it must be below checker.effort_share, {}",
                planner.effort_share, checker.effort_share
            ),
        );
    }
    if planner.waypoint_joint_step >= checker.joint_step_max {
        return field_error(
            "planner.waypoint_joint_step",
            format!(
                "is {}; it must be below checker.joint_step_max, {}",
                planner.waypoint_joint_step, checker.joint_step_max
            ),
        );
    }
    if planner.clearance <= 0.5 * planner.collision_step {
        return field_error(
            "planner.clearance",
            format!(
                "is {}; it must be above half of planner.collision_step, {}",
                planner.clearance, planner.collision_step
            ),
        );
    }
    Ok(())
}

/// The checker's tolerances exceed the planner's fixed ones.
fn check_tolerances(checker: &CheckerConfig) -> Result<(), FieldError> {
    for (field, value, kept) in [
        ("checker.foot_position_max", checker.foot_position_max, FOOT_DRIFT_MAX),
        ("checker.foot_rotation_max", checker.foot_rotation_max, FOOT_TURN_MAX),
        ("checker.contact_gap_max", checker.contact_gap_max, CONTACT_GAP_MAX),
        ("checker.contact_tilt_max", checker.contact_tilt_max, CONTACT_TILT_MAX),
    ] {
        if value <= kept {
            return field_error(
                field,
                format!("is {value}; it must be above {kept}, the tolerance of the planner"),
            );
        }
    }
    Ok(())
}

fn stronger(field: &str, planner: f64, checker: f64) -> Result<(), FieldError> {
    if planner > checker {
        return Ok(());
    }
    field_error(
        &format!("planner.{field}"),
        format!("is {planner}; it must be above checker.{field}, {checker}"),
    )
}

fn positive(field: &str, value: f64) -> Result<(), FieldError> {
    if value > 0.0 && value <= NUMBER_MAX {
        return Ok(());
    }
    field_error(field, format!("is {value}; it must be positive and finite"))
}

fn between(field: &str, value: f64, least: f64, most: f64) -> Result<(), FieldError> {
    if (least..=most).contains(&value) {
        return Ok(());
    }
    field_error(field, format!("is {value}; it must lie between {least} and {most}"))
}

fn not_negative(field: &str, value: f64) -> Result<(), FieldError> {
    if (0.0..=NUMBER_MAX).contains(&value) {
        return Ok(());
    }
    field_error(field, format!("is {value}; it must be finite and not negative"))
}

fn fraction(field: &str, value: f64) -> Result<(), FieldError> {
    if value > 0.0 && value <= 1.0 {
        return Ok(());
    }
    field_error(field, format!("is {value}; it must be above 0 and at most 1"))
}

fn field_error(field: &str, message: impl Into<String>) -> Result<(), FieldError> {
    Err((field.to_owned(), message.into()))
}
