//! Rigid motions, rotations and angles. Trigonometry goes through `libm`, so that results do not
//! depend on the CPU.

use glam::{DQuat, DVec3};

/// A rigid motion: rotation, then translation (m). `a_from_b * b_from_c == a_from_c`.
pub type Pose = glamx::DPose3;

/// The rotation of URDF's roll, pitch, yaw (rad) about fixed axes: x, then y, then z.
pub fn rotation_from_rpy(roll: f64, pitch: f64, yaw: f64) -> DQuat {
    rotation_about(DVec3::Z, yaw) * rotation_about(DVec3::Y, pitch) * rotation_about(DVec3::X, roll)
}

/// The rotation by `angle` (rad) about the unit vector `axis`.
pub fn rotation_about(axis: DVec3, angle: f64) -> DQuat {
    let (sin, cos) = libm::sincos(0.5 * angle);
    DQuat::from_xyzw(axis.x * sin, axis.y * sin, axis.z * sin, cos)
}

/// The exponential map: the rotation by `|v|` rad about `v`.
pub fn rotation_from_scaled_axis(v: DVec3) -> DQuat {
    let angle = v.length();
    if angle < 1e-12 {
        return DQuat::from_xyzw(0.5 * v.x, 0.5 * v.y, 0.5 * v.z, 1.0).normalize();
    }
    rotation_about(v / angle, angle)
}

/// The logarithmic map: the axis of a rotation times its angle (rad, at most pi).
pub fn scaled_axis_from_rotation(q: DQuat) -> DVec3 {
    let q = if q.w < 0.0 { -q } else { q };
    let v = DVec3::new(q.x, q.y, q.z);
    let sin_half = v.length();
    if sin_half < 1e-12 {
        return 2.0 * v;
    }
    v * (2.0 * libm::atan2(sin_half, q.w) / sin_half)
}

/// The angle between two rotations (rad, 0 to pi).
pub fn rotation_distance(a: DQuat, b: DQuat) -> f64 {
    scaled_axis_from_rotation(a.conjugate() * b).length()
}

/// Spherical linear interpolation: the rotation at fraction `t` of the shortest arc from `a` to
/// `b`.
pub fn slerp(a: DQuat, b: DQuat, t: f64) -> DQuat {
    (a * rotation_from_scaled_axis(t * scaled_axis_from_rotation(a.conjugate() * b))).normalize()
}

/// The pose at fraction `t` between `a` and `b`: linear in position, [`slerp`] in rotation.
pub fn interpolate(a: &Pose, b: &Pose, t: f64) -> Pose {
    Pose::from_parts(
        a.translation + t * (b.translation - a.translation),
        slerp(a.rotation, b.rotation, t),
    )
}

/// The heading of a rotation: the angle of its x axis about the z axis (rad, -pi to pi).
pub fn yaw_of(q: DQuat) -> f64 {
    let x = q * DVec3::X;
    libm::atan2(x.y, x.x)
}

/// `angle` (rad) wrapped into -pi to pi.
pub fn wrap_angle(angle: f64) -> f64 {
    let turn = std::f64::consts::TAU;
    angle - turn * libm::floor(angle / turn + 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_logarithm_inverts_the_exponential() {
        for v in
            [DVec3::new(0.3, -1.2, 0.4), DVec3::new(1e-13, 0.0, 0.0), DVec3::new(0.0, 3.1, 0.0)]
        {
            assert!((scaled_axis_from_rotation(rotation_from_scaled_axis(v)) - v).length() < 1e-12);
        }
    }

    #[test]
    fn slerp_reaches_both_ends() {
        let a = rotation_from_rpy(0.1, -0.4, 2.0);
        let b = rotation_from_rpy(-0.3, 0.2, -2.5);
        assert!(rotation_distance(slerp(a, b, 0.0), a) < 1e-12);
        assert!(rotation_distance(slerp(a, b, 1.0), b) < 1e-12);
    }

    #[test]
    fn rpy_rotates_about_fixed_axes() {
        let q = rotation_from_rpy(std::f64::consts::FRAC_PI_2, 0.0, std::f64::consts::FRAC_PI_2);
        assert!((q * DVec3::Y - DVec3::Z).length() < 1e-12);
        assert!((q * DVec3::X - DVec3::Y).length() < 1e-12);
    }
}
