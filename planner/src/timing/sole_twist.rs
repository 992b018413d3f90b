//! The moment about the normal of the only stance sole, which friction holds.
//!
//! Forces at the corners of a sole hold more of it than a stiff sole on stiff ground does: while
//! the load on it changes fast, it stands on a few points for milliseconds at a time. A sole that
//! turns by a milliradian in each step leads the robot away from its path: in MuJoCo by 14 cm on
//! 9 m for G1, whose soles are 7.5 cm wide. So friction counts as if it acted at half the width of
//! the sole: as on two points across it.

use glam::{DVec2, DVec3};

use crate::timing::limit::Limit;
use crate::timing::path_dynamics::{Affine, PathDynamics};
use crate::timing::rate_set::RateSet;
use crate::timing::support::{FootSupport, Support};
use crate::timing::tuning::{LIMITS_PART, TWIST_ARM_SHARE};

/// Keeps the rates for which the moment about the normal through the centre of pressure at rest is
/// within the limit.
pub(crate) fn clip(dynamics: &PathDynamics, support: &Support, rates: &mut RateSet) {
    let [foot] = support.feet.as_slice() else { return };
    let [across_x, across_y, press, about_x, about_y, about_z] =
        dynamics.wrench_along(&foot.axes, foot.center);
    let center = DVec2::new(-about_y.constant, about_x.constant) / press.constant;
    let limit = LIMITS_PART * radius_max(foot);
    for sign in [1.0, -1.0] {
        let sum = [
            (about_z, sign),
            (across_y, -sign * center.x),
            (across_x, sign * center.y),
            (press, -limit),
        ];
        let of = |part: fn(&Affine) -> DVec2| -> DVec2 {
            sum.iter().map(|(affine, weight)| part(affine) * *weight).sum()
        };
        let rest: f64 = sum.iter().map(|(affine, weight)| affine.constant * weight).sum();
        rates.clip(of(|affine| affine.slope), -rest, Limit::Friction);
    }
}

/// The moment of a force and a moment (about the world's origin) about the normal through the
/// centre of pressure, over its limit; 0 on two feet.
pub(crate) fn load(support: &Support, (force, moment): (DVec3, DVec3)) -> f64 {
    let [foot] = support.feet.as_slice() else { return 0.0 };
    let into_axes = foot.axes.transpose();
    let moment = into_axes * (moment - foot.center.cross(force));
    let force = into_axes * force;
    let pressure = DVec2::new(-moment.y, moment.x) / force.z;
    let twist = moment.z - pressure.perp_dot(force.truncate());
    if force.z > 0.0 { twist.abs() / (radius_max(foot) * force.z) } else { 0.0 }
}

/// Largest ratio of the moment to the force across a sole, m.
fn radius_max(foot: &FootSupport) -> f64 {
    TWIST_ARM_SHARE * foot.width * foot.friction
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::inverse_dynamics::{GeneralizedForce, LinkFrames};

    /// A level sole of 0.2 m x 0.08 m whose load rests 3 cm before its centre.
    fn case(twist_by_acceleration: f64) -> (Support, PathDynamics) {
        let corners = [(-0.1, -0.04), (0.1, -0.04), (0.1, 0.04), (-0.1, 0.04)];
        let foot = FootSupport {
            limb: 0,
            center: DVec3::ZERO,
            polygon: corners.map(DVec2::from).into_iter().collect(),
            width: 0.08,
            axes: glam::DMat3::IDENTITY,
            friction: 0.5,
        };
        let torques = [0.0; surefoot_shared_types::base::limits::JOINTS_MAX];
        let effort = |force, moment| GeneralizedForce { force, moment, torques };
        let dynamics = PathDynamics {
            frames: LinkFrames::default(),
            by_acceleration: effort(DVec3::ZERO, DVec3::Z * twist_by_acceleration),
            by_speed: effort(DVec3::Y * 10.0, DVec3::Z * 0.3),
            standing: effort(DVec3::Z * 400.0, DVec3::NEG_Y * 12.0),
            origin: DVec3::ZERO,
        };
        (Support { feet: [foot].into_iter().collect() }, dynamics)
    }

    #[test]
    fn a_moment_of_friction_at_half_the_width_bounds_the_rates() {
        // 0.5 * 400 N at 4 cm hold 8 N m.
        let (support, dynamics) = case(4.0);
        let mut rates = RateSet::within(1.0, 100.0);
        clip(&dynamics, &support, &mut rates);
        let [low, high] = rates.accelerations_at(0.0).unwrap();
        let most = 2.0 * LIMITS_PART;
        assert!((high - most).abs() < 1e-9 && (low + most).abs() < 1e-9, "{low} {high}");
    }

    #[test]
    fn a_force_at_the_centre_of_pressure_twists_nothing() {
        // The force across the sole acts at the centre of pressure, 3 cm before the centre.
        let (support, dynamics) = case(0.0);
        let mut rates = RateSet::within(1e6, 1.0);
        clip(&dynamics, &support, &mut rates);
        assert!(rates.vertices().iter().any(|rate| rate.x > 0.9e6));
        assert!(load(&support, dynamics.wrench_at(DVec2::new(1e3, 0.0))) < 1e-9);
        let twisted = dynamics.wrench_at(DVec2::ZERO);
        let by = |twist: f64| (twisted.0, twisted.1 + DVec3::Z * twist);
        assert!((load(&support, by(8.0)) - 1.0).abs() < 1e-9);
        assert!((load(&support, by(-4.0)) - 0.5).abs() < 1e-9);
    }
}
