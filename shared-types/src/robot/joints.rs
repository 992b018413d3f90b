//! Validates joints: kinds, axes, limits, and which of them are locked.

use std::f64::consts::PI;

use glam::DVec3;

use crate::base::closest::closest;
use crate::base::input_error::InputError;
use crate::base::spatial::Pose;
use crate::base::text_file::{FileLocation, NUMBER_MAX};

use crate::robot::model::{Joint, JointKind, LockedJoint};
use crate::robot::spec::{JointValues, RobotSpec};
use crate::robot::urdf::Urdf;
use crate::robot::urdf_joint::{JointType, Limit, UrdfJoint};

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

/// Decides what a URDF joint becomes under a robot file.
pub(crate) fn joint_role(
    urdf: &Urdf,
    index: usize,
    spec: &RobotSpec,
) -> Result<JointRole, InputError> {
    let joint = &urdf.joints[index];
    let kind = match joint.joint_type {
        JointType::Fixed => return Ok(JointRole::Fixed(joint.parent_from_joint)),
        JointType::Revolute | JointType::Continuous => JointKind::Revolute,
        JointType::Prismatic => JointKind::Prismatic,
        JointType::Floating | JointType::Planar => {
            return Err(input_error(
                joint,
                "moves in more than one direction; only revolute, continuous, prismatic and fixed joints are supported, and one floating joint from a bare root link",
            ));
        }
    };
    let axis = joint.axis;
    let position = match spec.locked.get(&joint.name) {
        Some((position, location)) => {
            check_locked_position(joint, *position, location)?;
            Some(*position)
        }
        None => followed_position(urdf, index, spec)?,
    };
    match position {
        None => moving_joint(joint, kind, axis, spec),
        Some(position) => {
            let locked = locked_joint(joint, (kind, axis), position, spec)?;
            Ok(JointRole::Locked(locked.parent_from_joint * kind.motion(axis, position), locked))
        }
    }
}

/// Where a joint is held that mimics one that is held, or that never moves; `None` for one that
/// mimics no joint of the file.
fn followed_position(
    urdf: &Urdf,
    index: usize,
    spec: &RobotSpec,
) -> Result<Option<f64>, InputError> {
    let joint = &urdf.joints[index];
    let Some(mimic) = &joint.mimic else { return Ok(None) };
    let Some(leader) = held_position(urdf, &mimic.joint, spec) else {
        if !urdf.joints.iter().any(|joint| joint.name == mimic.joint) || mimic.joint == joint.name {
            return Ok(None);
        }
        let message = format!(
            "mimics '{}', which moves; lock that one in the robot file, and this one is held with it",
            mimic.joint
        );
        return Err(input_error(joint, message));
    };
    let position = mimic.multiplier * leader + mimic.offset;
    match locked_limits(joint) {
        (lower, upper) if (lower..=upper).contains(&position) => Ok(Some(position)),
        (lower, upper) => {
            let message = format!(
                "mimics '{}' to {position}, outside its limits {lower}..{upper}; lock it, too",
                mimic.joint
            );
            Err(input_error(joint, message))
        }
    }
}

/// Where a joint is held: locked, fixed, or by the joint that it mimics.
fn held_position(urdf: &Urdf, name: &str, spec: &RobotSpec) -> Option<f64> {
    let (mut name, mut factor, mut offset) = (name, 1.0, 0.0);
    // More steps than joints would go round in a circle.
    for _ in 0..urdf.joints.len() {
        if let Some((position, _)) = spec.locked.get(name) {
            return Some(factor * position + offset);
        }
        let joint = urdf.joints.iter().find(|joint| joint.name == name)?;
        if joint.joint_type == JointType::Fixed {
            return Some(offset);
        }
        let mimic = joint.mimic.as_ref()?;
        (name, offset) = (&mimic.joint, offset + factor * mimic.offset);
        factor *= mimic.multiplier;
    }
    None
}

/// Refuses names in a table that are not moving joints of the URDF.
pub(crate) fn check_names(
    urdf: &Urdf,
    table: &str,
    values: &JointValues,
    complaints: &mut Vec<InputError>,
) {
    for (name, (_, location)) in values {
        let message = match urdf.joints.iter().find(|joint| joint.name == *name) {
            None => no_such_joint(urdf, name),
            Some(joint) if joint.joint_type == JointType::Fixed => {
                "this joint is fixed; remove the entry".to_owned()
            }
            Some(_) => continue,
        };
        complaints.push(location.error(format!("{table} '{name}'"), message));
    }
}

