//! The limits of a motion: joint speeds, accelerations and efforts, friction, and how far the
//! centre of pressure stays inside a sole.

use glam::{DMat3, DVec3};
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::config::{CheckerConfig, ExecutionConfig};
use surefoot_shared_types::robot::model::{Joint, RobotModel};

use crate::timing::friction_pyramid::FrictionPyramid;
use crate::timing::tuning::{
    CHECKED_EFFORT_PART, COP_MARGIN_INCLINED, COP_MARGIN_MIN, COP_WIDTH_SHARE, INCLINED_COSINE,
    INTERVAL_MAX, RELAXED_COP_MARGINS, STEP_SHARE,
};

/// Limits of a robot's joints in a timed plan. Unused joints have infinite limits.
#[derive(Debug, Clone)]
pub struct TimingLimits {
    /// Lowest and highest positions, rad or m.
    pub positions: [[f64; 2]; JOINTS_MAX],
    /// Largest speeds, rad/s or m/s: also those at which a joint moves as far from one waypoint to
    /// the next as the controller allows.
    pub speeds: [f64; JOINTS_MAX],
    /// Largest accelerations, rad/s2 or m/s2; infinite where neither the robot file nor the URDF
    /// states one.
    pub accelerations: [f64; JOINTS_MAX],
    /// Largest torques (N m) or forces (N).
    pub efforts: [f64; JOINTS_MAX],
    /// Largest torques (N m) or forces (N) where a configuration needs more than `efforts` at rest.
    pub full_efforts: [f64; JOINTS_MAX],
    /// Coefficient of friction.
    pub friction: f64,
    /// Least distance (m) of the zero-moment point to the edge of the support, as the controller
    /// demands it.
    pub zero_moment_margin: f64,
    /// Shortest time of a braking ramp, and of one by which the robot goes on, s.
    pub ramp_seconds_min: f64,
}

impl TimingLimits {
    /// Whether the positions of all joints are within their limits.
    pub fn admit(&self, q: &[f64; JOINTS_MAX]) -> bool {
        let within = |(q, [lower, upper]): (&f64, &[f64; 2])| {
            (lower - POSITION_ROUNDING..=upper + POSITION_ROUNDING).contains(q)
        };
        q.iter().zip(&self.positions).all(within)
    }

    /// Torques no larger than the full efforts, N m or N.
    pub(crate) fn within_full_efforts(&self, mut torques: [f64; JOINTS_MAX]) -> [f64; JOINTS_MAX] {
        for (torque, limit) in torques.iter_mut().zip(&self.full_efforts) {
            *torque = torque.clamp(-limit, *limit);
        }
        torques
    }

    /// The limits of a robot, as far as they may be used, on a world's friction, and those of a
    /// controller.
    pub fn new(
        model: &RobotModel,
        execution: &ExecutionConfig,
        friction: f64,
        checker: &CheckerConfig,
    ) -> Self {
        let share = execution.share;
        let step_speed = STEP_SHARE * checker.joint_step_max / INTERVAL_MAX;
        let limits = |limit: fn(&Joint) -> f64, share: f64| {
            let mut limits = [f64::INFINITY; JOINTS_MAX];
            let stated = model.joints.iter().map(|joint| share * limit(joint));
            limits.iter_mut().zip(stated).for_each(|(slot, limit)| *slot = limit);
            limits
        };
        let acceleration = |joint: &Joint| joint.stated_acceleration.unwrap_or(f64::INFINITY);
        let mut positions = [[f64::NEG_INFINITY, f64::INFINITY]; JOINTS_MAX];
        let stated = model.joints.iter().map(|joint| [joint.lower, joint.upper]);
        positions.iter_mut().zip(stated).for_each(|(slot, limits)| *slot = limits);
        Self {
            positions,
            speeds: limits(|joint| joint.velocity, share).map(|speed| speed.min(step_speed)),
            accelerations: limits(acceleration, share),
            efforts: limits(|joint| joint.effort, share),
            full_efforts: limits(|joint| joint.effort, CHECKED_EFFORT_PART * checker.effort_share),
            friction,
            zero_moment_margin: checker.com_margin,
            ramp_seconds_min: execution.ramp_seconds_min,
        }
    }
}

