//! The validated model of a robot, from its URDF and its robot file (`robot.toml`).
//!
//! The model is plain data. Planner and checker each compile it into their own representation.

use glam::{DMat3, DVec3};

use crate::base::digest::Digest;
use crate::base::limits::{JOINTS_MAX, POLYGON_VERTICES_MAX};
use crate::base::spatial::{Pose, rotation_about};
use crate::geometry::shape::Shape;
use crate::plan_format::blocks::UrdfAdditions;

/// Index into [`RobotModel::links`].
pub type LinkIndex = usize;
/// Index into [`RobotModel::joints`] and into every joint vector `q`.
pub type JointIndex = usize;
/// Index into [`RobotModel::feet`].
pub type LimbIndex = usize;

/// A validated robot. A parent link precedes its children; link 0 is the root.
#[derive(Debug, Clone, PartialEq)]
pub struct RobotModel {
    /// The URDF's robot name.
    pub name: String,
    /// Absolute path of the URDF file.
    pub urdf_path: std::path::PathBuf,
    /// Absolute path of the robot file; `None` for a robot without one.
    pub robot_path: Option<std::path::PathBuf>,
    /// Absolute paths of the meshes that were read, sorted.
    pub mesh_paths: Vec<std::path::PathBuf>,
    /// All links, parents first.
    pub links: Vec<Link>,
    /// The moving joints, in the order of every joint vector `q`. At most [`JOINTS_MAX`], unless
    /// the robot is [`Self::unlocked`].
    pub joints: Vec<Joint>,
    /// The feet. A biped has two: 0 is left, 1 is right.
    pub feet: Vec<Foot>,
    /// Joint positions of the standing posture, one per joint, rad or m.
    pub standing_q: Vec<f64>,
    /// Joints that the robot file locks; not part of `q`.
    pub locked_joints: Vec<LockedJoint>,
    /// What the robot file states that the URDF lacks.
    pub additions: UrdfAdditions,
    /// The links that may overlap deeper than they do in walks.
    pub allowed_overlaps: Vec<AllowedOverlap>,
    /// Digest of the URDF, the robot file and all meshes.
    pub digest: Digest,
}

/// Two links of which the covers may overlap as the joints between them bend.
#[derive(Debug, Clone, PartialEq)]
pub struct AllowedOverlap {
    /// The names of the links.
    pub links: [String; 2],
    /// How deep they may overlap, m.
    pub depth: f64,
}

/// A rigid body of the robot.
#[derive(Debug, Clone, PartialEq)]
pub struct Link {
    /// URDF name.
    pub name: String,
    /// The joint to its parent; `None` for the root.
    pub parent: Option<Attachment>,
    /// Mass, kg; 0 for a massless frame.
    pub mass: f64,
    /// Centre of mass in the link frame, m.
    pub com: DVec3,
    /// Rotational inertia about the centre of mass in the axes of the link frame, kg m2.
    pub inertia: DMat3,
    /// Collision shapes.
    pub shapes: Vec<LinkShape>,
}

impl Link {
    /// Takes the mass and the shapes, and leaves a bare frame.
    pub(crate) fn take_body(&mut self) -> Self {
        let frame = Self {
            name: self.name.clone(),
            parent: self.parent.clone(),
            mass: 0.0,
            com: DVec3::ZERO,
            inertia: DMat3::ZERO,
            shapes: Vec::new(),
        };
        std::mem::replace(self, frame)
    }
}

/// The attachment of a link to its parent.
#[derive(Debug, Clone, PartialEq)]
pub struct Attachment {
    /// The parent link; its index is smaller than the child's.
    pub parent: LinkIndex,
    /// The joint frame in the parent link's frame; it equals the child's frame at position 0.
    pub parent_from_joint: Pose,
    /// The moving joint. `None` for a fixed or locked joint; the position of a locked joint is part
    /// of the pose.
    pub joint: Option<JointIndex>,
}

/// A collision shape of a link.
#[derive(Debug, Clone, PartialEq)]
pub struct LinkShape {
    /// The pose of the shape in the link frame.
    pub link_from_shape: Pose,
    /// The shape. A mesh is replaced by its convex hull, unless the robot file requires the exact
    /// mesh or the hull would hide collisions.
    pub shape: Shape,
}

/// The kind of a moving joint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum JointKind {
    /// Rotation about the axis (rad).
    Revolute,
    /// Translation along the axis (m).
    Prismatic,
}

/// A moving joint.
#[derive(Debug, Clone, PartialEq)]
pub struct Joint {
    /// URDF name.
    pub name: String,
    /// Rotation or translation.
    pub kind: JointKind,
    /// Unit axis in the joint frame.
    pub axis: DVec3,
    /// The link that it moves.
    pub child: LinkIndex,
    /// Lower position limit (rad or m).
    pub lower: f64,
    /// Upper position limit (rad or m), above `lower`.
    pub upper: f64,
    /// Largest torque or force (N m or N), positive and finite.
    pub effort: f64,
    /// Largest speed (rad/s or m/s), positive and finite.
    pub velocity: f64,
    /// Largest acceleration (rad/s2 or m/s2) by the robot file or the URDF, positive and finite;
    /// nothing where neither states one.
    pub stated_acceleration: Option<f64>,
}

impl Joint {
    /// Largest acceleration (rad/s2 or m/s2) in straight lines: the stated one, or
    /// [`ACCELERATION_DEFAULT`].
    pub fn acceleration(&self) -> f64 {
        self.stated_acceleration.unwrap_or(ACCELERATION_DEFAULT)
    }
}

