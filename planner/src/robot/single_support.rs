//! How a robot carries itself on one foot where its standing posture would ask too much of a joint,
//! or leave it hardly any margin: the trunk leans over the stance hip, by the root's rotation and
//! by the joints between root and trunk. Derived from the robot alone, and where all primitive
//! configurations of transitions begin [Grey 4.4.5].

use glam::DVec2;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::base::spatial::rotation_from_rpy;
use surefoot_shared_types::robot::model::JointIndex;

use crate::kinematics::leg::LegJoint;
use crate::robot::gravity_torques::FootLoad;
use crate::robot::mechanism::Mechanism;
use crate::robot::posture_ik::{Posture, solve_posture};

/// The share of the usable effort that is easy enough.
const EFFORT_USE_LOW: f64 = 0.9;
/// The margin that each joint of the stance leg is desired to keep to its limits, rad or m, or as
/// much as it has on both feet.
const LIMIT_MARGIN: f64 = 0.15;
/// By how much an angle changes at a time, rad: coarsely first.
const STEPS: [f64; 4] = [0.08, 0.04, 0.02, 0.01];
/// Changes with each step at most.
const ROUNDS: usize = 6;
/// The most that an angle differs from the standing posture, rad.
const TURN_MAX: f64 = 0.3;
/// What a turn by one radian weighs against the effort: of postures that are as easy the straighter
/// one is taken.
const TURN_COST: f64 = 0.1;
/// What lacking all the margin that is desired weighs against it.
const DEFICIT_COST: f64 = 0.2;

/// A posture over one foot, near the standing one.
#[derive(Debug, Clone, Copy)]
pub struct SingleSupportPosture {
    /// The root's roll and pitch, rad.
    pub rotation: [f64; 2],
    /// Joint positions; those of the legs are the standing posture's.
    pub q: [f64; JOINTS_MAX],
    /// The largest share of its usable effort that a joint needs, on level ground and with the feet
    /// as they stand; infinite where that is not reached.
    pub effort_use: f64,
    /// That joint.
    pub most_strained: Option<JointIndex>,
    /// How much of the margin that each joint of the stance leg is desired to keep the worst one
    /// lacks then, 0 to about 1.
    pub margin_deficit: f64,
}

impl SingleSupportPosture {
    /// As in the standing posture, not evaluated yet.
    pub fn standing(standing_q: [f64; JOINTS_MAX]) -> Self {
        Self {
            rotation: [0.0; 2],
            q: standing_q,
            effort_use: f64::INFINITY,
            most_strained: None,
            margin_deficit: 0.0,
        }
    }

    /// The posture over one foot: the standing one where that is easy and leaves margin, or else
    /// the best to which descents from there lead.
    pub fn derive(robot: &Mechanism, limb: usize) -> Self {
        let ground = LevelGround::new(robot, limb);
        let mut turns = vec![0.0; 2 + robot.trunk_joints.len()];
        let mut best = ground.evaluate(&turns);
        ground.descend(&mut best, &mut turns, Criterion::Effort);
        ground.descend(&mut best, &mut turns, Criterion::LimitMargin);
        best
    }
}

/// What a descent is after.
#[derive(Debug, Clone, Copy)]
enum Criterion {
    /// Effort that is easy, by all angles.
    Effort,
    /// Room for the stance leg, by the trunk's joints: a root that rolls takes from the hip what it
    /// gives the ankle.
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

    fn cost(self, candidate: &SingleSupportPosture, turns: &[f64]) -> f64 {
        let strain = match self {
            Self::Effort => candidate.effort_use,
            Self::LimitMargin => {
                candidate.effort_use.max(EFFORT_USE_LOW) + DEFICIT_COST * candidate.margin_deficit
            }
        };
        strain + TURN_COST * turns.iter().map(|turn| turn.abs()).sum::<f64>()
    }
}

/// Level ground under both feet as they stand.
struct LevelGround<'a> {
    robot: &'a Mechanism,
    limb: usize,
    soles: [Pose; 2],
    /// Over the middle of the sole, or of what its ankle can hold.
    com: DVec2,
}

impl<'a> LevelGround<'a> {
    fn new(robot: &'a Mechanism, limb: usize) -> Self {
        let soles = [0, 1].map(|limb| robot.legs[limb].root_from_sole(&robot.standing_q));
        let com = robot.ankle_support_region(limb, &soles[limb]).centroid();
        Self { robot, limb, soles, com }
    }

    /// Changes angles, coarsely first, until the wish is met or no change helps.
    fn descend(&self, best: &mut SingleSupportPosture, turns: &mut [f64], criterion: Criterion) {
        for step in STEPS {
            for _ in 0..ROUNDS {
                if criterion.is_met(best) || !self.improve(best, turns, step, criterion) {
                    break;
                }
            }
        }
    }

    /// Changes the one angle by a step that makes the posture cheapest; whether one made it
    /// cheaper.
    fn improve(
        &self,
        best: &mut SingleSupportPosture,
        turns: &mut [f64],
        step: f64,
        criterion: Criterion,
    ) -> bool {
        let before = turns.to_vec();
        let mut least = criterion.cost(best, turns);
        for (angle, turn) in
            criterion.angles(before.len()).flat_map(|angle| [(angle, step), (angle, -step)])
        {
            let mut tried = before.clone();
            tried[angle] += turn;
            let candidate = self.evaluate(&tried);
            if tried[angle].abs() <= TURN_MAX && criterion.cost(&candidate, &tried) < least {
                (*best, least) = (candidate, criterion.cost(&candidate, &tried));
                turns.copy_from_slice(&tried);
            }
        }
        turns != before
    }

    /// The posture turned by these angles: roll and pitch of the root, then the trunk's joints.
    fn evaluate(&self, turns: &[f64]) -> SingleSupportPosture {
        let robot = self.robot;
        let mut candidate = SingleSupportPosture {
            rotation: [turns[0], turns[1]],
            ..SingleSupportPosture::standing(robot.standing_q)
        };
        for (joint, turn) in robot.trunk_joints.iter().zip(&turns[2..]) {
            candidate.q[joint.index] =
                (candidate.q[joint.index] + turn).clamp(joint.lower, joint.upper);
        }
        let world_from_root = rotation_from_rpy(turns[0], turns[1], 0.0);
        let posture =
            Posture { world_from_root, leg_extension: robot.standing_leg_extension, com: self.com };
        if let Ok((configuration, kinematic_state)) =
            solve_posture(robot, &self.soles, &posture, candidate.q)
        {
            let most = robot
                .statics
                .most_strained(&kinematic_state, &FootLoad::all_on(self.limb, self.com));
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
            margin(joint, &self.robot.standing_q).min(LIMIT_MARGIN) - margin(joint, q)
        };
        self.robot.legs[self.limb].joints().iter().map(deficit).fold(0.0, f64::max) / LIMIT_MARGIN
    }
}
