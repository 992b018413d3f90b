//! Validates joints: kinds, axes, limits, and which of them are locked.

use glam::DVec3;

use crate::base::input_error::InputError;
use crate::base::spatial::Pose;
use crate::base::spatial::rotation_from_rpy;
use crate::base::text_file::FileLocation;

use crate::robot::model::{ACCELERATION_DEFAULT, Joint, JointKind, LockedJoint};
use crate::robot::spec::{JointValues, RobotSpec};
use crate::robot::urdf::Urdf;

/// What becomes of a URDF joint.
pub(crate) enum JointRole {
    /// It moves; `child` is still to be filled in.
    Moving(Joint),
    /// It is fixed: `parent_from_child`.
    Fixed(Pose),
    /// It is locked: `parent_from_child` at its position. The joint's `child` is still to be filled
    /// in.
    Locked(Pose, LockedJoint),
}

/// The joint frame in the parent link's frame.
pub(crate) fn parent_from_joint(joint: &urdf_rs::Joint) -> Pose {
    pose_from_origin(&joint.origin)
}

/// The pose that a URDF `<origin>` states.
pub(crate) fn pose_from_origin(origin: &urdf_rs::Pose) -> Pose {
    let [roll, pitch, yaw] = *origin.rpy;
    Pose::from_parts(DVec3::from_array(*origin.xyz), rotation_from_rpy(roll, pitch, yaw))
}

/// Decides what a URDF joint becomes under a robot file.
pub(crate) fn joint_role(
    urdf: &Urdf,
    index: usize,
    spec: &RobotSpec,
) -> Result<JointRole, InputError> {
    let joint = &urdf.robot.joints[index];
    let kind = match joint.joint_type {
        urdf_rs::JointType::Fixed => return Ok(JointRole::Fixed(parent_from_joint(joint))),
        urdf_rs::JointType::Revolute | urdf_rs::JointType::Continuous => JointKind::Revolute,
        urdf_rs::JointType::Prismatic => JointKind::Prismatic,
        _ => {
            return Err(input_error(
                urdf,
                index,
                "moves in more than one direction; only revolute, continuous, prismatic and fixed joints are supported",
            ));
        }
    };
    let axis = unit_axis(joint).map_err(|message| input_error(urdf, index, message))?;
    let position = match spec.locked.get(&joint.name) {
        Some((position, location)) => {
            check_locked_position(urdf, index, *position, location)?;
            Some(*position)
        }
        None => followed_position(urdf, index, spec)?,
    };
    match position {
        None => moving_joint(urdf, index, kind, axis, spec),
        Some(position) => {
            let locked = locked_joint(urdf, index, (kind, axis), position, spec)?;
            Ok(JointRole::Locked(locked.parent_from_joint * kind.motion(axis, position), locked))
        }
    }
}

/// Where a joint is held that mimics one that is held; `None` for one that mimics none.
fn followed_position(
    urdf: &Urdf,
    index: usize,
    spec: &RobotSpec,
) -> Result<Option<f64>, InputError> {
    let Some(mimic) = &urdf.robot.joints[index].mimic else { return Ok(None) };
    let Some((leader, _)) = spec.locked.get(&mimic.joint) else {
        let message = format!(
            "mimics '{}', which moves; lock that one in the robot file, and this one is held with it",
            mimic.joint
        );
        return Err(input_error(urdf, index, message));
    };
    let position = mimic.multiplier.unwrap_or(1.0) * leader + mimic.offset.unwrap_or(0.0);
    match locked_limits(urdf, index) {
        (lower, upper) if (lower..=upper).contains(&position) => Ok(Some(position)),
        (lower, upper) => {
            let message = format!(
                "mimics '{}' to {position}, outside its limits {lower}..{upper}; lock it, too",
                mimic.joint
            );
            Err(input_error(urdf, index, message))
        }
    }
}

/// Refuses names in a table that are not moving joints of the URDF.
pub(crate) fn check_names(
    urdf: &Urdf,
    table: &str,
    values: &JointValues,
) -> Result<(), InputError> {
    for (name, (_, location)) in values {
        let input_error = |message: &str| Err(location.error(format!("{table} '{name}'"), message));
        match urdf.robot.joints.iter().find(|joint| joint.name == *name) {
            None => return input_error("the URDF has no joint of this name"),
            Some(joint) if joint.joint_type == urdf_rs::JointType::Fixed => {
                return input_error("this joint is fixed; remove the entry");
            }
            Some(_) => {}
        }
    }
    Ok(())
}

