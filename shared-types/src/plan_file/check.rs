//! Checks of a plan file that need neither the robot nor the world.

use std::collections::{BTreeMap, BTreeSet};

use crate::base::text_file::{check_numbers, check_positive};
use crate::message::chunk::ROOT_FREEDOMS;
use crate::plan_format::blocks::{
    EndBlock, PhaseBlock, PlanFile, PoseBlock, RobotBlock, SCHEMA, WaypointBlock,
};
use crate::robot::model::FOOT_NAMES;
use crate::world::shape_block::{pose_from_arrays, pose_from_block};

/// An element of the file and its error.
type ElementError = (String, String);

/// The first element of a plan that violates a rule of the format.
pub(crate) fn check_plan(plan: &PlanFile) -> Result<(), ElementError> {
    if plan.schema != SCHEMA {
        return Err((
            "schema".into(),
            format!("is '{}'; only '{SCHEMA}' is supported", plan.schema),
        ));
    }
    check_robot(&plan.robot).map_err(|message| ("robot".to_owned(), message))?;
    check_numbers("mu", &[plan.scene.mu]).map_err(|message| ("scene".to_owned(), message))?;
    check_names(&plan.joint_names).map_err(|message| ("joint_names".to_owned(), message))?;
    check_waypoints(plan)?;
    check_phases(plan)?;
    for (name, end) in [("start", &plan.start), ("goal", &plan.goal)] {
        check_end(end, plan.joint_names.len()).map_err(|message| (name.to_owned(), message))?;
    }
    Ok(())
}

fn check_robot(robot: &RobotBlock) -> Result<(), String> {
    check_foot_names(&robot.feet)?;
    for (name, foot) in &robot.feet {
        pose_from_block(&foot.sole_pose).map_err(|message| format!("foot '{name}': {message}"))?;
        check_numbers(&format!("foot '{name}': polygon"), foot.polygon.as_flattened())?;
    }
    for (name, position) in &robot.locked_joints {
        check_numbers(&format!("locked_joints '{name}'"), &[*position])?;
    }
    for (name, effort) in &robot.effort_limits {
        check_positive(&format!("effort_limits '{name}'"), &[*effort])?;
    }
    for (name, limit) in &robot.acceleration_limits {
        check_positive(&format!("acceleration_limits '{name}'"), &[*limit])?;
    }
    check_effort_scale(robot.effort_scale)
}

/// A plan may weaken the motors of its robot, but not strengthen them.
fn check_effort_scale(scale: Option<f64>) -> Result<(), String> {
    let Some(scale) = scale else { return Ok(()) };
    check_positive("effort_scale", &[scale])?;
    if scale > 1.0 {
        return Err(format!("effort_scale is {scale}; it must be at most 1"));
    }
    Ok(())
}

fn check_foot_names<T>(feet: &BTreeMap<String, T>) -> Result<(), String> {
    if feet.keys().map(String::as_str).eq(FOOT_NAMES) {
        return Ok(());
    }
    Err(format!("its feet are {:?}; they must be {FOOT_NAMES:?}", feet.keys().collect::<Vec<_>>()))
}

fn check_names(names: &[String]) -> Result<(), String> {
    let mut seen = BTreeSet::new();
    match names.iter().find(|name| !seen.insert(name.as_str())) {
        Some(name) => Err(format!("names '{name}' twice")),
        None => Ok(()),
    }
}

fn check_waypoints(plan: &PlanFile) -> Result<(), ElementError> {
    let mut before = f64::NEG_INFINITY;
    for (at, waypoint) in plan.waypoints.iter().enumerate() {
        check_waypoint(waypoint, before, plan.joint_names.len())
            .map_err(|message| (format!("waypoint {at}"), message))?;
        before = waypoint.t;
    }
    check_uniform(&plan.waypoints)
}

fn check_waypoint(waypoint: &WaypointBlock, before: f64, joints: usize) -> Result<(), String> {
    check_numbers("t", &[waypoint.t])?;
    if waypoint.t <= before {
        return Err(format!("t is {} after {before}; time must increase", waypoint.t));
    }
    check_configuration(waypoint.root_xyz, waypoint.root_quat_xyzw, &waypoint.q, joints)?;
    check_rates(waypoint, joints)
}

