//! The curve of a swing sole from one foothold to the next: along the normal of the first, up,
//! across, down, and along the normal of the second. It rests at both ends.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{
    rotation_about, rotation_from_scaled_axis, scaled_axis_from_rotation,
};

use crate::base::smooth_step::smooth_step;
use crate::smooth_path::tuning::NORMAL_LIFT;

/// Share of the lift that goes along the sole's normal; the rest goes straight up.
const NORMAL_SHARE: f64 = 0.5;
/// Length of the sole's lift, as a share of the time up to the middle of the swing.
const LIFT_TIME: f64 = 0.45;
/// The fractions of a swing in which the sole lowers its front, and raises it again.
const ROLL_OFF: [[f64; 2]; 2] = [[0.07, 0.32], [0.45, 0.85]];

/// A swing from one pose of the sole to another.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SwingCurve {
    from: Pose,
    to: Pose,
    /// Height (m) of the sole above the higher end in the middle of the swing.
    lift: f64,
    /// Share of the swing at both ends in which the sole hardly moves across.
    aside: f64,
    roll_off: RollOff,
}

/// How the sole lowers its front after it has left the ground, about that front: an ankle
/// behind the body cannot turn a raised foot up to level.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub(crate) struct RollOff {
    /// Largest angle, rad.
    pub angle: f64,
    /// Distance (m) of the sole's front from its origin.
    pub front: f64,
}

impl SwingCurve {
    /// The curve between two poses of the sole.
    pub fn new(from: Pose, to: Pose, [lift, aside]: [f64; 2], roll_off: RollOff) -> Self {
        Self { from, to, lift, aside: aside.max(NORMAL_LIFT), roll_off }
    }

    /// The fraction of the way across at the fraction `t` of the swing.
    fn across(&self, t: f64) -> f64 {
        smooth_step((t - self.aside) / (1.0 - 2.0 * self.aside))
    }

    /// The pose of the sole at the fraction `t` of the swing; at its ends before 0 and after 1.
    pub fn pose(&self, t: f64) -> Pose {
        let [from, to] = [&self.from, &self.to];
        let top = from.translation.z.max(to.translation.z) + self.lift;
        let across = self.across(t);
        let begin = raised(from, top, t / LIFT_TIME);
        let end = raised(to, top, (1.0 - t) / LIFT_TIME);
        let turn = scaled_axis_from_rotation(from.rotation.conjugate() * to.rotation);
        let rotation = from.rotation * rotation_from_scaled_axis(across * turn);
        let sole = Pose::from_parts(begin.lerp(end, across), rotation.normalize());
        self.rolled_off(sole, t)
    }

    /// A sole at the fraction `t` with its front lowered.
    fn rolled_off(&self, sole: Pose, t: f64) -> Pose {
        let RollOff { angle, front } = self.roll_off;
        if angle == 0.0 {
            return sole;
        }
        let [up, down] = ROLL_OFF.map(|[begin, end]| smooth_step((t - begin) / (end - begin)));
        let turn = rotation_about(DVec3::Y, angle * up * (1.0 - down));
        let front = front * DVec3::X;
        let position = sole.translation + sole.rotation * (front - turn * front);
        Pose::from_parts(position, (sole.rotation * turn).normalize())
    }

    /// Horizontal distance (m) of the sole from the nearer end at the fraction `t`.
    pub fn distance_aside(&self, t: f64) -> f64 {
        let across = self.across(t);
        across.min(1.0 - across)
            * self.from.translation.truncate().distance(self.to.translation.truncate())
    }

    /// An upper bound of the length of the sole's way, m.
    pub fn length(&self) -> f64 {
        let [from, to] = [self.from.translation, self.to.translation];
        let top = from.z.max(to.z) + self.lift;
        let turned = 2.0 * self.roll_off.angle * self.roll_off.front;
        from.truncate().distance(to.truncate()) + 2.0 * top - from.z - to.z + turned
    }
}

