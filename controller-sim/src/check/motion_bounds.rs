//! Upper bounds, valid in every configuration, on the displacement of a body's points during a
//! motion of the joints.

use surefoot_shared_types::robot::model::{JointKind, RobotModel};

use crate::check::motion::Change;
use crate::geometry::body::CollisionBody;

/// The longest lever arms of a body about the joints that carry it.
#[derive(Debug, Clone)]
pub struct LeverArms {
    /// About the root, m.
    root: f64,
    /// About each joint (m per rad, or 1 for a prismatic one); 0 for joints that do not carry the
    /// body.
    joints: Vec<f64>,
}

impl LeverArms {
    /// The lever arms of a robot's body. No point is further from a joint than the sum of all
    /// offsets between them and the body's own reach.
    pub fn new(model: &RobotModel, body: &CollisionBody) -> Self {
        let mut joints = vec![0.0; model.joints.len()];
        let mut length = body.reach;
        let mut at = body.link;
        while let Some(attachment) = at.and_then(|link| model.links[link].parent.as_ref()) {
            if let Some(joint) = attachment.joint {
                let joint_model = &model.joints[joint];
                match joint_model.kind {
                    JointKind::Revolute => joints[joint] = length,
                    JointKind::Prismatic => {
                        joints[joint] = 1.0;
                        length += joint_model.lower.abs().max(joint_model.upper.abs());
                    }
                }
            }
            length += attachment.parent_from_joint.translation.length();
            at = Some(attachment.parent);
        }
        Self { root: length, joints }
    }

    /// Upper bound on the displacement of any point of the body in the world during a change, m.
    pub fn displacement_max(&self, change: &Change) -> f64 {
        let by_joints: f64 =
            self.joints.iter().zip(&change.joints).map(|(lever, step)| lever * step).sum();
        change.root_position + self.root * change.root_rotation + by_joints
    }

    /// Upper bound on the displacement of any point of the body relative to another body, m.
    /// Joints that carry both do not count.
    pub fn relative_displacement_max(&self, other: &Self, change: &Change) -> f64 {
        let lever_arms = self.joints.iter().zip(&other.joints);
        let apart = lever_arms.map(|(&a, &b)| if a == 0.0 || b == 0.0 { a + b } else { 0.0 });
        apart.zip(&change.joints).map(|(lever, step)| lever * step).sum()
    }
}