/// Largest acceleration in straight lines of a joint without a stated one (rad/s2 or m/s2). Geared
/// joints of humanoids reach it with a small part of their torque.
pub const ACCELERATION_DEFAULT: f64 = 10.0;

/// A joint that the robot file locks. It is fixed in the kinematic tree; its motor has to hold it.
#[derive(Debug, Clone, PartialEq)]
pub struct LockedJoint {
    /// The joint if it were moving. Limits that the URDF does not give are infinite.
    pub joint: Joint,
    /// Its position, rad or m.
    pub position: f64,
    /// The joint frame in the parent link's frame at position 0.
    pub parent_from_joint: Pose,
}

/// The names of a biped's feet, in the order of [`RobotModel::feet`].
pub const FOOT_NAMES: [&str; 2] = ["left", "right"];

/// A foot: a link with a flat sole.
#[derive(Debug, Clone, PartialEq)]
pub struct Foot {
    /// "left" or "right".
    pub name: String,
    /// The link that carries the sole.
    pub link: LinkIndex,
    /// The sole frame in the link frame: z points from the ground into the foot, x forward.
    pub link_from_sole: Pose,
    /// The sole's outline in the sole frame at z = 0, m: convex, counter-clockwise, at most
    /// [`POLYGON_VERTICES_MAX`] vertices.
    pub polygon: Vec<glam::DVec2>,
}

impl RobotModel {
    /// Total mass, kg.
    pub fn mass(&self) -> f64 {
        self.links.iter().map(|link| link.mass).sum()
    }

    /// The lateral distance between the sole frames in the standing posture, m; 0 without two feet.
    pub fn stance_width(&self) -> f64 {
        let root_from_links = self.root_from_links(&self.standing_q);
        let sole = |foot: &Foot| root_from_links[foot.link] * foot.link_from_sole;
        match &self.feet[..] {
            [left, right] => (sole(left).translation - sole(right).translation).truncate().length(),
            _ => 0.0,
        }
    }

    /// How deep the robot file allows two links, by name, to overlap (m).
    pub fn allowed_overlap(&self, links: [&str; 2]) -> Option<f64> {
        let is_meant = |allowed: &&AllowedOverlap| {
            links.iter().all(|name| allowed.links.iter().any(|link| link == name))
        };
        self.allowed_overlaps.iter().find(is_meant).map(|allowed| allowed.depth)
    }

    /// The same robot with its locked joints as moving joints, after the others.
    pub fn unlocked(&self) -> Self {
        let mut robot = Self { locked_joints: Vec::new(), ..self.clone() };
        for locked in &self.locked_joints {
            if let Some(attachment) = &mut robot.links[locked.joint.child].parent {
                attachment.joint = Some(robot.joints.len());
                attachment.parent_from_joint = locked.parent_from_joint;
            }
            robot.joints.push(locked.joint.clone());
            robot.standing_q.push(locked.position);
        }
        robot
    }

    /// The pose of every link in the root frame at the joint positions `q`.
    pub fn root_from_links(&self, q: &[f64]) -> Vec<Pose> {
        let mut poses: Vec<Pose> = Vec::with_capacity(self.links.len());
        for link in &self.links {
            poses.push(link.parent.as_ref().map_or(Pose::IDENTITY, |at| {
                let motion = at.joint.map_or(Pose::IDENTITY, |index| {
                    let joint = &self.joints[index];
                    joint.kind.motion(joint.axis, q[index])
                });
                poses[at.parent] * at.parent_from_joint * motion
            }));
        }
        poses
    }

    /// The moving joints from the root to a link, root first.
    pub fn chain(&self, link: LinkIndex) -> Vec<JointIndex> {
        let mut joints = Vec::new();
        let mut at = self.links[link].parent.as_ref();
        while let Some(attachment) = at {
            joints.extend(attachment.joint);
            at = self.links[attachment.parent].parent.as_ref();
        }
        joints.reverse();
        joints
    }

    /// The moving joints of a leg, root first: those between the root and this foot and no other.
    pub fn leg(&self, limb: LimbIndex) -> Vec<JointIndex> {
        let mut joints = self.chain(self.feet[limb].link);
        let others = self.feet.iter().enumerate().filter(|(other, _)| *other != limb);
        let carry_others: Vec<JointIndex> =
            others.flat_map(|(_, foot)| self.chain(foot.link)).collect();
        joints.retain(|joint| !carry_others.contains(joint));
        joints
    }
}

impl JointKind {
    /// The pose of the child frame in the joint frame at a position (rad or m). `axis` is a unit
    /// vector in the joint frame.
    pub fn motion(self, axis: DVec3, position: f64) -> Pose {
        match self {
            Self::Revolute => Pose::from_rotation(rotation_about(axis, position)),
            Self::Prismatic => Pose::from_translation(axis * position),
        }
    }
}

/// The number of moving joints on the path between two links.
pub fn joints_between(links: &[Link], pair: [LinkIndex; 2]) -> usize {
    let (mut at, mut count) = (pair, 0);
    while at[0] != at[1] {
        // A parent precedes its children, so the later of two links is not an ancestor of the
        // other.
        let later = usize::from(at[1] > at[0]);
        let Some(attachment) = &links[at[later]].parent else { break };
        count += usize::from(attachment.joint.is_some());
        at[later] = attachment.parent;
    }
    count
}

const _: () = assert!(JOINTS_MAX >= 32 && POLYGON_VERTICES_MAX >= 4);
