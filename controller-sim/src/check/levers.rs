//! How far a motion of the joints can carry any point of a body: an upper bound that holds in every
//! configuration.

use surefoot_shared_types::robot::{JointKind, RobotModel};

use super::motion::Change;
use crate::geometry::body::Body;

/// The longest lever arms of a body about the joints that carry it.
#[derive(Debug, Clone)]
pub struct Levers {
    /// About the root, m.
    root: f64,
    /// About each joint (m per rad, or 1 for a prismatic one); 0 for joints that do not carry the
    /// body.
    joints: Vec<f64>,
}

impl Levers {
    /// The levers of a robot's body: from a joint, no point is further than all offsets on the way
    /// and the body's own reach.
    pub fn new(model: &RobotModel, body: &Body) -> Self {
        let mut joints = vec![0.0; model.joints.len()];
        let mut length = body.reach;
        let mut at = body.link;
        while let Some(attachment) = at.and_then(|link| model.links[link].parent.as_ref()) {
            if let Some(joint) = attachment.joint {
                let travel = &model.joints[joint];
                match travel.kind {
                    JointKind::Revolute => joints[joint] = length,
                    JointKind::Prismatic => {
                        joints[joint] = 1.0;
                        length += travel.lower.abs().max(travel.upper.abs());
                    }
                }
            }
            length += attachment.parent_from_joint.translation.length();
            at = Some(attachment.parent);
        }
        Self { root: length, joints }
    }

    /// The longest way of any point of the body in the world during a change, m.
    pub fn way(&self, change: &Change) -> f64 {
        let by_joints: f64 =
            self.joints.iter().zip(&change.joints).map(|(lever, step)| lever * step).sum();
        change.root_position + self.root * change.root_rotation + by_joints
    }

    /// The longest way of any point of the body relative to another body's, m: joints that carry
    /// both do not count.
    pub fn relative_way(&self, other: &Self, change: &Change) -> f64 {
        let levers = self.joints.iter().zip(&other.joints);
        let apart = levers.map(|(&a, &b)| if a == 0.0 || b == 0.0 { a + b } else { 0.0 });
        apart.zip(&change.joints).map(|(lever, step)| lever * step).sum()
    }
}
