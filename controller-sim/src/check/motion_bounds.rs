//! Upper bounds, valid in every configuration, on the displacement of a body's points during a
//! motion of the joints.

use surefoot_shared_types::robot::model::{JointIndex, JointKind, RobotModel};

use crate::check::motion::Change;
use crate::geometry::body::CollisionBody;

/// The longest lever arms of a body about the joints that carry it.
#[derive(Debug, Clone)]
pub struct LeverArms {
    /// About the root, m; `None` relative to another body, which the root moves as well.
    root: Option<f64>,
    /// The joints that carry the body, with the lever arm about each (m per rad, or 1 for a
    /// prismatic one). The joint furthest from the root comes first.
    joints: Vec<(JointIndex, f64)>,
}

impl LeverArms {
    /// The lever arms of a robot's body. No point is further from a joint than the sum of all
    /// offsets between them and the body's own reach.
    pub fn new(model: &RobotModel, body: &CollisionBody) -> Self {
        let mut joints = Vec::new();
        let mut length = body.reach;
        let mut at = body.link;
        while let Some(attachment) = at.and_then(|link| model.links[link].parent.as_ref()) {
            if let Some(joint) = attachment.joint {
                let joint_model = &model.joints[joint];
                match joint_model.kind {
                    JointKind::Revolute => joints.push((joint, length)),
                    JointKind::Prismatic => {
                        joints.push((joint, 1.0));
                        length += joint_model.lower.abs().max(joint_model.upper.abs());
                    }
                }
            }
            length += attachment.parent_from_joint.translation.length();
            at = Some(attachment.parent);
        }
        Self { root: Some(length), joints }
    }

    /// Those of two bodies relative to each other. Joints that carry both do not count.
    pub fn relative(a: &Self, b: &Self) -> Self {
        let is_apart = |(joint, _): &&(JointIndex, f64), other: &Self| {
            other.joints.iter().all(|(carrying, _)| carrying != joint)
        };
        let of_a = a.joints.iter().filter(|arm| is_apart(arm, b));
        let of_b = b.joints.iter().filter(|arm| is_apart(arm, a));
        Self { root: None, joints: of_a.chain(of_b).copied().collect() }
    }

    /// Upper bound on the displacement of any point of the body during a change, m.
    pub fn displacement_max(&self, change: &Change) -> f64 {
        let by_joints: f64 =
            self.joints.iter().map(|(joint, lever)| lever * change.joints[*joint]).sum();
        let by_root = self.root.map(|lever| change.root_position + lever * change.root_rotation);
        by_root.unwrap_or(0.0) + by_joints
    }
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use surefoot_shared_types::Pose;
    use surefoot_shared_types::base::spatial::rotation_about;

    use crate::check_robot::{ELBOW, SHOULDER, randoms, robot};
    use crate::geometry::solid::Solid;
    use crate::kinematics::forward::{Configuration, Posture};

    use super::*;

    const LEFT_LEG: usize = 1;
    const FOREARM: usize = 4;

    /// The lever arms of one body of each link.
    fn lever_arms(model: &RobotModel) -> Vec<(CollisionBody, LeverArms)> {
        let bodies = CollisionBody::of_robot(model).unwrap();
        bodies.into_iter().map(|body| (body.clone(), LeverArms::new(model, &body))).collect()
    }

    fn of_link(arms: &[(CollisionBody, LeverArms)], link: usize) -> &LeverArms {
        &arms.iter().find(|(body, _)| body.link == Some(link)).unwrap().1
    }

    fn turned(joint: usize, angle: f64) -> Change {
        let mut joints = vec![0.0; 4];
        joints[joint] = angle;
        Change { root_position: 0.0, root_rotation: 0.0, joints }
    }

    #[test]
    fn lever_arms_reach_to_the_furthest_point() {
        let arms = lever_arms(&robot());
        // The forearm's cover ends 0.38 m below the elbow, which is 0.4 m below the shoulder; a box
        // around the cover reaches a little further.
        let (upper_arm, forearm) = (of_link(&arms, 3), of_link(&arms, FOREARM));
        let near = |found: f64, expected: f64| (found / expected - 1.0).abs() < 0.01;
        assert!(near(forearm.displacement_max(&turned(ELBOW, 0.1)), 0.038));
        assert!(near(forearm.displacement_max(&turned(SHOULDER, 0.1)), 0.078));
        let shoulder = DVec3::new(0.0, 0.25, 0.2).length();
        let of_root = Change { root_rotation: 0.1, ..turned(0, 0.0) };
        assert!(near(forearm.displacement_max(&of_root), 0.1 * (0.78 + shoulder)));
        let moved = Change { root_position: 0.3, ..turned(ELBOW, 0.1) };
        assert!(near(forearm.displacement_max(&moved), 0.338));
        // Joints that carry both bodies do not move them against each other.
        let relative =
            |change: &Change| LeverArms::relative(forearm, upper_arm).displacement_max(change);
        assert!(near(relative(&turned(ELBOW, 0.1)), 0.038));
        assert_eq!(relative(&turned(SHOULDER, 0.1)), 0.0);
        let leg = of_link(&arms, LEFT_LEG);
        let both = Change { joints: vec![0.1, 0.0, 0.1, 0.0], ..moved };
        let expected = 0.078 + leg.displacement_max(&turned(0, 0.1));
        assert!(near(LeverArms::relative(forearm, leg).displacement_max(&both), expected));
    }

    #[test]
    fn no_point_moves_further_than_the_bound() {
        let mut between = randoms(3);
        let mut sliding = robot();
        sliding.joints[ELBOW].kind = JointKind::Prismatic;
        for model in [robot(), sliding] {
            let arms = lever_arms(&model);
            for _ in 0..200 {
                let mut configuration = |size: f64| Configuration {
                    world_from_root: Pose::from_parts(
                        DVec3::new(between(-size, size), 0.0, between(-size, size)),
                        rotation_about(DVec3::Y, between(-size, size)),
                    ),
                    q: (0..4).map(|_| between(-2.5 * size, 2.5 * size)).collect(),
                };
                let (a, b) = (configuration(0.3), configuration(1.0));
                let change = Change::between(&a, &b);
                let postures = [&a, &b].map(|at| Posture::new(&model, at));
                for (body, lever_arms) in &arms {
                    let bound = lever_arms.displacement_max(&change);
                    let Solid::Convex(convex) = &body.solid else { unreachable!() };
                    for point in convex.surface().into_iter().flatten() {
                        let [start, end] = [0, 1].map(|index: usize| {
                            let link = postures[index].world_from_link[body.link.unwrap()];
                            link * body.frame_from_solid * point
                        });
                        assert!(start.distance(end) <= bound + 1e-12, "{}", body.name);
                    }
                }
            }
        }
    }
}
