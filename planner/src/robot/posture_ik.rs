//! The robot put over its soles: its root's rotation and height are desired, its place follows
//! from putting the centre of mass where it shall be (a few fixed-point shifts), the legs follow by
//! inverse kinematics.

use glam::{DQuat, DVec2};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;

use crate::constraints::constraints::Rejection;
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::{Configuration, Mechanism};

/// Fixed-point shifts of the root that bring the centre of mass over its target.
const COM_SHIFTS_MAX: usize = 8;
/// How much further the root is shifted than the centre of mass shall go, since the legs come along
/// only half the way.
pub(crate) const LEGS_LAG: f64 = 1.15;
/// How near the centre of mass must come to its target, m.
pub const COM_TOLERANCE: f64 = 5e-4;
/// The share of a leg's reach that samples may use: beyond it the knee is all but straight.
const LEG_EXTENSION_MAX: f64 = 0.995;

/// A desired posture of the root over a pair of soles.
#[derive(Debug, Clone, Copy)]
pub struct Posture {
    /// The root's rotation in the world.
    pub world_from_root: DQuat,
    /// The largest share of its reach that either leg may use.
    pub leg_extension: f64,
    /// Where the centre of mass shall be, world x and y, m.
    pub com: DVec2,
}

/// Puts the robot over its soles in the desired posture: the root shifts until the centre of
/// mass is where it shall be.
///
/// # Errors
/// The legs do not reach, or the shifts do not converge.
pub fn solve_posture(
    robot: &Mechanism,
    world_from_soles: &[Pose; 2],
    posture: &Posture,
    start_q: [f64; JOINTS_MAX],
) -> Result<(Configuration, KinematicState), Rejection> {
    let mut kinematic_state = KinematicState::default();
    let configuration =
        solve_posture_into(robot, world_from_soles, posture, start_q, &mut kinematic_state)?;
    Ok((configuration, kinematic_state))
}

/// The same, the kinematic state written over another one.
///
/// # Errors
/// As above.
pub fn solve_posture_into(
    robot: &Mechanism,
    world_from_soles: &[Pose; 2],
    posture: &Posture,
    start_q: [f64; JOINTS_MAX],
    kinematic_state: &mut KinematicState,
) -> Result<Configuration, Rejection> {
    let mut configuration = root_over(robot, posture, start_q);
    for _ in 0..COM_SHIFTS_MAX {
        let height = height_over(robot, &configuration.world_from_root, world_from_soles, posture);
        configuration.world_from_root.translation.z = height.ok_or(Rejection::Unreachable)?;
        if !robot.place_soles_near(&mut configuration, world_from_soles) {
            return Err(Rejection::Unreachable);
        }
        robot.update_kinematic_state(&configuration, kinematic_state);
        let error = posture.com - kinematic_state.com.truncate();
        if error.length() < COM_TOLERANCE {
            return Ok(configuration);
        }
        configuration.world_from_root.translation += (LEGS_LAG * error).extend(0.0);
    }
    Err(Rejection::Balance)
}

/// The root put where the desired posture has it, whether or not the legs reach from there; the
/// legs are left as they are.
pub fn initial_guess(
    robot: &Mechanism,
    world_from_soles: &[Pose; 2],
    posture: &Posture,
    start_q: [f64; JOINTS_MAX],
) -> Configuration {
    let mut configuration = root_over(robot, posture, start_q);
    let standing = || {
        let heights = [0, 1].map(|limb| {
            world_from_soles[limb].translation.z
                - robot.legs[limb].root_from_sole(&start_q).translation.z
        });
        0.5 * (heights[0] + heights[1])
    };
    let height = height_over(robot, &configuration.world_from_root, world_from_soles, posture);
    configuration.world_from_root.translation.z = height.unwrap_or_else(standing);
    configuration
}

/// The root turned as desired, over the place where the centre of mass shall be; its height is
/// 0.
fn root_over(robot: &Mechanism, posture: &Posture, q: [f64; JOINTS_MAX]) -> Configuration {
    let position = posture.com - (posture.world_from_root * robot.standing_com).truncate();
    Configuration {
        world_from_root: Pose::from_parts(position.extend(0.0), posture.world_from_root),
        q,
    }
}

fn height_over(
    robot: &Mechanism,
    root: &Pose,
    world_from_soles: &[Pose; 2],
    posture: &Posture,
) -> Option<f64> {
    robot.root_height(root, world_from_soles, [posture.leg_extension.min(LEG_EXTENSION_MAX); 2])
}