/// Rounding of a position at its limit, rad or m.
const POSITION_ROUNDING: f64 = 5e-7;

/// How much of the limits of contacts and efforts a point of the path leaves. A configuration that
/// cannot stand within the first level is timed within the first one in which it can.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Level {
    /// On inclined soles: the centre of pressure 1.2 cm further inside than at the next level.
    Inclined,
    /// The centre of pressure 1.5 cm and 12 % of the sole's width inside.
    Full,
    /// On inclined soles: the same, with all of the friction that the controller counts on. This
    /// and the next levels count on it.
    Steep,
    /// The centre of pressure 1 cm inside.
    NarrowSole,
    /// The centre of pressure 4 mm inside, and the whole effort of every joint.
    Bare,
    /// No contact forces within the limits are known: the robot passes slowly.
    Unsupported,
}

impl Level {
    /// The levels at which contact forces are known, the strictest first.
    pub const ALL: [Self; 5] =
        [Self::Inclined, Self::Full, Self::Steep, Self::NarrowSole, Self::Bare];
    /// Those of level soles.
    const OF_LEVEL_SOLES: [Self; 3] = [Self::Full, Self::NarrowSole, Self::Bare];

    /// The levels at which contact forces are known, the strictest first, for soles of which one is
    /// inclined or all are level.
    pub fn levels(is_inclined: bool) -> &'static [Self] {
        if is_inclined { &Self::ALL } else { &Self::OF_LEVEL_SOLES }
    }

    /// Least distance (m) of the centre of pressure from the edge of a sole of this width (m).
    pub fn cop_margin(self, width: f64) -> f64 {
        match self {
            Self::Inclined => Self::Full.cop_margin(width) + COP_MARGIN_INCLINED,
            Self::Full | Self::Steep => COP_MARGIN_MIN.max(COP_WIDTH_SHARE * width),
            Self::NarrowSole => RELAXED_COP_MARGINS[0],
            Self::Bare | Self::Unsupported => RELAXED_COP_MARGINS[1],
        }
    }

    /// Friction of this coefficient on a sole with these axes.
    pub fn friction(self, axes: &DMat3, coefficient: f64) -> FrictionPyramid {
        if self > Self::Full && axes.z_axis.z < INCLINED_COSINE {
            let up = axes.transpose() * DVec3::Z;
            FrictionPyramid::with_eight_sides(coefficient, up.truncate())
        } else {
            FrictionPyramid::with_four_sides(coefficient)
        }
    }

    /// Largest efforts.
    pub fn efforts(self, limits: &TimingLimits) -> &[f64; JOINTS_MAX] {
        match self {
            Self::Inclined | Self::Full | Self::Steep | Self::NarrowSole => &limits.efforts,
            Self::Bare | Self::Unsupported => &limits.full_efforts,
        }
    }
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use surefoot_shared_types::robot::load::load_robot;

    use super::*;

    #[test]
    #[allow(clippy::unwrap_used, reason = "the shipped robot loads")]
    fn a_fast_joint_moves_between_two_waypoints_as_far_as_the_controller_allows() {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("../configs/robots/hubo/robot.toml");
        let mut model = load_robot(&file).unwrap();
        let (execution, checker) = (ExecutionConfig::default(), CheckerConfig::default());
        let speeds =
            |model: &RobotModel| TimingLimits::new(model, &execution, 0.6, &checker).speeds;
        let slow = speeds(&model);
        assert!(slow.iter().zip(&model.joints).all(|(speed, joint)| *speed <= joint.velocity));
        model.joints[3].velocity = 23.0;
        let fast = speeds(&model);
        assert!(fast[3] > 9.0 && fast[3] * INTERVAL_MAX < checker.joint_step_max, "{}", fast[3]);
        assert_eq!(fast[4], slow[4]);
    }
}