fn check_rates(waypoint: &WaypointBlock, joints: usize) -> Result<(), String> {
    let rates = [
        ("velocity", &waypoint.velocity, ROOT_FREEDOMS + joints),
        ("acceleration", &waypoint.acceleration, ROOT_FREEDOMS + joints),
        ("torque", &waypoint.torque, joints),
        ("rest_torque", &waypoint.rest_torque, joints),
        ("rate_change_torque", &waypoint.rate_change_torque, joints),
    ];
    for (name, numbers, count) in rates {
        if !numbers.is_empty() && numbers.len() != count {
            return Err(format!("{name} has {} numbers instead of {count}", numbers.len()));
        }
        check_numbers(name, numbers)?;
    }
    if waypoint.velocity.is_empty() == waypoint.acceleration.is_empty() {
        return Ok(());
    }
    Err("velocity and acceleration are needed together: a motion is straight or quintic".into())
}

/// Velocity, acceleration and the torques each stand in every waypoint or in none.
fn check_uniform(waypoints: &[WaypointBlock]) -> Result<(), ElementError> {
    let has = |waypoint: &WaypointBlock| {
        let WaypointBlock { velocity, torque, rest_torque, rate_change_torque, .. } = waypoint;
        [velocity, torque, rest_torque, rate_change_torque].map(|numbers| !numbers.is_empty())
    };
    let Some(first) = waypoints.first().map(has) else { return Ok(()) };
    match waypoints.iter().position(|waypoint| has(waypoint) != first) {
        None => Ok(()),
        Some(at) => Err((
            format!("waypoint {at}"),
            "velocity and torques stand in every waypoint or in none".into(),
        )),
    }
}

fn check_configuration(
    xyz: [f64; 3],
    quat_xyzw: [f64; 4],
    q: &[f64],
    joints: usize,
) -> Result<(), String> {
    pose_from_arrays(xyz, quat_xyzw)?;
    if q.len() != joints {
        return Err(format!("q has {} entries for {joints} joint_names", q.len()));
    }
    check_numbers("q", q)
}

fn check_phases(plan: &PlanFile) -> Result<(), ElementError> {
    let waypoints = plan.waypoints.len();
    let mut expected = 0;
    for (at, phase) in plan.phases.iter().enumerate() {
        check_phase(phase, expected, waypoints)
            .map_err(|message| (format!("phase {at}"), message))?;
        expected = phase.last;
    }
    match plan.phases.last() {
        None => Err(("phases".into(), "a plan needs at least one phase".into())),
        Some(phase) if phase.last + 1 != waypoints => Err((
            format!("phase {}", plan.phases.len() - 1),
            format!("ends at waypoint {} instead of the last, {}", phase.last, waypoints - 1),
        )),
        Some(_) => Ok(()),
    }
}

fn check_phase(phase: &PhaseBlock, expected_first: usize, waypoints: usize) -> Result<(), String> {
    if phase.first != expected_first {
        return Err(format!(
            "begins at waypoint {} instead of {expected_first}; phases share their transition waypoints",
            phase.first
        ));
    }
    if phase.last < phase.first || phase.last >= waypoints {
        return Err(format!("covers waypoints {}..{} of {waypoints}", phase.first, phase.last));
    }
    let expected: &[&str] = match phase.mode.as_str() {
        "left" => &FOOT_NAMES[..1],
        "right" => &FOOT_NAMES[1..],
        "double" => &FOOT_NAMES,
        other => return Err(format!("has the unknown mode '{other}'; use left, right or double")),
    };
    let mut feet: Vec<&str> = phase.contacts.iter().map(|contact| contact.foot.as_str()).collect();
    feet.sort_unstable();
    if feet != expected {
        return Err(format!(
            "has contacts {feet:?} in mode '{}', which needs {expected:?}",
            phase.mode
        ));
    }
    for contact in &phase.contacts {
        pose_from_block(&contact.sole_pose)
            .map_err(|message| format!("contact '{}': {message}", contact.foot))?;
    }
    Ok(())
}

fn check_end(end: &EndBlock, joints: usize) -> Result<(), String> {
    match end {
        EndBlock::Config { root_xyz, root_quat_xyzw, q, tol } => {
            check_configuration(*root_xyz, *root_quat_xyzw, q, joints)?;
            check_positive("tol", &[*tol])
        }
        EndBlock::RootRegion { xy, radius, z_range, yaw, yaw_tol } => {
            check_numbers("xy", xy)?;
            check_positive("radius", &[*radius])?;
            check_numbers("z_range", z_range.as_ref().map_or(&[], |range| range.as_slice()))?;
            check_numbers("yaw", &[yaw.unwrap_or(0.0), yaw_tol.unwrap_or(0.0)])
        }
        EndBlock::Feet { soles, tol } => check_soles(soles, *tol),
    }
}

fn check_soles(soles: &BTreeMap<String, PoseBlock>, tol: f64) -> Result<(), String> {
    check_foot_names(soles)?;
    for (name, pose) in soles {
        pose_from_block(pose).map_err(|message| format!("sole '{name}': {message}"))?;
    }
    check_positive("tol", &[tol])
}