/// A complaint about a name that no joint has.
pub(crate) fn no_such_joint(urdf: &Urdf, name: &str) -> String {
    let known = urdf.joints.iter().map(|joint| joint.name.as_str());
    let meant = closest(name, known).map(|meant| format!("; did you mean '{meant}'?"));
    format!("the URDF has no joint of this name{}", meant.unwrap_or_default())
}

fn moving_joint(
    joint: &UrdfJoint,
    kind: JointKind,
    axis: DVec3,
    spec: &RobotSpec,
) -> Result<JointRole, InputError> {
    let limit = match &joint.limit {
        Some(limit) => limit,
        None => &limit_of_robot_file(joint, spec)?,
    };
    let (lower, upper) = position_limits(joint, limit, spec)?;
    let mut errors = Vec::new();
    let mut refuse = |message: String| {
        errors.push(limit.location.error(format!("joint '{}'", joint.name), message))
    };
    if let Err(message) = check_range(joint, limit, [lower, upper]) {
        refuse(message);
    }
    let mut positive = |name: &str, stated: Option<f64>, instead: &str| {
        positive_limit(name, stated, instead).unwrap_or_else(|message| {
            refuse(message);
            0.0
        })
    };
    let stated_here = spec.effort_limits.get(&joint.name).map(|(effort, _)| *effort);
    let stated_effort = limit.effort.filter(|effort| *effort != 0.0).or(stated_here);
    let effort = positive("effort", stated_effort.or(limit.effort), " or under [effort_limits]");
    let stated_here = spec.additions.velocity_limits.get(&joint.name).copied();
    let stated_velocity = limit.velocity.filter(|velocity| *velocity != 0.0);
    let stated_velocity = stated_velocity.into_iter().chain(stated_here).reduce(f64::min);
    let velocity =
        positive("velocity", stated_velocity.or(limit.velocity), " or under [velocity_limits]");
    InputError::all(errors)?;
    let effort = tightened_effort(joint, effort, spec)?;
    let stated_acceleration = stated_acceleration(joint, spec)?;
    Ok(JointRole::Moving(Joint {
        name: joint.name.clone(),
        kind,
        axis,
        child: 0,
        lower,
        upper,
        effort,
        velocity,
        stated_acceleration,
    }))
}

/// Checks that a moving joint has a range of motion.
fn check_range(joint: &UrdfJoint, limit: &Limit, [lower, upper]: [f64; 2]) -> Result<(), String> {
    if !states_range(joint, limit) && lower == upper {
        return Err("its <limit> states neither lower nor upper; state them, or a range under [position_limits], or lock the joint in the robot file".into());
    }
    if lower < upper && lower.is_finite() && upper.is_finite() {
        return Ok(());
    }
    Err(format!(
        "its limits {lower}..{upper} leave no range of motion; correct them or lock it in the robot file"
    ))
}

/// A limit of this name, at most [`NUMBER_MAX`]. `instead` is where else it may be stated.
fn positive_limit(name: &str, stated: Option<f64>, instead: &str) -> Result<f64, String> {
    match stated {
        Some(number) if number > 0.0 => Ok(number.min(NUMBER_MAX)),
        Some(number) => Err(format!(
            "{name} must be positive, but is {number}; state it in <limit>{instead}, or lock the joint in the robot file"
        )),
        None => Err(format!("its <limit> has no {name}; state it{instead}, or lock the joint")),
    }
}

/// The limit of a joint without a `<limit>`, which URDF allows for continuous ones: the robot file
/// states what it would.
fn limit_of_robot_file(joint: &UrdfJoint, spec: &RobotSpec) -> Result<Limit, InputError> {
    let message = if joint.joint_type != JointType::Continuous {
        "has no <limit>; state lower, upper, effort and velocity, or lock it in the robot file"
    } else if spec.effort_limits.contains_key(&joint.name)
        && spec.additions.velocity_limits.contains_key(&joint.name)
    {
        let location = joint.location.clone();
        let [effort, velocity, acceleration] = [None; 3];
        return Ok(Limit { location, range: None, effort, velocity, acceleration });
    } else {
        "has no <limit>; state effort and velocity there, or under [effort_limits] and [velocity_limits], or lock it in the robot file"
    };
    Err(input_error(joint, message))
}

