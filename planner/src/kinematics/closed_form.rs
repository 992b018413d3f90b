//! Closed-form inverse kinematics of a six-joint leg: three hip axes (yaw, roll, pitch) that meet
//! in one point, a knee and an ankle pitch parallel to the hip pitch, and an ankle roll that meets
//! the ankle pitch at right angles.
//!
//! With all joints at zero let x, y, z be the roll, pitch and yaw axes. Then, with `u` from hip to
//! knee axis and `v` from knee axis to ankle,
//!
//! ```text
//! ankle - hip = R123 (u + Ry(q4) v)          R = R123 Ry(q4 + q5) Rx(q6)
//! ```
//!
//! The distance between ankle and hip gives q4, the direction of the hip in the foot's frame gives
//! q6 and q5, and the rest of R gives q1 to q3. Two choices each at the knee, the ankle and the hip
//! make eight branches. They are computed as sines and cosines; angles are computed only for
//! branches that may be within the limits, usually one.

use glam::{DMat3, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::model::JointKind;

use crate::kinematics::angle_interval::{AngleInterval, UnitRotation};
use crate::kinematics::leg_joint::{LegJoint, LegPositions};

/// Largest distance of intersecting axes (m) and largest sine between parallel axes.
const GEOMETRY_TOLERANCE: f64 = 1e-9;

/// Relative rounding error by which a straight leg may exceed its reach.
const REACH_ROUNDING: f64 = 1e-12;

/// The geometry of a leg with a closed form.
#[derive(Debug, Clone)]
pub(crate) struct ClosedForm {
    axes_from_root: DMat3,
    hip: DVec3,
    ankle_from_foot: DVec3,
    zero_rotation_inverse: DMat3,
    knee: DVec3,
    shank: DVec3,
    knee_distance: KneeDistance,
    signs: [f64; 6],
    /// Each joint's limits, about the axes x, y, z.
    intervals: [AngleInterval; 6],
}

/// The squared distance between ankle and hip as a function of the knee's rotation:
/// `base + 2 amplitude cos(q4 - phase)`.
#[derive(Debug, Clone)]
struct KneeDistance {
    base: f64,
    amplitude: f64,
    phase: UnitRotation,
}

impl KneeDistance {
    fn new(knee: DVec3, shank: DVec3) -> Self {
        let (u, v) = (knee, shank);
        let along = u.y + v.y;
        let (uu, vv) = (u.x * u.x + u.z * u.z, v.x * v.x + v.z * v.z);
        let phase = UnitRotation::in_proportion(u.x * v.z - u.z * v.x, u.x * v.x + u.z * v.z);
        Self { base: along * along + uu + vv, amplitude: libm::sqrt(uu * vv), phase }
    }
}

/// The rotations of the six joints, hip yaw first.
type Branch = [UnitRotation; 6];

impl ClosedForm {
    /// The closed form of these joints, if their axes allow one; `zero_root_from_sole` is the
    /// sole's pose with all joints at 0.
    pub(crate) fn detect(joints: &[LegJoint], zero_root_from_sole: &Pose) -> Option<Self> {
        let joints: &[LegJoint; 6] = joints.try_into().ok()?;
        if joints.iter().any(|joint| joint.kind != JointKind::Revolute) {
            return None;
        }
        let axes = joints.map(|joint| joint.axis);
        let (x, y) = (axes[1], axes[2]);
        let root_from_axes = DMat3::from_cols(x, y, x.cross(y));
        let signs = axis_signs(&axes, &root_from_axes)?;
        let hip = intersection(&joints[0], &joints[1])?;
        let ankle = intersection(&joints[4], &joints[5])?;
        if distance_to_axis(&joints[2], hip) > GEOMETRY_TOLERANCE {
            return None;
        }
        let axes_from_root = root_from_axes.transpose();
        let zero_rotation = DMat3::from_quat(zero_root_from_sole.rotation);
        let knee = axes_from_root * (joints[3].point - hip);
        let shank = axes_from_root * (ankle - joints[3].point);
        Some(Self {
            axes_from_root,
            hip,
            ankle_from_foot: zero_root_from_sole.inverse_transform_point(ankle),
            zero_rotation_inverse: zero_rotation.transpose() * root_from_axes,
            knee_distance: KneeDistance::new(knee, shank),
            intervals: std::array::from_fn(|i| {
                AngleInterval::of_limits(signs[i] * joints[i].lower, signs[i] * joints[i].upper)
            }),
            knee,
            shank,
            signs,
        })
    }

    /// The solution within the limits that is nearest to `near`, if there is one.
    pub(crate) fn solve(
        &self,
        joints: &[LegJoint],
        root_from_sole: &Pose,
        near: &LegPositions,
    ) -> Option<LegPositions> {
        let rotation = self.axes_from_root
            * DMat3::from_quat(root_from_sole.rotation)
            * self.zero_rotation_inverse;
        let ankle = self.axes_from_root * (*root_from_sole * self.ankle_from_foot - self.hip);
        let foot_ankle = DVec3::new(
            rotation.x_axis.dot(ankle),
            rotation.y_axis.dot(ankle),
            rotation.z_axis.dot(ankle),
        );
        let rolls = self.ankle_rolls(foot_ankle)?;
        let mut best: Option<(f64, LegPositions)> = None;
        for knee in
            self.knees(ankle)?.into_iter().filter(|&knee| self.intervals[3].may_contain(knee))
        {
            for roll in rolls.into_iter().filter(|&roll| self.intervals[5].may_contain(roll)) {
                for branch in self.branches(&rotation, foot_ankle, knee, roll) {
                    self.consider(joints, &branch, near, &mut best);
                }
            }
        }
        best.map(|(_, positions)| positions)
    }

    /// Both knee rotations at which the ankle has its distance from the hip.
    fn knees(&self, ankle: DVec3) -> Option<[UnitRotation; 2]> {
        let KneeDistance { base, amplitude, phase } = self.knee_distance;
        let half_excess = 0.5 * (ankle.length_squared() - base);
        if half_excess.abs() > amplitude * (1.0 + REACH_ROUNDING) {
            return None;
        }
        let opening = UnitRotation::of_cosine((half_excess / amplitude).clamp(-1.0, 1.0));
        Some([phase.then(opening), phase.then(opening.inverse())])
    }

    /// Both ankle rolls at which the hip lies in the plane of the leg; `ankle` is the vector from
    /// hip to ankle in the foot's axes.
    fn ankle_rolls(&self, ankle: DVec3) -> Option<[UnitRotation; 2]> {
        let along = self.knee.y + self.shank.y;
        let amplitude = (ankle.y * ankle.y + ankle.z * ankle.z).sqrt();
        if along.abs() > amplitude || amplitude < GEOMETRY_TOLERANCE {
            return None;
        }
        let back = UnitRotation { sin: -ankle.z / amplitude, cos: ankle.y / amplitude };
        let opening = UnitRotation::of_cosine(along / amplitude);
        Some([back.then(opening), back.then(opening.inverse())])
    }

    /// Both full solutions for a knee rotation and an ankle roll.
    fn branches(
        &self,
        rotation: &DMat3,
        foot_ankle: DVec3,
        knee: UnitRotation,
        roll: UnitRotation,
    ) -> [Branch; 2] {
        let leg = self.knee + knee.about_y(self.shank);
        let foot_ankle_unrolled = roll.about_x(foot_ankle);
        let pitches = UnitRotation::in_proportion(
            foot_ankle_unrolled.z * leg.x - foot_ankle_unrolled.x * leg.z,
            foot_ankle_unrolled.z * leg.z + foot_ankle_unrolled.x * leg.x,
        );
        // Entries of the hip's rotation `rotation Rx(-roll) Ry(-pitches)`.
        let z_axis = roll.sin * rotation.y_axis + roll.cos * rotation.z_axis;
        let hip_y = roll.cos * rotation.y_axis - roll.sin * rotation.z_axis;
        let hip_xz = pitches.cos * rotation.x_axis.z + pitches.sin * z_axis.z;
        let hip_zz = pitches.cos * z_axis.z - pitches.sin * rotation.x_axis.z;
        let hip_roll =
            UnitRotation { sin: hip_y.z, cos: (hip_y.x * hip_y.x + hip_y.y * hip_y.y).sqrt() };
        let scale = 1.0 / hip_roll.cos.max(f64::MIN_POSITIVE);
        let yaw = UnitRotation { sin: -hip_y.x * scale, cos: hip_y.y * scale };
        let pitch = UnitRotation { sin: -hip_xz * scale, cos: hip_zz * scale };
        let ankle_pitch = pitches.then(knee.inverse());
        [
            [yaw, hip_roll, pitch, knee, ankle_pitch, roll],
            [yaw.opposite(), hip_roll.mirrored(), pitch.opposite(), knee, ankle_pitch, roll],
        ]
    }

    /// Replaces the best branch by this one if it is within the limits and nearer.
    fn consider(
        &self,
        joints: &[LegJoint],
        branch: &Branch,
        near: &LegPositions,
        best: &mut Option<(f64, LegPositions)>,
    ) {
        if !self.intervals.iter().zip(branch).all(|(interval, &angle)| interval.may_contain(angle))
        {
            return;
        }
        let angles: [f64; 6] = std::array::from_fn(|i| self.signs[i] * branch[i].angle());
        if !joints.iter().zip(&angles).all(|(joint, &angle)| joint.is_within_limits(angle)) {
            return;
        }
        let distance = near.iter().zip(&angles).map(|(a, b)| (a - b) * (a - b)).sum();
        if best.as_ref().is_none_or(|(least, _)| distance < *least) {
            *best = Some((distance, angles.iter().copied().collect()));
        }
    }
}

/// The sign of each joint's axis along z, x, y, y, y, x; `None` if one is not aligned so.
fn axis_signs(axes: &[DVec3; 6], root_from_axes: &DMat3) -> Option<[f64; 6]> {
    let expected = [root_from_axes.z_axis, root_from_axes.x_axis, root_from_axes.y_axis];
    let order = [0, 1, 2, 2, 2, 1];
    let mut signs = [0.0; 6];
    for ((sign, axis), index) in signs.iter_mut().zip(axes).zip(order) {
        let along = axis.dot(expected[index]);
        if axis.cross(expected[index]).length() > GEOMETRY_TOLERANCE {
            return None;
        }
        *sign = along.signum();
    }
    (axes[1].dot(axes[2]).abs() < GEOMETRY_TOLERANCE).then_some(signs)
}

/// The point where two axes intersect, if they do.
fn intersection(a: &LegJoint, b: &LegJoint) -> Option<DVec3> {
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
