//! The waist: the joint that bends the trunk forward, and how far.

use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;

use crate::collision::model::CollisionModel;
use crate::constraints::tuning::{
    BEND_LEVER_MIN, BEND_PURITY_MIN, BEND_STEP, BEND_TEST_ANGLE, WAIST_BEND_MAX,
};
use crate::robot::configuration::Configuration;
use crate::robot::free_joints::FreeJoint;
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::Mechanism;

/// A joint that bends the trunk forward.
#[derive(Debug, Clone, Copy)]
pub struct Waist {
    joint: FreeJoint,
    /// The sign in which the joint bends forward.
    forward: f64,
    /// Farthest forward bend from the standing posture, rad.
    pub bend_max: f64,
}

impl Waist {
    /// The trunk joint that bends a robot farthest forward in its standing posture before links
    /// collide; `None` if no trunk joint pitches.
    pub fn new(robot: &Mechanism, collision: &CollisionModel) -> Option<Self> {
        let waists = robot.trunk_joints.iter().filter_map(|joint| Self::at(robot, joint));
        let mut waist = waists.max_by(|a, b| a.bend_max.total_cmp(&b.bend_max))?;
        waist.bend_max = waist.free_bend(robot, collision)?;
        Some(waist)
    }

    /// A trunk joint as a waist; `None` if it does not move the centre of mass along x.
    fn at(robot: &Mechanism, joint: &FreeJoint) -> Option<Self> {
        let standing = robot.standing_q[joint.index];
        let mut q = robot.standing_q;
        q[joint.index] += BEND_TEST_ANGLE;
        let moved = robot.tree.total_moment(&q) - robot.tree.total_moment(&robot.standing_q);
        let least = BEND_LEVER_MIN * robot.mass_tree.mass() * BEND_TEST_ANGLE;
        let pitches = moved.x.abs() > (BEND_PURITY_MIN * moved.length()).max(least);
        let forward = moved.x.signum();
        let limit = if forward > 0.0 { joint.upper } else { joint.lower };
        let bend_max = (forward * (limit - standing)).min(WAIST_BEND_MAX);
        pitches.then_some(Self { joint: *joint, forward, bend_max })
    }

    /// The farthest bend (rad) up to which no links of the standing robot collide; `None` if there
    /// is none. Bends beyond a collision may be free again, but no motion leads there.
    fn free_bend(&self, robot: &Mechanism, collision: &CollisionModel) -> Option<f64> {
        let is_free = |bend: f64| {
            let mut q = robot.standing_q;
            self.bend(&mut q, bend);
            let bent = Configuration { world_from_root: Pose::IDENTITY, q };
            collision.self_hit(&KinematicState::new(robot, &bent)).is_none()
        };
        let steps = libm::floor(self.bend_max / BEND_STEP) as u32;
        let bends = (1..=steps).map(|step| f64::from(step) * BEND_STEP);
        bends.take_while(|&bend| is_free(bend)).last()
    }

    /// Bends the waist forward by `angle` (rad), as far as its limits allow.
    pub fn bend(&self, q: &mut [f64; JOINTS_MAX], angle: f64) {
        let position = q[self.joint.index] + self.forward * angle;
        q[self.joint.index] = position.clamp(self.joint.lower, self.joint.upper);
    }

    /// Index of the joint.
    pub fn joint(&self) -> usize {
        self.joint.index
    }
}
