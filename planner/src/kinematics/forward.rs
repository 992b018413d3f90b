//! Forward kinematics of all links, fixed ones included, and their centre of mass.

use glam::{DMat3, DQuat, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_about, scaled_axis_from_rotation};
use surefoot_shared_types::robot::model::{JointKind, RobotModel};
use surefoot_shared_types::world::world::GRAVITY;

/// The robot's links, compiled for forward kinematics. The search uses
/// [`KinematicTree`](crate::kinematics::tree::KinematicTree), which is faster.
#[derive(Debug, Clone)]
pub struct Kinematics {
    links: Vec<LinkNode>,
    mass: f64,
}

#[derive(Debug, Clone)]
struct LinkNode {
    parent: usize,
    parent_from_joint: Pose,
    motion: LinkMotion,
    mass: f64,
    com: DVec3,
    /// About the centre of mass, along the link's axes, kg m2.
    inertia: DMat3,
}

#[derive(Debug, Clone, Copy)]
enum LinkMotion {
    Fixed,
    Rotation { joint: usize, axis: DVec3 },
    Translation { joint: usize, axis: DVec3 },
}

impl Kinematics {
    /// Compiles a robot.
    pub fn new(model: &RobotModel) -> Self {
        let links = model.links.iter().map(|link| {
            let (parent, parent_from_joint, joint) =
                link.parent.as_ref().map_or((0, Pose::IDENTITY, None), |at| {
                    (at.parent, at.parent_from_joint, at.joint)
                });
            let motion = joint.map_or(LinkMotion::Fixed, |joint| {
                let axis = model.joints[joint].axis;
                match model.joints[joint].kind {
                    JointKind::Revolute => LinkMotion::Rotation { joint, axis },
                    JointKind::Prismatic => LinkMotion::Translation { joint, axis },
                }
            });
            let (mass, com, inertia) = (link.mass, link.com, link.inertia);
            LinkNode { parent, parent_from_joint, motion, mass, com, inertia }
        });
        Self { links: links.collect(), mass: model.mass() }
    }

    /// How far a motion from some poses of the links to others moves the zero-moment point on the
    /// ground at the height `ground` (m), by unit of the second derivative of its progress from 0
    /// to 1, m s2.
    pub fn zero_moment_shift(&self, [from, to]: [&[Pose]; 2], ground: f64) -> f64 {
        let center = 0.5 * (self.center_of_mass(from) + self.center_of_mass(to));
        let origin = DVec3::new(center.x, center.y, ground);
        let moments = self.links.iter().zip(from.iter().zip(to)).map(|(link, (from, to))| {
            let [begin, end] = [*from * link.com, *to * link.com];
            let turn = scaled_axis_from_rotation(to.rotation * from.rotation.conjugate());
            let about_link = from.rotation * (link.inertia * (from.rotation.conjugate() * turn));
            link.mass * (0.5 * (begin + end) - origin).cross(end - begin) + about_link
        });
        moments.sum::<DVec3>().truncate().length() / (self.mass * GRAVITY)
    }

    /// Number of links.
    pub fn links_len(&self) -> usize {
        self.links.len()
    }

    /// Total mass, kg.
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// Writes the pose of every link. `q` has one entry per joint (rad or m), `world_from_links`
    /// one per link.
    ///
    /// # Panics
    /// A slice is too short.
    pub fn forward(&self, world_from_root: &Pose, q: &[f64], world_from_links: &mut [Pose]) {
        world_from_links[0] = *world_from_root;
        for (index, link) in self.links.iter().enumerate().skip(1) {
            let world_from_joint = world_from_links[link.parent] * link.parent_from_joint;
            world_from_links[index] = world_from_joint * link.motion.pose(q);
        }
    }

    /// Centre of mass in the world, m.
    pub fn center_of_mass(&self, world_from_links: &[Pose]) -> DVec3 {
        let moment = self
            .links
            .iter()
            .zip(world_from_links)
            .map(|(link, pose)| (*pose * link.com) * link.mass);
        moment.sum::<DVec3>() / self.mass
    }
}

impl LinkMotion {
    fn pose(self, q: &[f64]) -> Pose {
        match self {
            Self::Fixed => Pose::IDENTITY,
            Self::Rotation { joint, axis } => {
                Pose::from_parts(DVec3::ZERO, rotation_about(axis, q[joint]))
            }
            Self::Translation { joint, axis } => Pose::from_parts(axis * q[joint], DQuat::IDENTITY),
        }
    }
}
