//! Closed-form inverse kinematics of a six-joint leg: three hip axes (yaw, roll, pitch) that meet in one point, a knee
//! and an ankle pitch parallel to the hip pitch, and an ankle roll that meets the ankle pitch at right angles.
//!
//! With all joints at zero let x, y, z be the roll, pitch and yaw axes. Then, with `u` from hip to knee axis and `v` from
//! knee axis to ankle,
//!
//! ```text
//! ankle - hip = R123 (u + Ry(q4) v)          R = R123 Ry(q4 + q5) Rx(q6)
//! ```
//!
//! The distance between ankle and hip gives q4, the hip seen from the foot gives q6 and q5, and what remains of R gives
//! q1 to q3. Two choices at the knee, at the ankle and at the hip make eight branches; the limits sort them.

use glam::{DMat3, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::JointKind;
use surefoot_shared_types::spatial::wrap_angle;

use super::leg::{LegJoint, LegPositions};

/// How exactly axes must meet and be parallel, m and sine of the angle.
const GEOMETRY_TOLERANCE: f64 = 1e-9;

/// How far beyond its reach a straight leg may seem to be by rounding, as a share.
const ROUNDING: f64 = 1e-12;

/// The geometry of a leg that has a closed form.
#[derive(Debug, Clone)]
pub struct ClosedForm {
    root_from_axes: DMat3,
    hip: DVec3,
    ankle_from_foot: DVec3,
    zero_rotation_inverse: DMat3,
    knee: DVec3,
    shank: DVec3,
    signs: [f64; 6],
}

impl ClosedForm {
    /// The closed form of these joints, if their axes allow one.
    pub fn recognise(joints: &[LegJoint], zero_root_from_sole: &Pose) -> Option<Self> {
        let joints: &[LegJoint; 6] = joints.try_into().ok()?;
        if joints.iter().any(|joint| joint.kind != JointKind::Revolute) {
            return None;
        }
        let axes = joints.map(|joint| joint.axis);
        let (x, y) = (axes[1], axes[2]);
        let root_from_axes = DMat3::from_cols(x, y, x.cross(y));
        let signs = axis_signs(&axes, &root_from_axes)?;
        let hip = meeting_point(&joints[0], &joints[1])?;
        let ankle = meeting_point(&joints[4], &joints[5])?;
        if distance_to_axis(&joints[2], hip) > GEOMETRY_TOLERANCE {
            return None;
        }
        let axes_from_root = root_from_axes.transpose();
        let zero_rotation = DMat3::from_quat(zero_root_from_sole.rotation);
        Some(Self {
            root_from_axes,
            hip,
            ankle_from_foot: zero_root_from_sole.inverse_transform_point(ankle),
            zero_rotation_inverse: zero_rotation.transpose() * root_from_axes,
            knee: axes_from_root * (joints[3].point - hip),
            shank: axes_from_root * (ankle - joints[3].point),
            signs,
        })
    }

    /// The solution within the limits that is nearest to `near`.
    pub fn solve(&self, joints: &[LegJoint], root_from_sole: &Pose, near: &LegPositions) -> Option<LegPositions> {
        let axes_from_root = self.root_from_axes.transpose();
        let rotation = axes_from_root * DMat3::from_quat(root_from_sole.rotation) * self.zero_rotation_inverse;
        let ankle = axes_from_root * (*root_from_sole * self.ankle_from_foot - self.hip);
        let mut best: Option<(f64, LegPositions)> = None;
        for knee in self.knee_angles(ankle)? {
            for roll in self.ankle_rolls(rotation.transpose() * ankle)? {
                for angles in self.hip_angles(&rotation, ankle, knee, roll) {
                    consider(joints, &self.signed(angles), near, &mut best);
                }
            }
        }
        best.map(|(_, positions)| positions)
    }

    fn signed(&self, angles: [f64; 6]) -> [f64; 6] {
        std::array::from_fn(|i| angles[i] * self.signs[i])
    }

    /// Both knee angles that bring the ankle to its distance from the hip.
    fn knee_angles(&self, ankle: DVec3) -> Option<[f64; 2]> {
        let (u, v) = (self.knee, self.shank);
        let along = u.y + v.y;
        let (uu, vv) = (u.x * u.x + u.z * u.z, v.x * v.x + v.z * v.z);
        let cosine_part = u.x * v.x + u.z * v.z;
        let sine_part = u.x * v.z - u.z * v.x;
        let amplitude = libm::sqrt(uu * vv);
        let wanted = 0.5 * (ankle.length_squared() - along * along - uu - vv);
        if wanted.abs() > amplitude * (1.0 + ROUNDING) {
            return None;
        }
        let phase = libm::atan2(sine_part, cosine_part);
        let opening = libm::acos((wanted / amplitude).clamp(-1.0, 1.0));
        Some([wrap_angle(phase + opening), wrap_angle(phase - opening)])
    }

    /// Both ankle rolls that bring the hip into the plane of the leg; `ankle` is hip to ankle in the foot's axes.
    fn ankle_rolls(&self, ankle: DVec3) -> Option<[f64; 2]> {
        let along = self.knee.y + self.shank.y;
        let amplitude = libm::hypot(ankle.y, ankle.z);
        if along.abs() > amplitude || amplitude < GEOMETRY_TOLERANCE {
            return None;
        }
        let phase = libm::atan2(ankle.z, ankle.y);
        let opening = libm::acos(along / amplitude);
        Some([wrap_angle(opening - phase), wrap_angle(-opening - phase)])
    }

    /// Both full solutions for a knee angle and an ankle roll.
    fn hip_angles(&self, rotation: &DMat3, ankle: DVec3, knee: f64, roll: f64) -> [[f64; 6]; 2] {
        let leg = self.knee + rotate_y(knee, self.shank);
        let seen = rotate_x(roll, rotation.transpose() * ankle);
        let pitches = wrap_angle(angle_about_y(seen, leg));
        let hip = *rotation * rotation_x(-roll) * rotation_y(-pitches);
        let sine = hip.y_axis.z.clamp(-1.0, 1.0);
        let principal = libm::asin(sine);
        let yaw = libm::atan2(-hip.y_axis.x, hip.y_axis.y);
        let pitch = libm::atan2(-hip.x_axis.z, hip.z_axis.z);
        let pi = std::f64::consts::PI;
        let ankle_pitch = wrap_angle(pitches - knee);
        [
            [yaw, principal, pitch, knee, ankle_pitch, roll],
            [wrap_angle(yaw + pi), wrap_angle(pi - principal), wrap_angle(pitch + pi), knee, ankle_pitch, roll],
        ]
    }
}

fn consider(joints: &[LegJoint], angles: &[f64; 6], near: &LegPositions, best: &mut Option<(f64, LegPositions)>) {
    if !joints.iter().zip(angles).all(|(joint, &angle)| joint.admits(angle)) {
        return;
    }
    let distance = near.iter().zip(angles).map(|(a, b)| (a - b) * (a - b)).sum();
    if best.as_ref().is_none_or(|(least, _)| distance < *least) {
        *best = Some((distance, angles.iter().copied().collect()));
    }
}

/// The sign of each joint's axis along z, x, y, y, y, x, if they are so aligned.
fn axis_signs(axes: &[DVec3; 6], root_from_axes: &DMat3) -> Option<[f64; 6]> {
    let wanted = [root_from_axes.z_axis, root_from_axes.x_axis, root_from_axes.y_axis];
    let order = [0, 1, 2, 2, 2, 1];
    let mut signs = [0.0; 6];
    for ((sign, axis), which) in signs.iter_mut().zip(axes).zip(order) {
        let along = axis.dot(wanted[which]);
        if axis.cross(wanted[which]).length() > GEOMETRY_TOLERANCE {
            return None;
        }
        *sign = along.signum();
    }
    (axes[1].dot(axes[2]).abs() < GEOMETRY_TOLERANCE).then_some(signs)
}

/// The point where two axes meet, if they do.
fn meeting_point(a: &LegJoint, b: &LegJoint) -> Option<DVec3> {
    let normal = a.axis.cross(b.axis);
    let denominator = normal.length_squared();
    if denominator < GEOMETRY_TOLERANCE {
        return None;
    }
    let between = b.point - a.point;
    let point = a.point + a.axis * (between.cross(b.axis).dot(normal) / denominator);
    (distance_to_axis(b, point) < GEOMETRY_TOLERANCE).then_some(point)
}

fn distance_to_axis(joint: &LegJoint, point: DVec3) -> f64 {
    (point - joint.point).cross(joint.axis).length()
}

/// The angle about y that turns `from` onto `to`, seen along y.
fn angle_about_y(from: DVec3, to: DVec3) -> f64 {
    libm::atan2(from.z * to.x - from.x * to.z, from.z * to.z + from.x * to.x)
}

fn rotation_x(angle: f64) -> DMat3 {
    let (s, c) = libm::sincos(angle);
    DMat3::from_cols(DVec3::X, DVec3::new(0.0, c, s), DVec3::new(0.0, -s, c))
}

fn rotation_y(angle: f64) -> DMat3 {
    let (s, c) = libm::sincos(angle);
    DMat3::from_cols(DVec3::new(c, 0.0, -s), DVec3::Y, DVec3::new(s, 0.0, c))
}

fn rotate_x(angle: f64, v: DVec3) -> DVec3 {
    rotation_x(angle) * v
}

fn rotate_y(angle: f64, v: DVec3) -> DVec3 {
    rotation_y(angle) * v
}
