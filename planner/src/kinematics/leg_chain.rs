//! Forward kinematics of one leg with its Jacobian, for the Newton iteration.

use glam::{DMat3, DQuat, DVec3};
use heapless::Vec as BoundedVec;
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::model::JointKind;

use crate::kinematics::leg_joint::{LEG_JOINTS_MAX, LegJoint, LegPositions};

/// A twist: linear part (m) before angular part (rad).
pub(crate) type Vector6 = [f64; 6];

/// The links of a leg in frames whose z axes are the joint axes.
#[derive(Debug, Clone)]
pub(crate) struct LegChain {
    root_from_first: DMat3,
    links: BoundedVec<ChainLink, LEG_JOINTS_MAX>,
}

/// The link between a joint and the next one, or the sole, in a frame that moves with the joint.
#[derive(Debug, Clone, Copy)]
struct ChainLink {
    joint_from_next: DMat3,
    /// Point of the next joint, m.
    next: DVec3,
}

impl LegChain {
    /// The chain of these joints; `zero_root_from_sole` is the sole's pose with all joints at 0.
    pub(crate) fn new(joints: &[LegJoint], zero_root_from_sole: &Pose) -> Self {
        Self {
            root_from_first: frame_along(joints[0].axis),
            links: links(joints, zero_root_from_sole),
        }
    }

    /// Returns the sole's pose in the root frame and writes the Jacobian: one column per joint, the
    /// twist of the sole (linear at the sole's origin) per unit of joint motion.
    pub(crate) fn forward(
        &self,
        joints: &[LegJoint],
        q: &LegPositions,
        columns: &mut [Vector6],
    ) -> Pose {
        let (mut point, mut frame) = (joints[0].point, self.root_from_first);
        let mut axes = [(DVec3::ZERO, DVec3::ZERO); LEG_JOINTS_MAX];
        for (((joint, link), &position), axis) in
            joints.iter().zip(&self.links).zip(q).zip(&mut axes)
        {
            *axis = (point, frame.z_axis);
            match joint.kind {
                JointKind::Revolute => rotate_about_z(&mut frame, position),
                JointKind::Prismatic => point += frame.z_axis * position,
            }
            point += frame * link.next;
            frame *= link.joint_from_next;
        }
        for ((joint, (at, axis)), column) in joints.iter().zip(axes).zip(columns) {
            let (linear, angular) = match joint.kind {
                JointKind::Revolute => (axis.cross(point - at), axis),
                JointKind::Prismatic => (axis, DVec3::ZERO),
            };
            *column = [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z];
        }
        Pose::from_parts(point, DQuat::from_mat3(&frame))
    }
}

/// A frame whose z axis is `axis`.
fn frame_along(axis: DVec3) -> DMat3 {
    let x = axis.any_orthonormal_vector();
    DMat3::from_cols(x, axis.cross(x), axis)
}

/// Rotates a frame about its own z axis.
fn rotate_about_z(frame: &mut DMat3, angle: f64) {
    let (sin, cos) = libm::sincos(angle);
    let (x, y) = (frame.x_axis, frame.y_axis);
    (frame.x_axis, frame.y_axis) = (x * cos + y * sin, y * cos - x * sin);
}

fn links(joints: &[LegJoint], zero_root_from_sole: &Pose) -> BoundedVec<ChainLink, LEG_JOINTS_MAX> {
    let ends = joints[1..].iter().map(|joint| (frame_along(joint.axis), joint.point));
    let sole = (DMat3::from_quat(zero_root_from_sole.rotation), zero_root_from_sole.translation);
    let link = |(joint, (frame, point)): (&LegJoint, (DMat3, DVec3))| {
        let joint_from_root = frame_along(joint.axis).transpose();
        ChainLink {
            joint_from_next: joint_from_root * frame,
            next: joint_from_root * (point - joint.point),
        }
    };
    joints.iter().zip(ends.chain(std::iter::once(sole))).map(link).collect()
}
