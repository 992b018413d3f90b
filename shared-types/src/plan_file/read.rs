//! Reads plan files as what they are: hostile input.

use std::path::Path;

use crate::base::input_error::InputError;
use crate::base::text_file::TextFile;
use crate::robot::model::RobotModel;

use crate::plan_file::check::check_plan;
use crate::plan_format::blocks::PlanFile;

/// Largest plan file, bytes.
const PLAN_BYTES_MAX: u64 = 1 << 30;

/// Loads a plan file and checks all that can be checked without the robot and the world that it
/// names.
///
/// # Errors
/// When the file cannot be read, is not `biped-plan/1`, holds a number that is not finite or beyond
/// 1e6, a quaternion that is not unit within 1e-4, waypoints whose time does not increase, or
/// phases that do not tile them.
pub fn load_plan(path: &Path) -> Result<PlanFile, InputError> {
    let source = TextFile::read(path, PLAN_BYTES_MAX)?;
    let plan: PlanFile = serde_json::from_str(&source.text)
        .map_err(|error| InputError::file(path, error.to_string()).at_line(error.line()))?;
    check_plan(&plan).map_err(|(element, message)| InputError::element(path, element, message))?;
    Ok(plan)
}

/// Where in a waypoint's `q` each joint of the robot stands: `q[joint_order[j]]` is the position of
/// `robot.joints[j]`.
///
/// # Errors
/// When the plan's `joint_names` are not exactly the robot's moving joints, in any order.
pub fn joint_order(
    plan: &PlanFile,
    robot: &RobotModel,
    plan_path: &Path,
) -> Result<Vec<usize>, InputError> {
    let input_error = |message: String| Err(InputError::element(plan_path, "joint_names", message));
    if let Some(unknown) =
        plan.joint_names.iter().find(|name| !robot.joints.iter().any(|joint| joint.name == **name))
    {
        return input_error(format!("'{unknown}' is not a moving joint of robot '{}'", robot.name));
    }
    let place_of = |name: &str| plan.joint_names.iter().position(|other| other == name);
    match robot
        .joints
        .iter()
        .map(|joint| place_of(&joint.name).ok_or(&joint.name))
        .collect::<Result<Vec<_>, _>>()
    {
        Ok(order) if order.len() == plan.joint_names.len() => Ok(order),
        Ok(_) => input_error("names a joint twice".into()),
        Err(missing) => {
            input_error(format!("lacks '{missing}'; list it here or under robot.locked_joints"))
        }
    }
}
