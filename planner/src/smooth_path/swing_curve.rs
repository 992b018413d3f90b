//! The curve of a swing sole from one foothold to the next: along the normal of the first, up,
//! across, down, and along the normal of the second. It rests at both ends.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_from_scaled_axis, scaled_axis_from_rotation};

use crate::base::smooth_step::smooth_step;
use crate::smooth_path::tuning::NORMAL_LIFT;

/// Share of the lift that goes along the sole's normal; the rest goes straight up.
const NORMAL_SHARE: f64 = 0.5;
/// Length of the sole's lift, as a share of the time up to the middle of the swing.
const LIFT_TIME: f64 = 0.45;

/// A swing from one pose of the sole to another.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SwingCurve {
    from: Pose,
    to: Pose,
    /// Height (m) of the sole above the higher end in the middle of the swing.
    lift: f64,
    /// Share of the swing at both ends in which the sole hardly moves across.
    aside: f64,
}

impl SwingCurve {
    /// The curve between two poses of the sole.
    pub fn new(from: Pose, to: Pose, lift: f64, aside: f64) -> Self {
        Self { from, to, lift, aside: aside.max(NORMAL_LIFT) }
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
        Pose::from_parts(begin.lerp(end, across), rotation.normalize())
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
        from.truncate().distance(to.truncate()) + 2.0 * top - from.z - to.z
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
        let swing = SwingCurve::new(from, to, 0.05, 0.1);
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
        let swing = SwingCurve::new(from, to, 0.08, 0.15);
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
}
