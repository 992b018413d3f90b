//! Whole-body inverse kinematics over fixed soles.
//!
//! The rotation and the height of the root are given. Fixed-point iterations shift the root until
//! the centre of mass reaches its target; the legs follow by inverse kinematics.

use glam::{DQuat, DVec2};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;

use crate::robot::configuration::Configuration;
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::Mechanism;
use crate::robot::tuning::{POSTURE_ITERATIONS_MAX, POSTURE_LEG_EXTENSION_MAX, ROOT_SHIFT_RATIO};

/// Largest distance of the centre of mass from its target, m.
pub const COM_TOLERANCE: f64 = 5e-4;

/// A desired posture of the root over a pair of soles.
#[derive(Debug, Clone, Copy)]
pub struct Posture {
    /// Rotation of the root in the world.
    pub world_from_root: DQuat,
    /// Largest extension of either leg, 0 to 1.
    pub leg_extension: f64,
    /// Target of the centre of mass in world x and y, m.
    pub com: DVec2,
}

/// Why a posture cannot be solved.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PostureError {
    /// A leg does not reach its sole within its joint limits.
    #[error("a leg does not reach its sole")]
    Unreachable,
    /// The centre of mass does not converge to its target.
    #[error("the centre of mass does not reach its target")]
    Balance,
}

/// Solves for a configuration in the desired posture, starting from the joint positions `start_q`.
///
/// # Errors
/// A leg does not reach its sole, or the centre of mass does not converge.
pub fn solve_posture(
    robot: &Mechanism,
    world_from_soles: &[Pose; 2],
    posture: &Posture,
    start_q: [f64; JOINTS_MAX],
) -> Result<(Configuration, KinematicState), PostureError> {
    let mut kinematic_state = KinematicState::default();
    let configuration =
        solve_posture_into(robot, world_from_soles, posture, start_q, &mut kinematic_state)?;
    Ok((configuration, kinematic_state))
}

/// As [`solve_posture`]; overwrites `kinematic_state` with the state of the result.
///
/// # Errors
/// A leg does not reach its sole, or the centre of mass does not converge.
pub fn solve_posture_into(
    robot: &Mechanism,
    world_from_soles: &[Pose; 2],
    posture: &Posture,
    start_q: [f64; JOINTS_MAX],
    kinematic_state: &mut KinematicState,
) -> Result<Configuration, PostureError> {
    let mut configuration = root_over_com(robot, posture, start_q);
    for _ in 0..POSTURE_ITERATIONS_MAX {
        let height = root_height(robot, &configuration.world_from_root, world_from_soles, posture);
        configuration.world_from_root.translation.z = height.ok_or(PostureError::Unreachable)?;
        if !robot.place_soles_near(&mut configuration, world_from_soles) {
            return Err(PostureError::Unreachable);
        }
        kinematic_state.update(robot, &configuration);
        let error = posture.com - kinematic_state.com.truncate();
        if error.length() < COM_TOLERANCE {
            return Ok(configuration);
        }
        configuration.world_from_root.translation += (ROOT_SHIFT_RATIO * error).extend(0.0);
    }
    Err(PostureError::Balance)
}

/// The root at the pose of the desired posture, whether or not the legs reach their soles from
/// there; the joints stay at `start_q`. Initial guess of a constrained projection.
pub fn initial_guess(
    robot: &Mechanism,
    world_from_soles: &[Pose; 2],
    posture: &Posture,
    start_q: [f64; JOINTS_MAX],
) -> Configuration {
    let mut configuration = root_over_com(robot, posture, start_q);
    let mean_height = || {
        let heights = [0, 1].map(|limb| {
            world_from_soles[limb].translation.z
                - robot.legs[limb].root_from_sole(&start_q).translation.z
        });
        0.5 * (heights[0] + heights[1])
    };
    let height = root_height(robot, &configuration.world_from_root, world_from_soles, posture);
    configuration.world_from_root.translation.z = height.unwrap_or_else(mean_height);
    configuration
}

/// The root with the desired rotation, so that the centre of mass of the standing posture is over
/// its target; the height of the root is 0.
fn root_over_com(robot: &Mechanism, posture: &Posture, q: [f64; JOINTS_MAX]) -> Configuration {
    let position = posture.com - (posture.world_from_root * robot.standing_com).truncate();
    Configuration {
        world_from_root: Pose::from_parts(position.extend(0.0), posture.world_from_root),
        q,
    }
}

fn root_height(
    robot: &Mechanism,
    root: &Pose,
    world_from_soles: &[Pose; 2],
    posture: &Posture,
) -> Option<f64> {
    let leg_extension = posture.leg_extension.min(POSTURE_LEG_EXTENSION_MAX);
    robot.root_height(root, world_from_soles, [leg_extension; 2])
}
