//! How a robot carries itself on one foot where its standing posture would ask too much of a joint: the trunk leans over the stance
//! hip, by the root's rotation and by the joints between root and trunk. Derived from the robot alone, and where all primitive
//! configurations of transitions begin [Grey 4.4.5].

use glam::DVec2;
use surefoot_shared_types::Pose;
use surefoot_shared_types::message::limits::JOINTS_MAX;
use surefoot_shared_types::robot::JointIndex;
use surefoot_shared_types::spatial::rotation_from_rpy;

use crate::body::{Body, FreeJoint};
use crate::posture::{Posture, settle};
use crate::statics::FootLoad;

/// The share of the usable effort that is easy enough.
const EASY: f64 = 0.9;
/// By how much an angle changes at a time, rad: coarsely first.
const STEPS: [f64; 4] = [0.08, 0.04, 0.02, 0.01];
/// Changes with each step at most.
const ROUNDS: usize = 6;
/// The most that an angle differs from the standing posture, rad.
const TURN_MAX: f64 = 0.3;
/// A joint on which this share of the robot's mass hangs carries its trunk.
const TRUNK_SHARE: f64 = 0.2;
/// What a turn by one radian weighs against the effort: of postures that are as easy the straighter one is taken.
const TURN_COST: f64 = 0.1;

/// A posture over one foot, near the standing one.
#[derive(Debug, Clone, Copy)]
pub struct Carriage {
    /// The root's roll and pitch, rad.
    pub rotation: [f64; 2],
    /// Joint positions; those of the legs are the standing posture's.
    pub q: [f64; JOINTS_MAX],
    /// The largest share of its usable effort that a joint needs, on level ground and with the feet as they stand; infinite where
    /// that is not reached.
    pub effort_use: f64,
    /// That joint.
    pub most_strained: Option<JointIndex>,
}

impl Carriage {
    /// As in the standing posture, not weighed yet.
    pub fn standing(standing_q: [f64; JOINTS_MAX]) -> Self {
        Self { rotation: [0.0; 2], q: standing_q, effort_use: f64::INFINITY, most_strained: None }
    }

    /// The posture over one foot: the standing one where that is easy, or else the easiest to which a descent from there leads.
    pub fn derive(body: &Body, limb: usize) -> Self {
        let place = Place::new(body, limb);
        let mut turns = vec![0.0; 2 + place.trunk.len()];
        let mut best = place.weigh(&turns);
        for step in STEPS {
            for _ in 0..ROUNDS {
                if best.effort_use <= EASY || !place.improve(&mut best, &mut turns, step) {
                    break;
                }
            }
        }
        best
    }
}

/// Level ground under both feet as they stand.
struct Place<'a> {
    body: &'a Body,
    limb: usize,
    soles: [Pose; 2],
    /// Over the middle of the sole, or of what its ankle can hold.
    com: DVec2,
    trunk: Vec<&'a FreeJoint>,
}

impl<'a> Place<'a> {
    fn new(body: &'a Body, limb: usize) -> Self {
        let soles = [0, 1].map(|limb| body.legs[limb].root_from_sole(&body.standing_q));
        let com = body.held_region(limb, &soles[limb]).centroid();
        let carries_trunk = |joint: &&FreeJoint| body.statics.carried_mass(joint.index) >= TRUNK_SHARE * body.statics.mass();
        let trunk = body.free_joints.iter().filter(carries_trunk).collect();
        Self { body, limb, soles, com, trunk }
    }

    /// Changes the one angle by a step that makes the posture cheapest; whether one made it cheaper.
    fn improve(&self, best: &mut Carriage, turns: &mut [f64], step: f64) -> bool {
        let before = turns.to_vec();
        let mut least = cost(best, turns);
        for (angle, turn) in (0..before.len()).flat_map(|angle| [(angle, step), (angle, -step)]) {
            let mut tried = before.clone();
            tried[angle] += turn;
            let carriage = self.weigh(&tried);
            if tried[angle].abs() <= TURN_MAX && cost(&carriage, &tried) < least {
                (*best, least) = (carriage, cost(&carriage, &tried));
                turns.copy_from_slice(&tried);
            }
        }
        turns != before
    }

    /// The posture turned by these angles: roll and pitch of the root, then the trunk's joints.
    fn weigh(&self, turns: &[f64]) -> Carriage {
        let body = self.body;
        let mut carriage = Carriage { rotation: [turns[0], turns[1]], ..Carriage::standing(body.standing_q) };
        for (joint, turn) in self.trunk.iter().zip(&turns[2..]) {
            carriage.q[joint.index] = (carriage.q[joint.index] + turn).clamp(joint.lower, joint.upper);
        }
        let world_from_root = rotation_from_rpy(turns[0], turns[1], 0.0);
        let posture = Posture { world_from_root, reach_share: body.standing_reach_share, com: self.com };
        if let Ok((_, snapshot)) = settle(body, &self.soles, &posture, carriage.q) {
            let most = body.statics.most_strained(&snapshot, &FootLoad::all_on(self.limb, self.com));
            (carriage.effort_use, carriage.most_strained) = (most.map_or(0.0, |(_, share)| share), most.map(|(joint, _)| joint));
        }
        carriage
    }
}

fn cost(carriage: &Carriage, turns: &[f64]) -> f64 {
    carriage.effort_use + TURN_COST * turns.iter().map(|turn| turn.abs()).sum::<f64>()
}