/// The position of a sole that is raised toward the height `top` (m), at the fraction `t`: first
/// along its normal, then straight up.
fn raised(sole: &Pose, top: f64, t: f64) -> DVec3 {
    let rise = top - sole.translation.z;
    let along_normal = NORMAL_SHARE * rise.min(2.0 * NORMAL_RISE_MAX);
    let normal = sole.rotation * DVec3::Z;
    let upward = rise - along_normal * normal.z;
    sole.translation
        + normal * (along_normal * smooth_step(t))
        + DVec3::Z * (upward * smooth_step((t - UPWARD_AFTER) / (1.0 - UPWARD_AFTER)))
}

/// Share of the lift after which the sole also moves straight up.
const UPWARD_AFTER: f64 = 0.2;
/// Longest way along the normal, m.
const NORMAL_RISE_MAX: f64 = 0.03;

#[cfg(test)]
mod tests {
    use super::*;
    use surefoot_shared_types::base::spatial::rotation_from_rpy;

    #[test]
    fn a_swing_leaves_along_the_normal_and_lands_along_it() {
        let from = Pose::from_parts(DVec3::new(0.0, 0.1, 0.2), rotation_from_rpy(0.2, -0.1, 0.3));
        let to = Pose::from_parts(DVec3::new(0.4, 0.15, 0.1), rotation_from_rpy(0.0, 0.1, -0.3));
        let swing = SwingCurve::new(from, to, [0.05, 0.1], RollOff::default());
        assert!(swing.pose(0.0).translation.distance(from.translation) < 1e-12);
        assert!(swing.pose(1.0).translation.distance(to.translation) < 1e-12);
        for (end, at) in [(from, 0.01), (to, 0.99)] {
            let moved = swing.pose(at).translation - end.translation;
            let normal = end.rotation * DVec3::Z;
            assert!(moved.length() < 1e-4, "it rests at the end");
            assert!(moved.normalize().dot(normal) > 0.999, "{moved} along {normal}");
        }
        let top = swing.pose(0.5).translation.z;
        assert!((top - 0.25).abs() < 1e-3, "{top}");
        assert!(swing.distance_aside(0.1) < 1e-12 && swing.distance_aside(0.5) > 0.1);
    }

    #[test]
    fn its_derivatives_are_continuous() {
        let from = Pose::from_translation(DVec3::new(0.0, 0.1, 0.0));
        let to = Pose::from_translation(DVec3::new(0.5, 0.1, 0.1));
        let swing = SwingCurve::new(from, to, [0.08, 0.15], RollOff { angle: 0.5, front: 0.12 });
        let h = 1e-3;
        let bend = |t: f64| {
            let [a, b, c] = [t - h, t, t + h].map(|t| swing.pose(t).translation);
            (a - 2.0 * b + c) / (h * h)
        };
        let mut before = bend(-0.1);
        for index in -99..1100 {
            let here = bend(f64::from(index) * h);
            assert!((here - before).length() < 0.5, "at {index}: {here} after {before}");
            before = here;
        }
    }

    #[test]
    fn a_sole_rolls_off_over_its_front_and_lands_level() {
        let from = Pose::from_translation(DVec3::new(0.0, 0.1, 0.0));
        let to = Pose::from_translation(DVec3::new(0.5, 0.1, 0.0));
        let front = DVec3::new(0.12, 0.0, 0.0);
        let [level, rolled] = [0.0, 0.5]
            .map(|angle| SwingCurve::new(from, to, [0.05, 0.1], RollOff { angle, front: front.x }));
        for index in 0..=20 {
            let t = f64::from(index) / 20.0;
            let [level, rolled] = [level, rolled].map(|swing| swing.pose(t));
            assert!((level * front).distance(rolled * front) < 1e-12, "at {t}");
            assert!(rolled.translation.z >= level.translation.z, "at {t}");
        }
        let turned = rolled.pose(0.4).rotation.angle_between(from.rotation);
        assert!((turned - 0.5).abs() < 1e-12, "{turned}");
        assert!(rolled.pose(1.0).rotation.angle_between(to.rotation) < 1e-12);
    }
}
