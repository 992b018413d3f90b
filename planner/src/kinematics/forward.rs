//! Forward kinematics of the whole tree and its centre of mass.

use glam::{DQuat, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::{JointKind, RobotModel};
use surefoot_shared_types::spatial::rotation_about;

use super::carriers::{Carrier, carriers};

/// The robot's tree, compiled for forward kinematics.
#[derive(Debug, Clone)]
pub struct Kinematics {
    links: Vec<LinkNode>,
    carriers: Vec<Carrier>,
    mass: f64,
}

#[derive(Debug, Clone)]
struct LinkNode {
    parent: usize,
    parent_from_joint: Pose,
    /// Whether the joint's frame is turned against the parent's.
    is_turned: bool,
    motion: Motion,
}

#[derive(Debug, Clone, Copy)]
enum Motion {
    Fixed,
    /// About a coordinate axis, by the joint's position times the sign.
    TurnAboutX {
        joint: usize,
        sign: f64,
    },
    TurnAboutY {
        joint: usize,
        sign: f64,
    },
    TurnAboutZ {
        joint: usize,
        sign: f64,
    },
    Turn {
        joint: usize,
        axis: DVec3,
    },
    Slide {
        joint: usize,
        axis: DVec3,
    },
}

impl Kinematics {
    /// Compiles a robot.
    pub fn new(model: &RobotModel) -> Self {
        let links = model.links.iter().map(|link| {
            let (parent, parent_from_joint, joint) =
                link.parent.as_ref().map_or((0, Pose::IDENTITY, None), |at| (at.parent, at.parent_from_joint, at.joint));
            let motion = joint.map_or(Motion::Fixed, |joint| {
                let axis = model.joints[joint].axis;
                match model.joints[joint].kind {
                    JointKind::Revolute => Motion::turn(joint, axis),
                    JointKind::Prismatic => Motion::Slide { joint, axis },
                }
            });
            let is_turned = parent_from_joint.rotation != DQuat::IDENTITY;
            LinkNode { parent, parent_from_joint, is_turned, motion }
        });
        Self { links: links.collect(), carriers: carriers(model), mass: model.mass() }
    }

    /// The number of links.
    pub fn links_len(&self) -> usize {
        self.links.len()
    }

    /// Total mass, kg.
    pub fn mass(&self) -> f64 {
        self.mass
    }

    /// Writes every link's pose. `q` has one entry per joint, `world_from_links` one per link.
    pub fn forward(&self, world_from_root: &Pose, q: &[f64], world_from_links: &mut [Pose]) {
        world_from_links[0] = *world_from_root;
        for (index, link) in self.links.iter().enumerate().skip(1) {
            let parent = &world_from_links[link.parent];
            let offset = &link.parent_from_joint;
            let translation = parent.translation + parent.rotation * offset.translation;
            let rotation = if link.is_turned { parent.rotation * offset.rotation } else { parent.rotation };
            world_from_links[index] = link.motion.after(translation, rotation, q);
        }
    }

    /// The centre of mass in the world.
    pub fn center_of_mass(&self, world_from_links: &[Pose]) -> DVec3 {
        let moment = self.carriers.iter().map(|carrier| (world_from_links[carrier.link] * carrier.com) * carrier.mass);
        moment.sum::<DVec3>() / self.mass
    }
}

impl Motion {
    fn turn(joint: usize, axis: DVec3) -> Self {
        let is_along = |wanted: DVec3| axis == wanted || axis == -wanted;
        let sign = axis.element_sum();
        match axis {
            _ if is_along(DVec3::X) => Self::TurnAboutX { joint, sign },
            _ if is_along(DVec3::Y) => Self::TurnAboutY { joint, sign },
            _ if is_along(DVec3::Z) => Self::TurnAboutZ { joint, sign },
            _ => Self::Turn { joint, axis },
        }
    }

    /// The pose of the joint's child where the joint's own frame is at this translation and rotation.
    fn after(self, translation: DVec3, r: DQuat, q: &[f64]) -> Pose {
        let half = |joint: usize, sign: f64| libm::sincos(sign * (0.5 * q[joint]));
        // A product with (s, 0, 0, c) and its like, written without the terms that are 0.
        let rotation = match self {
            Self::Fixed => r,
            Self::TurnAboutX { joint, sign } => {
                let (s, c) = half(joint, sign);
                DQuat::from_xyzw(r.w * s + r.x * c, r.y * c + r.z * s, r.z * c - r.y * s, r.w * c - r.x * s)
            }
            Self::TurnAboutY { joint, sign } => {
                let (s, c) = half(joint, sign);
                DQuat::from_xyzw(r.x * c - r.z * s, r.w * s + r.y * c, r.x * s + r.z * c, r.w * c - r.y * s)
            }
            Self::TurnAboutZ { joint, sign } => {
                let (s, c) = half(joint, sign);
                DQuat::from_xyzw(r.x * c + r.y * s, r.y * c - r.x * s, r.w * s + r.z * c, r.w * c - r.z * s)
            }
            Self::Turn { joint, axis } => r * rotation_about(axis, q[joint]),
            Self::Slide { joint, axis } => return Pose::from_parts(translation + r * (axis * q[joint]), r),
        };
        Pose::from_parts(translation, rotation)
    }
}
