//! Ranges of the parameters, and the relations between the planner's and the checker's.

use crate::config::execution::ExecutionConfig;
use crate::config::parameter::{Parameter, Value};
use crate::config::parameters::PARAMETERS;
use crate::config::planner::{CheckerConfig, PlannerConfig};

/// A parameter's name and its error.
type FieldError = (String, String);

/// The first parameter that is out of range, or of which the planner's value is not strictly
/// stronger than the checker's.
pub(crate) fn check_relations(
    planner: &PlannerConfig,
    checker: &CheckerConfig,
    execution: &ExecutionConfig,
) -> Result<(), FieldError> {
    check_ranges(planner, checker, execution)?;
    check_margins(planner, checker)
}

fn check_ranges(
    planner: &PlannerConfig,
    checker: &CheckerConfig,
    execution: &ExecutionConfig,
) -> Result<(), FieldError> {
    for parameter in &PARAMETERS {
        let value = (parameter.value)(planner, checker, execution);
        if !parameter.range.contains(value) {
            return field_error(parameter.name, range_message(parameter, value));
        }
    }
    Ok(())
}

fn range_message(parameter: &Parameter, value: Value) -> String {
    let message = format!("is {value}; it must be {}", parameter.range);
    match parameter.relation {
        "" => message,
        relation => format!("{message}, and {relation}"),
    }
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

fn stronger(field: &str, planner: f64, checker: f64) -> Result<(), FieldError> {
    if planner > checker {
        return Ok(());
    }
    field_error(
        &format!("planner.{field}"),
        format!("is {planner}; it must be above checker.{field}, {checker}"),
    )
}

fn field_error(field: &str, message: impl Into<String>) -> Result<(), FieldError> {
    Err((field.to_owned(), message.into()))
}
