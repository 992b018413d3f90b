//! The friction of the only stance sole: the force along it and the moment about its normal.
//!
//! Forces at the corners of a sole hold more of both than a stiff sole on stiff ground does: while
//! the load on it changes fast, it stands on a few points for milliseconds at a time. A sole that
//! turns by a milliradian in each step leads the robot away from its path: in MuJoCo by 14 cm on
//! 9 m for G1, whose soles are 7.5 cm wide. So friction counts as on two points across the sole,
//! half of its width from the centre of pressure, each of which bears half of the load. On a mesh
//! with corners near each other a sole stands on points nearer to each other for longer.

use glam::{DVec2, DVec3};

use crate::timing::limit::Limit;
use crate::timing::path_dynamics::{Affine, PathDynamics};
use crate::timing::rate_set::RateSet;
use crate::timing::support::Support;
use crate::timing::tuning::LIMITS_PART;

/// Keeps the rates within this friction. The moment is about the centre of pressure at rest.
pub(crate) fn clip(dynamics: &PathDynamics, support: &Support, rates: &mut RateSet) {
    let [foot] = support.feet.as_slice() else { return };
    let [across_x, across_y, press, about_x, about_y, about_z] =
        dynamics.wrench_along(&foot.axes, foot.center);
    let center = DVec2::new(-about_y.constant, about_x.constant) / press.constant;
    for turn in [1.0, -1.0].map(|sign| sign / foot.twist_arm) {
        for across in [DVec2::X, DVec2::NEG_X, DVec2::Y, DVec2::NEG_Y] {
            let sum = [
                (about_z, turn),
                (across_x, across.x + turn * center.y),
                (across_y, across.y - turn * center.x),
                (press, -LIMITS_PART * foot.friction.coefficient),
            ];
            let of = |part: fn(&Affine) -> DVec2| -> DVec2 {
                sum.iter().map(|(affine, weight)| part(affine) * *weight).sum()
            };
            let rest: f64 = sum.iter().map(|(affine, weight)| affine.constant * weight).sum();
            rates.clip(of(|affine| affine.slope), -rest, Limit::Friction);
        }
    }
}

/// What a force and a moment (about the world's origin) ask of this friction, over what it holds; 0
/// on two feet.
pub(crate) fn load(support: &Support, (force, moment): (DVec3, DVec3)) -> f64 {
    let [foot] = support.feet.as_slice() else { return 0.0 };
    let into_axes = foot.axes.transpose();
    let moment = into_axes * (moment - foot.center.cross(force));
    let force = into_axes * force;
    if force.z <= 0.0 {
        return 0.0;
    }
    let pressure = DVec2::new(-moment.y, moment.x) / force.z;
    let twist = moment.z - pressure.perp_dot(force.truncate());
    let across = force.truncate().abs().max_element();
    (across + twist.abs() / foot.twist_arm) / (foot.friction.coefficient * force.z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::inverse_dynamics::{GeneralizedForce, LinkFrames};
    use crate::timing::friction_pyramid::FrictionPyramid;
    use crate::timing::support::FootSupport;

    /// A level sole of 0.2 m x 0.08 m whose load rests 3 cm before its centre.
    fn case(twist_by_acceleration: f64) -> (Support, PathDynamics) {
        let corners = [(-0.1, -0.04), (0.1, -0.04), (0.1, 0.04), (-0.1, 0.04)];
        let foot = FootSupport {
            limb: 0,
            center: DVec3::ZERO,
            polygon: corners.map(DVec2::from).into_iter().collect(),
            twist_arm: 0.04,
            axes: glam::DMat3::IDENTITY,
            friction: FrictionPyramid::with_four_sides(0.5),
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
    fn a_force_at_the_centre_of_pressure_turns_nothing() {
        // The force along the sole acts at the centre of pressure, 3 cm before the centre: all of
        // 0.5 * 400 N is left to it, 10 N by unit of the squared speed.
        let (support, dynamics) = case(0.0);
        let mut rates = RateSet::within(1e6, 1.0);
        clip(&dynamics, &support, &mut rates);
        let fastest = rates.vertices().iter().map(|rate| rate.x).fold(0.0, f64::max);
        assert!((fastest - 20.0 * LIMITS_PART).abs() < 1e-6, "{fastest}");
        assert!((load(&support, dynamics.wrench_at(DVec2::new(20.0, 0.0))) - 1.0).abs() < 1e-9);
    }

    #[test]
    fn force_and_moment_share_the_friction() {
        let (support, dynamics) = case(0.0);
        let by = |speed: f64, twist: f64| {
            let (force, moment) = dynamics.wrench_at(DVec2::new(speed, 0.0));
            load(&support, (force, moment + DVec3::Z * twist))
        };
        assert!((by(0.0, 8.0) - 1.0).abs() < 1e-9 && (by(0.0, -4.0) - 0.5).abs() < 1e-9);
        assert!((by(10.0, -4.0) - 1.0).abs() < 1e-9);
    }
}