/// A locked joint needs no limits of its own: limits that are not stated are infinite.
fn locked_joint(
    joint: &UrdfJoint,
    (kind, axis): (JointKind, DVec3),
    position: f64,
    spec: &RobotSpec,
) -> Result<LockedJoint, InputError> {
    let stated = |limit: fn(&Limit) -> Option<f64>| {
        let limit = joint.limit.as_ref().and_then(limit);
        limit.filter(|limit| *limit > 0.0).unwrap_or(f64::INFINITY)
    };
    let effort = tightened_effort(joint, stated(|limit| limit.effort), spec)?;
    let (lower, upper) = locked_limits(joint);
    let velocity = stated(|limit| limit.velocity);
    let stated_acceleration = stated_acceleration(joint, spec)?;
    let joint_model = Joint {
        name: joint.name.clone(),
        kind,
        axis,
        child: 0,
        lower,
        upper,
        effort,
        velocity,
        stated_acceleration,
    };
    Ok(LockedJoint { joint: joint_model, position, parent_from_joint: joint.parent_from_joint })
}

/// Where a joint may be locked.
fn locked_limits(joint: &UrdfJoint) -> (f64, f64) {
    let range = joint.limit.as_ref().and_then(|limit| limit.range);
    range.unwrap_or((f64::NEG_INFINITY, f64::INFINITY))
}

/// Whether a joint's kind or its limits say where it may move.
fn states_range(joint: &UrdfJoint, limit: &Limit) -> bool {
    joint.joint_type == JointType::Continuous || limit.range.is_some()
}

/// Where a joint may move: as the URDF says, or within that as the robot file does.
fn position_limits(
    joint: &UrdfJoint,
    limit: &Limit,
    spec: &RobotSpec,
) -> Result<(f64, f64), InputError> {
    let stated = stated_limits(joint, limit);
    let Some([lower, upper]) = spec.additions.position_limits.get(&joint.name).copied() else {
        return Ok(stated);
    };
    let is_free = !states_range(joint, limit);
    let (least, most) = if is_free { (-NUMBER_MAX, NUMBER_MAX) } else { stated };
    if lower < upper && least <= lower && upper <= most {
        return Ok((lower, upper));
    }
    let within =
        if is_free { String::new() } else { format!(" within the URDF's {least}..{most}") };
    let message = format!("{lower}..{upper} is no range{within}; write [lower, upper]");
    let element = format!("[position_limits] '{}'", joint.name);
    Err(spec.additions_location.error(element, message))
}

/// Where the URDF lets a joint move. One turn for a joint that turns on and on, whichever way the
/// file says so.
fn stated_limits(joint: &UrdfJoint, limit: &Limit) -> (f64, f64) {
    let range = limit.range.unwrap_or((0.0, 0.0));
    match joint.joint_type {
        JointType::Continuous => (-PI, PI),
        JointType::Revolute if range == (f64::NEG_INFINITY, f64::INFINITY) => (-PI, PI),
        _ => range,
    }
}

fn tightened_effort(joint: &UrdfJoint, stated: f64, spec: &RobotSpec) -> Result<f64, InputError> {
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

/// The acceleration of the robot file, at most that of the URDF, where one of them says one.
fn stated_acceleration(joint: &UrdfJoint, spec: &RobotSpec) -> Result<Option<f64>, InputError> {
    let stated = joint.limit.as_ref().and_then(|limit| limit.acceleration);
    let stated = stated.filter(|stated| stated.is_finite());
    match spec.accelerations.get(&joint.name) {
        None => Ok(stated),
        Some((limit, _)) if *limit > 0.0 && stated.is_none_or(|stated| *limit <= stated) => {
            Ok(Some(*limit))
        }
        Some((limit, location)) => {
            let most = stated.map(|stated| format!(" and at most the URDF's {stated}"));
            Err(location.error(
                format!("[accelerations] '{}'", joint.name),
                format!("is {limit}; it must be positive{}", most.unwrap_or_default()),
            ))
        }
    }
}

fn check_locked_position(
    joint: &UrdfJoint,
    position: f64,
    location: &FileLocation,
) -> Result<(), InputError> {
    let (name, (lower, upper)) = (&joint.name, locked_limits(joint));
    if !(lower..=upper).contains(&position) {
        return Err(location.error(
            format!("[locked] '{name}'"),
            format!("is {position}, outside its limits {lower}..{upper}; choose one between them"),
        ));
    }
    Ok(())
}

fn input_error(joint: &UrdfJoint, message: impl Into<String>) -> InputError {
    joint.location.error(format!("joint '{}'", joint.name), message)
}
