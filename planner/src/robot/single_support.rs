//! Default postures in single support.
//!
//! If the standing posture needs too much effort on one foot, or leaves too little margin to joint
//! limits, the trunk leans over the stance hip: by the rotation of the root and by the joints
//! between root and trunk. The postures depend on the robot alone. All primitive configurations of
//! transitions begin with them [Grey 4.4.5].

use glam::DVec2;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::base::spatial::rotation_from_rpy;
use surefoot_shared_types::robot::model::JointIndex;

use crate::kinematics::leg_joint::LegJoint;
use crate::robot::gravity_torques::{FootLoad, most_strained};
use crate::robot::mechanism::Mechanism;
use crate::robot::posture_ik::{Posture, solve_posture};
use crate::robot::tuning::{
    DESCENT_CHANGES_MAX, DESCENT_STEPS, DEVIATION_COST, DEVIATION_MAX, EFFORT_USE_LOW,
    LIMIT_MARGIN_DESIRED, MARGIN_DEFICIT_COST,
};

/// A posture over one foot, near the standing one.
#[derive(Debug, Clone, Copy)]
pub struct SingleSupportPosture {
    /// Roll and pitch of the root, rad.
    pub rotation: [f64; 2],
    /// Joint positions; those of the legs are the standing posture's.
    pub q: [f64; JOINTS_MAX],
    /// Largest share of its usable effort that a joint needs, on level ground with the feet side by
    /// side; infinite if the posture cannot be reached.
    pub effort_use: f64,
    /// The joint with that share.
    pub most_strained: Option<JointIndex>,
    /// Largest missing part of the desired margin among the stance leg's joints, 0 to about 1.
    pub margin_deficit: f64,
}

impl SingleSupportPosture {
    /// The standing posture, not evaluated yet.
    pub fn standing(standing_q: [f64; JOINTS_MAX]) -> Self {
        Self {
            rotation: [0.0; 2],
            q: standing_q,
            effort_use: f64::INFINITY,
            most_strained: None,
            margin_deficit: 0.0,
        }
    }

    /// The posture over foot `limb`: the standing one if it is easy and leaves margin, otherwise
    /// the best one that coordinate descent finds from there.
    pub fn derive(robot: &Mechanism, limb: usize) -> Self {
        let ground = LevelGround::new(robot, limb);
        let mut angles = vec![0.0; 2 + robot.trunk_joints.len()];
        let mut best = ground.evaluate(&angles);
        ground.descend(&mut best, &mut angles, Criterion::Effort);
        ground.descend(&mut best, &mut angles, Criterion::LimitMargin);
        best
    }
}

/// The goal of a descent.
#[derive(Debug, Clone, Copy)]
enum Criterion {
    /// Low effort, by all angles.
    Effort,
    /// Margin of the stance leg's joints, by the trunk joints alone: a roll of the root takes from
    /// the hip the margin that the ankle gains.
    LimitMargin,
}

impl Criterion {
    fn is_met(self, candidate: &SingleSupportPosture) -> bool {
        match self {
            Self::Effort => candidate.effort_use <= EFFORT_USE_LOW,
            Self::LimitMargin => candidate.margin_deficit <= 0.0,
        }
    }

    fn angles(self, count: usize) -> std::ops::Range<usize> {
        match self {
            Self::Effort => 0..count,
            Self::LimitMargin => 2..count,
        }
    }

    fn cost(self, candidate: &SingleSupportPosture, angles: &[f64]) -> f64 {
        let strain = match self {
            Self::Effort => candidate.effort_use,
            Self::LimitMargin => {
                candidate.effort_use.max(EFFORT_USE_LOW)
                    + MARGIN_DEFICIT_COST * candidate.margin_deficit
            }
        };
        strain + DEVIATION_COST * angles.iter().map(|angle| angle.abs()).sum::<f64>()
    }
}

/// Level ground under both feet of the standing posture.
struct LevelGround<'a> {
    robot: &'a Mechanism,
    limb: usize,
    root_from_soles: [Pose; 2],
    /// Target of the centre of mass: centroid of the ankle support region.
    com: DVec2,
}

impl<'a> LevelGround<'a> {
    fn new(robot: &'a Mechanism, limb: usize) -> Self {
        let root_from_soles = [0, 1].map(|limb| robot.legs[limb].root_from_sole(&robot.standing_q));
        let com = robot.soles[limb].ankle_support_region(&root_from_soles[limb]).centroid();
        Self { robot, limb, root_from_soles, com }
    }

    /// Changes angles by decreasing steps until the criterion is met or no change helps.
    fn descend(&self, best: &mut SingleSupportPosture, angles: &mut [f64], criterion: Criterion) {
        for step in DESCENT_STEPS {
            for _ in 0..DESCENT_CHANGES_MAX {
                if criterion.is_met(best) || !self.improve(best, angles, step, criterion) {
                    break;
                }
            }
        }
    }

    /// Changes the angle that lowers the cost most, by one step. Returns whether one lowers it.
    fn improve(
        &self,
        best: &mut SingleSupportPosture,
        angles: &mut [f64],
        step: f64,
        criterion: Criterion,
    ) -> bool {
        let before = angles.to_vec();
        let mut least = criterion.cost(best, angles);
        for (index, change) in
            criterion.angles(before.len()).flat_map(|index| [(index, step), (index, -step)])
        {
            let mut changed = before.clone();
            changed[index] += change;
            let candidate = self.evaluate(&changed);
            if changed[index].abs() <= DEVIATION_MAX && criterion.cost(&candidate, &changed) < least
            {
                (*best, least) = (candidate, criterion.cost(&candidate, &changed));
                angles.copy_from_slice(&changed);
            }
        }
        angles != before
    }

    /// The posture with these deviations: roll and pitch of the root, then the trunk joints.
    fn evaluate(&self, angles: &[f64]) -> SingleSupportPosture {
        let robot = self.robot;
        let mut candidate = SingleSupportPosture {
            rotation: [angles[0], angles[1]],
            ..SingleSupportPosture::standing(robot.standing_q)
        };
        for (joint, angle) in robot.trunk_joints.iter().zip(&angles[2..]) {
            candidate.q[joint.index] =
                (candidate.q[joint.index] + angle).clamp(joint.lower, joint.upper);
        }
        let world_from_root = rotation_from_rpy(angles[0], angles[1], 0.0);
        let posture =
            Posture { world_from_root, leg_extension: robot.standing_leg_extension, com: self.com };
        if let Ok((configuration, kinematic_state)) =
            solve_posture(robot, &self.root_from_soles, &posture, candidate.q)
        {
            let loads = FootLoad::all_on(self.limb, self.com);
            let most = most_strained(&robot.mass_tree, &kinematic_state, &loads);
            (candidate.effort_use, candidate.most_strained) =
                (most.map_or(0.0, |(_, share)| share), most.map(|(joint, _)| joint));
            candidate.margin_deficit = self.margin_deficit(&configuration.q);
        }
        candidate
    }

    fn margin_deficit(&self, q: &[f64]) -> f64 {
        let margin = |joint: &LegJoint, q: &[f64]| {
            (q[joint.index] - joint.lower).min(joint.upper - q[joint.index])
        };
        let deficit = |joint: &LegJoint| {
            margin(joint, &self.robot.standing_q).min(LIMIT_MARGIN_DESIRED) - margin(joint, q)
        };
        let joints = self.robot.legs[self.limb].joints().iter();
        joints.map(deficit).fold(0.0, f64::max) / LIMIT_MARGIN_DESIRED
    }
}
