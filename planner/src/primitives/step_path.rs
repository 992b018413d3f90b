//! The primitive trajectories as functions of a parameter [Grey 4.4.5]. Between two placements the
//! swing foot always passes the neutral position beside the stance foot, so that each half of a
//! swing depends on one pair of placements only:
//!
//! ```text
//! half swing  neutral over a, up by the rise to b, across (the root moves), down, onto b
//! swing       a half swing backwards from the old placement, then a half swing to the new one
//! shift       from the configuration over b to the one over a, both feet in contact
//! ```

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{interpolate, rotation_about, yaw_of};

use crate::constraints::foothold::Foothold;
use crate::constraints::mode_state::ModeState;
use crate::constraints::rejection::Rejection;
use crate::primitives::gait::Gait;
use crate::primitives::level_sole::{LevelSole, side_of};
use crate::primitives::transition_pair::TransitionPair;
use crate::robot::configuration::Configuration;
use crate::robot::mechanism::Mechanism;
use crate::robot::posture_ik::{Posture, solve_posture};

/// Number of sections of a half swing.
pub const SECTIONS: usize = 4;
/// The section in which the root moves and the foot moves across.
pub const ACROSS: usize = 1;
/// The section that ends on the placement.
pub const LANDING: usize = 3;

/// The half of a swing that ends on a placement.
#[derive(Debug, Clone)]
pub struct HalfSwing {
    /// The foot that swings.
    pub limb: usize,
    /// The robot on its stance foot alone, the swing foot beside it.
    pub neutral: ModeState,
    /// The robot with its swing foot on the placement, all weight on the stance foot.
    pub placed: ModeState,
    /// The swing sole's poses at the ends of the sections.
    knots: [Pose; SECTIONS + 1],
}

impl HalfSwing {
    /// The half swing over `stance` onto `other`.
    ///
    /// # Errors
    /// A leg does not reach, or the centre of mass cannot be placed over the stance foot.
    pub fn new(
        robot: &Mechanism,
        gait: &Gait,
        stance: &Foothold,
        other: &Foothold,
    ) -> Result<Self, Rejection> {
        let stance_level_sole = LevelSole::of(&robot.legs[stance.limb], &stance.world_from_sole);
        let neutral_sole = neutral_sole(gait, &stance_level_sole, other.limb);
        let neutral = solved_state(robot, gait, stance, &neutral_sole, stance_level_sole.yaw)?;
        Self::beside(neutral, robot, gait, stance, other)
    }

    /// The half swing over the same stance foot onto another placement.
    ///
    /// # Errors
    /// As [`HalfSwing::new`].
    pub fn onto(
        &self,
        robot: &Mechanism,
        gait: &Gait,
        stance: &Foothold,
        other: &Foothold,
    ) -> Result<Self, Rejection> {
        Self::beside(self.neutral, robot, gait, stance, other)
    }

    /// The half swing from a known neutral state.
    fn beside(
        neutral: ModeState,
        robot: &Mechanism,
        gait: &Gait,
        stance: &Foothold,
        other: &Foothold,
    ) -> Result<Self, Rejection> {
        let limb = other.limb;
        let leg = &robot.legs[limb];
        let stance_level_sole = LevelSole::of(&robot.legs[stance.limb], &stance.world_from_sole);
        let level_sole = LevelSole::of(leg, &other.world_from_sole);
        let rise = (level_sole.origin.z - stance_level_sole.origin.z).max(0.0);
        let neutral_sole = neutral_sole(gait, &stance_level_sole, limb);
        let lifted = shifted(
            &other.world_from_sole,
            other.world_from_sole.rotation * (DVec3::Z * gait.lift_height),
        );
        let top = stance_level_sole.origin.z + gait.lift_height + rise;
        let lifted_height = LevelSole::of(leg, &lifted).origin.z;
        let knots = [
            neutral_sole,
            shifted(&neutral_sole, DVec3::Z * rise),
            shifted(&lifted, DVec3::Z * (top - lifted_height).max(0.0)),
            lifted,
            other.world_from_sole,
        ];
        let placed = configuration(robot, gait, stance, other)?;
        Ok(Self { limb, neutral, placed, knots })
    }

    /// The distance that the swing sole moves in a section, m.
    pub fn length(&self, section: usize) -> f64 {
        self.knots[section].translation.distance(self.knots[section + 1].translation)
    }

    /// The state at the fraction `t` of a section, before the legs are solved for its soles. `seed`
    /// selects the branch of their inverse kinematics.
    pub fn at(&self, section: usize, t: f64, seed: &ModeState) -> ModeState {
        let mut state = *seed;
        let moved = match section {
            0 => 0.0,
            ACROSS => t,
            _ => 1.0,
        };
        let [from, to] =
            [&self.neutral, &self.placed].map(|end| &end.configuration.world_from_root);
        state.configuration.world_from_root = interpolate(from, to, moved);
        state.world_from_soles[self.limb] =
            interpolate(&self.knots[section], &self.knots[section + 1], t);
        state
    }
}

/// The neutral pose of the swing sole beside the stance foot.
fn neutral_sole(gait: &Gait, stance: &LevelSole, limb: usize) -> Pose {
    let beside = stance.world_from_level_sole()
        * DVec3::new(0.0, side_of(limb) * gait.width, gait.lift_height);
    Pose::from_parts(beside, rotation_about(DVec3::Z, stance.yaw))
}

/// The primitive configuration of a transition: all weight on `stance`, `other` in contact. It
/// depends on the two placements only.
///
/// # Errors
/// A leg does not reach, or the centre of mass cannot be placed over the stance foot.
pub fn configuration(
    robot: &Mechanism,
    gait: &Gait,
    stance: &Foothold,
    other: &Foothold,
) -> Result<ModeState, Rejection> {
    let yaw = TransitionPair { stance, other }.heading();
    solved_state(robot, gait, stance, &other.world_from_sole, yaw)
}

fn solved_state(
    robot: &Mechanism,
    gait: &Gait,
    stance: &Foothold,
    other_sole: &Pose,
    yaw: f64,
) -> Result<ModeState, Rejection> {
    let mut world_from_soles = [*other_sole; 2];
    world_from_soles[stance.limb] = stance.world_from_sole;
    let side = side_of(stance.limb);
    let world_from_root =
        rotation_about(DVec3::Z, yaw) * rotation_about(DVec3::X, -side * gait.roll);
    let inward = rotation_about(DVec3::Z, yaw_of(stance.world_from_sole.rotation))
        * (-side * gait.lean * DVec3::Y);
    let posture = Posture {
        world_from_root,
        leg_extension: gait.leg_extension,
        com: stance.region.centroid() + inward.truncate(),
    };
    let (configuration, _) = solve_posture(robot, &world_from_soles, &posture, robot.standing_q)?;
    Ok(ModeState { configuration, world_from_soles })
}

/// The state at the fraction `t` between a primitive configuration and its twin, before the legs
/// are solved for its soles.
pub fn shift_at(from: &Configuration, to: &Configuration, t: f64, seed: &ModeState) -> ModeState {
    let mut state = *seed;
    state.configuration.world_from_root =
        interpolate(&from.world_from_root, &to.world_from_root, t);
    state
}

/// A pose translated by a vector, m.
fn shifted(pose: &Pose, by: DVec3) -> Pose {
    Pose::from_parts(pose.translation + by, pose.rotation)
}
