//! How a robot carries itself on one foot where its standing posture would ask too much of a joint,
//! or leave it hardly any room: the trunk leans over the stance hip, by the root's rotation and by
//! the joints between root and trunk. Derived from the robot alone, and where all primitive
//! configurations of transitions begin [Grey 4.4.5].

use glam::DVec2;
use surefoot_shared_types::Pose;
use surefoot_shared_types::message::limits::JOINTS_MAX;
use surefoot_shared_types::robot::JointIndex;
use surefoot_shared_types::spatial::rotation_from_rpy;

use crate::body::Body;
use crate::kinematics::leg::LegJoint;
use crate::posture::{Posture, settle};
use crate::statics::FootLoad;

/// The share of the usable effort that is easy enough.
const EASY: f64 = 0.9;
/// The room that each joint of the stance leg is wished to keep to its limits, rad or m, or as much
/// as it has on both feet.
const ROOM: f64 = 0.15;
/// By how much an angle changes at a time, rad: coarsely first.
const STEPS: [f64; 4] = [0.08, 0.04, 0.02, 0.01];
/// Changes with each step at most.
const ROUNDS: usize = 6;
/// The most that an angle differs from the standing posture, rad.
const TURN_MAX: f64 = 0.3;
/// What a turn by one radian weighs against the effort: of postures that are as easy the straighter
/// one is taken.
const TURN_COST: f64 = 0.1;
/// What lacking all the room that is wished for weighs against it.
const LACK_COST: f64 = 0.2;

/// A posture over one foot, near the standing one.
#[derive(Debug, Clone, Copy)]
pub struct Carriage {
    /// The root's roll and pitch, rad.
    pub rotation: [f64; 2],
    /// Joint positions; those of the legs are the standing posture's.
    pub q: [f64; JOINTS_MAX],
    /// The largest share of its usable effort that a joint needs, on level ground and with the feet
    /// as they stand; infinite where that is not reached.
    pub effort_use: f64,
    /// That joint.
    pub most_strained: Option<JointIndex>,
    /// How much of the room that each joint of the stance leg is wished to keep the worst one lacks
    /// then, 0 to about 1.
    pub lacking_room: f64,
}

impl Carriage {
    /// As in the standing posture, not weighed yet.
    pub fn standing(standing_q: [f64; JOINTS_MAX]) -> Self {
        Self {
            rotation: [0.0; 2],
            q: standing_q,
            effort_use: f64::INFINITY,
            most_strained: None,
            lacking_room: 0.0,
        }
    }

    /// The posture over one foot: the standing one where that is easy and leaves room, or else the
    /// best to which descents from there lead.
    pub fn derive(body: &Body, limb: usize) -> Self {
        let place = Place::new(body, limb);
        let mut turns = vec![0.0; 2 + body.trunk_joints.len()];
        let mut best = place.weigh(&turns);
        place.descend(&mut best, &mut turns, Wish::Effort);
        place.descend(&mut best, &mut turns, Wish::Room);
        best
    }
}

/// What a descent is after.
#[derive(Debug, Clone, Copy)]
enum Wish {
    /// Effort that is easy, by all angles.
    Effort,
    /// Room for the stance leg, by the trunk's joints: a root that rolls takes from the hip what it
    /// gives the ankle.
    Room,
}

impl Wish {
    fn is_met(self, carriage: &Carriage) -> bool {
        match self {
            Self::Effort => carriage.effort_use <= EASY,
            Self::Room => carriage.lacking_room <= 0.0,
        }
    }

    fn angles(self, count: usize) -> std::ops::Range<usize> {
        match self {
            Self::Effort => 0..count,
            Self::Room => 2..count,
        }
    }

    fn cost(self, carriage: &Carriage, turns: &[f64]) -> f64 {
        let strain = match self {
            Self::Effort => carriage.effort_use,
            Self::Room => carriage.effort_use.max(EASY) + LACK_COST * carriage.lacking_room,
        };
        strain + TURN_COST * turns.iter().map(|turn| turn.abs()).sum::<f64>()
    }
}

/// Level ground under both feet as they stand.
struct Place<'a> {
    body: &'a Body,
    limb: usize,
    soles: [Pose; 2],
    /// Over the middle of the sole, or of what its ankle can hold.
    com: DVec2,
}

impl<'a> Place<'a> {
    fn new(body: &'a Body, limb: usize) -> Self {
        let soles = [0, 1].map(|limb| body.legs[limb].root_from_sole(&body.standing_q));
        let com = body.held_region(limb, &soles[limb]).centroid();
        Self { body, limb, soles, com }
    }

    /// Changes angles, coarsely first, until the wish is met or no change helps.
    fn descend(&self, best: &mut Carriage, turns: &mut [f64], wish: Wish) {
        for step in STEPS {
            for _ in 0..ROUNDS {
                if wish.is_met(best) || !self.improve(best, turns, step, wish) {
                    break;
                }
            }
        }
    }

    /// Changes the one angle by a step that makes the posture cheapest; whether one made it
    /// cheaper.
    fn improve(&self, best: &mut Carriage, turns: &mut [f64], step: f64, wish: Wish) -> bool {
        let before = turns.to_vec();
        let mut least = wish.cost(best, turns);
        for (angle, turn) in
            wish.angles(before.len()).flat_map(|angle| [(angle, step), (angle, -step)])
        {
            let mut tried = before.clone();
            tried[angle] += turn;
            let carriage = self.weigh(&tried);
            if tried[angle].abs() <= TURN_MAX && wish.cost(&carriage, &tried) < least {
                (*best, least) = (carriage, wish.cost(&carriage, &tried));
                turns.copy_from_slice(&tried);
            }
        }
        turns != before
    }

    /// The posture turned by these angles: roll and pitch of the root, then the trunk's joints.
    fn weigh(&self, turns: &[f64]) -> Carriage {
        let body = self.body;
        let mut carriage =
            Carriage { rotation: [turns[0], turns[1]], ..Carriage::standing(body.standing_q) };
        for (joint, turn) in body.trunk_joints.iter().zip(&turns[2..]) {
            carriage.q[joint.index] =
                (carriage.q[joint.index] + turn).clamp(joint.lower, joint.upper);
        }
        let world_from_root = rotation_from_rpy(turns[0], turns[1], 0.0);
        let posture =
            Posture { world_from_root, reach_share: body.standing_reach_share, com: self.com };
        if let Ok((configuration, snapshot)) = settle(body, &self.soles, &posture, carriage.q) {
            let most =
                body.statics.most_strained(&snapshot, &FootLoad::all_on(self.limb, self.com));
            (carriage.effort_use, carriage.most_strained) =
                (most.map_or(0.0, |(_, share)| share), most.map(|(joint, _)| joint));
            carriage.lacking_room = self.lacking_room(&configuration.q);
        }
        carriage
    }

    fn lacking_room(&self, q: &[f64]) -> f64 {
        let room = |joint: &LegJoint, q: &[f64]| {
            (q[joint.index] - joint.lower).min(joint.upper - q[joint.index])
        };
        let lack = |joint: &LegJoint| room(joint, &self.body.standing_q).min(ROOM) - room(joint, q);
        self.body.legs[self.limb].joints().iter().map(lack).fold(0.0, f64::max) / ROOM
    }
}
