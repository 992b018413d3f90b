//! Reads plan files as untrusted input.

use std::path::Path;

use crate::base::file_kind::FileKind;
use crate::base::input_error::InputError;
use crate::base::text_file::TextFile;
use crate::plan_file::check::check_plan;
use crate::plan_file::keys::check_keys;
use crate::plan_format::blocks::PlanFile;
use crate::robot::load::robot_from_block;
use crate::robot::model::RobotModel;
use crate::world::load::world_from_block;
use crate::world::world::World;

/// Largest size of a plan file, bytes.
const PLAN_BYTES_MAX: u64 = 1 << 30;

/// Loads a plan file and checks it as far as possible without the robot and the world.
///
/// # Errors
/// The file cannot be read or is not `biped-plan/1`; a number is not finite or exceeds 1e6; the
/// length of a quaternion differs from 1 by more than 1e-4; the time of the waypoints does not
/// increase; a key is nearly a known one; or the phases do not cover the waypoints in order.
pub fn load_plan(path: &Path) -> Result<PlanFile, InputError> {
    let source = TextFile::read(path, FileKind::Plan, PLAN_BYTES_MAX)?;
    let text = source.text.trim_start_matches('\u{feff}');
    let plan: PlanFile = serde_json::from_str(text).map_err(|error| {
        let message = match error.is_eof() {
            true => "ends in the middle, as if it were cut; copy or export it again".to_owned(),
            false => error.to_string(),
        };
        let refused = InputError::file(path, message).at_line(error.line());
        FileKind::Plan.needed_instead(path, source.text.as_bytes(), refused)
    })?;
    let checked = check_keys(text).and_then(|()| check_plan(&plan));
    checked.map_err(|(element, message)| InputError::element(path, element, message))?;
    Ok(plan)
}

/// The robot and the world that a plan file names, by paths relative to it.
///
/// # Errors
/// One of them cannot be used.
pub fn robot_and_world(
    plan: &PlanFile,
    plan_path: &Path,
) -> Result<(RobotModel, World), InputError> {
    let folder = plan_path.parent().unwrap_or(Path::new(""));
    let model = robot_from_block(&plan.robot, folder, plan_path)?;
    Ok((model, world_from_block(&plan.scene, folder, plan_path)?))
}

/// The index of each joint of the robot in a waypoint's `q`: `q[joint_order[j]]` is the position of
/// `robot.joints[j]`.
///
/// # Errors
/// The plan's `joint_names` are not exactly the robot's moving joints, in any order.
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
    let index_of = |name: &str| plan.joint_names.iter().position(|other| other == name);
    match robot
        .joints
        .iter()
        .map(|joint| index_of(&joint.name).ok_or(&joint.name))
        .collect::<Result<Vec<_>, _>>()
    {
        Ok(order) if order.len() == plan.joint_names.len() => Ok(order),
        Ok(_) => input_error("names a joint twice".into()),
        Err(missing) => {
            input_error(format!("lacks '{missing}'; list it here or under robot.locked_joints"))
        }
    }
}
