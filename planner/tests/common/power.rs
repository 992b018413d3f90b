//! The power of a motion.

use glam::DVec3;
use surefoot_planner::robot::inverse_dynamics::{GeneralizedForce, VELOCITY_MAX};

/// The power of efforts at these velocities of the root and the joints, W.
pub fn power(effort: &GeneralizedForce, v: &[f64; VELOCITY_MAX]) -> f64 {
    let joints: f64 =
        effort.torques.iter().zip(&v[6..]).map(|(torque, speed)| torque * speed).sum();
    effort.force.dot(DVec3::from_slice(v)) + effort.moment.dot(DVec3::from_slice(&v[3..])) + joints
}