fn moving_joint(
    urdf: &Urdf,
    index: usize,
    kind: JointKind,
    axis: DVec3,
    spec: &RobotSpec,
) -> Result<JointRole, InputError> {
    let joint = &urdf.robot.joints[index];
    let facts = &urdf.joint_facts[index];
    let refuse = |message: String| Err(input_error(urdf, index, message));
    if !facts.has_limit {
        return refuse(
            "has no <limit>; state lower, upper, effort and velocity, or lock it in the robot file"
                .into(),
        );
    }
    let (lower, upper) = position_limits(joint);
    if lower >= upper || !lower.is_finite() || !upper.is_finite() {
        return refuse(format!(
            "its limits {lower}..{upper} leave no room to move; correct them or lock it in the robot file"
        ));
    }
    if !(joint.limit.effort > 0.0 && joint.limit.effort.is_finite()) {
        return refuse(format!(
            "effort must be positive, but is {}; state it in <limit>, or lock the joint in the robot file",
            joint.limit.effort
        ));
    }
    if !(joint.limit.velocity > 0.0 && joint.limit.velocity.is_finite()) {
        return refuse(format!(
            "velocity must be positive, but is {}; state it in <limit>, or lock the joint in the robot file",
            joint.limit.velocity
        ));
    }
    let effort = tightened_effort(joint, joint.limit.effort, spec)?;
    let (velocity, acceleration) = (joint.limit.velocity, acceleration(joint, spec)?);
    Ok(JointRole::Moving(Joint {
        name: joint.name.clone(),
        kind,
        axis,
        child: 0,
        lower,
        upper,
        effort,
        velocity,
        acceleration,
    }))
}

/// A locked joint needs no limits of its own: what is not stated is not limited.
fn locked_joint(
    urdf: &Urdf,
    index: usize,
    (kind, axis): (JointKind, DVec3),
    position: f64,
    spec: &RobotSpec,
) -> Result<LockedJoint, InputError> {
    let joint = &urdf.robot.joints[index];
    let stated = |limit: f64| {
        if urdf.joint_facts[index].has_limit && limit > 0.0 { limit } else { f64::INFINITY }
    };
    let effort = tightened_effort(joint, stated(joint.limit.effort), spec)?;
    let (lower, upper) = locked_limits(urdf, index);
    let (velocity, acceleration) = (stated(joint.limit.velocity), acceleration(joint, spec)?);
    let joint_model = Joint {
        name: joint.name.clone(),
        kind,
        axis,
        child: 0,
        lower,
        upper,
        effort,
        velocity,
        acceleration,
    };
    Ok(LockedJoint { joint: joint_model, position, parent_from_joint: parent_from_joint(joint) })
}

/// Where a joint may be locked.
fn locked_limits(urdf: &Urdf, index: usize) -> (f64, f64) {
    let joint = &urdf.robot.joints[index];
    let is_bounded =
        urdf.joint_facts[index].has_limit && joint.joint_type != urdf_rs::JointType::Continuous;
    if is_bounded { position_limits(joint) } else { (f64::NEG_INFINITY, f64::INFINITY) }
}

fn position_limits(joint: &urdf_rs::Joint) -> (f64, f64) {
    match joint.joint_type {
        urdf_rs::JointType::Continuous => (-std::f64::consts::PI, std::f64::consts::PI),
        _ => (joint.limit.lower, joint.limit.upper),
    }
}

fn tightened_effort(
    joint: &urdf_rs::Joint,
    stated: f64,
    spec: &RobotSpec,
) -> Result<f64, InputError> {
    let limit = match spec.effort_limits.get(&joint.name) {
        None => stated,
        Some((effort, _)) if *effort > 0.0 && *effort <= stated => *effort,
        Some((effort, location)) => {
            let message =
                format!("is {effort}; it must be positive and at most the URDF's {stated}");
            return Err(location.error(format!("[effort_limits] '{}'", joint.name), message));
        }
    };
    Ok(limit * spec.effort_scale)
}

fn acceleration(joint: &urdf_rs::Joint, spec: &RobotSpec) -> Result<f64, InputError> {
    match spec.accelerations.get(&joint.name) {
        None => Ok(ACCELERATION_DEFAULT),
        Some((limit, _)) if *limit > 0.0 => Ok(*limit),
        Some((limit, location)) => Err(location.error(
            format!("[accelerations] '{}'", joint.name),
            format!("is {limit}; it must be positive"),
        )),
    }
}

fn check_locked_position(
    urdf: &Urdf,
    index: usize,
    position: f64,
    location: &FileLocation,
) -> Result<(), InputError> {
    let (name, (lower, upper)) = (&urdf.robot.joints[index].name, locked_limits(urdf, index));
    if !(lower..=upper).contains(&position) {
        return Err(location.error(
            format!("[locked] '{name}'"),
            format!("is {position}, outside its limits {lower}..{upper}"),
        ));
    }
    Ok(())
}

fn unit_axis(joint: &urdf_rs::Joint) -> Result<DVec3, String> {
    let axis = DVec3::from_array(*joint.axis.xyz);
    match axis.try_normalize() {
        Some(axis) => Ok(axis),
        None => Err(format!("its axis {:?} has no direction", *joint.axis.xyz)),
    }
}

fn input_error(urdf: &Urdf, index: usize, message: impl Into<String>) -> InputError {
    urdf.joint_facts[index]
        .location
        .error(format!("joint '{}'", urdf.robot.joints[index].name), message)
}
