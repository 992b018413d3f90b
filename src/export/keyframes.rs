//! Keyframes for MuJoCo: an MJCF file with the robot's state at each sample, to be included in the
//! robot's own model.

use std::fmt::Write;

use glam::{DQuat, DVec3};
use surefoot_shared_types::message::Waypoint;

use crate::export::error::ExportError;
use crate::export::motion::ExportMotion;
use crate::export::quaternion::QuaternionOrder;
use crate::export::sampling::samples;

/// The keyframes of a plan. `qpos` is the position of a free joint, its quaternion w, x, y, z, then
/// the joints. `qvel` is the free joint's velocity along the world's axes, its angular velocity
/// along the root's own axes, as MuJoCo defines it, then the joints.
///
/// # Errors
/// A moving joint is missing in `joints`, or there are too many samples.
pub fn write(motion: &ExportMotion, hz: f64, joints: &[usize]) -> Result<Vec<u8>, ExportError> {
    let model = &motion.model;
    if let Some(at) = (0..model.joints.len()).find(|at| !joints.contains(at)) {
        return Err(ExportError::Option(format!(
            "a keyframe holds all joints, and --joint-order lacks '{}'",
            model.joints[at].name
        )));
    }
    let names: Vec<&str> = joints.iter().map(|&at| model.joints[at].name.as_str()).collect();
    let mut text = format!(
        "<mujoco>\n  <!-- {}: a free joint, then {} -->\n  <keyframe>\n",
        comment(&model.name),
        comment(&names.join(" "))
    );
    for (index, sample) in samples(motion, hz)?.enumerate() {
        let (qpos, qvel) = state(&sample.waypoint, joints);
        let (time, qpos, qvel) = (sample.time, numbers(&qpos), numbers(&qvel));
        writeln!(
            text,
            "    <key name=\"walk_{index}\" time=\"{time}\" qpos=\"{qpos}\" qvel=\"{qvel}\"/>"
        )
        .map_err(|error| ExportError::writer("mujoco", error))?;
    }
    text.push_str("  </keyframe>\n</mujoco>\n");
    Ok(text.into_bytes())
}

/// Text without the two hyphens that would end a comment.
fn comment(text: &str) -> String {
    text.replace("--", "- -")
}

fn state(waypoint: &Waypoint, joints: &[usize]) -> (Vec<f64>, Vec<f64>) {
    let rotation = QuaternionOrder::Wxyz.arrange(waypoint.root_rotation);
    let [vx, vy, vz, wx, wy, wz] = waypoint.root_velocity;
    let root_from_world = DQuat::from_array(waypoint.root_rotation).conjugate();
    let angular = (root_from_world * DVec3::new(wx, wy, wz)).to_array();
    let of_joints =
        |numbers: &[f64]| joints.iter().map(|&joint| numbers[joint]).collect::<Vec<_>>();
    let qpos = [&waypoint.root_position[..], &rotation, &of_joints(&waypoint.q)].concat();
    let qvel = [&[vx, vy, vz][..], &angular, &of_joints(&waypoint.joint_velocity)].concat();
    (qpos, qvel)
}

fn numbers(numbers: &[f64]) -> String {
    numbers.iter().map(f64::to_string).collect::<Vec<_>>().join(" ")
}
