//! Forces along the ground that two feet exchange, so that neither slides.
//!
//! Two feet that share a load in proportion exert parallel forces. On soles that are inclined
//! against each other, a force that one sole holds by friction may be beyond the cone of the other.
//! A force that one foot gains and the other one loses changes nothing for the robot, if the feet
//! also exchange the moment of the pair. The one is taken for which the forces along the soles, of
//! which each counts by its square over the force across the sole, are least. Without load on a
//! foot there is none.

use glam::{DVec2, DVec3};

use crate::timing::support::{FootSupport, FootWrench};

/// Distance from a sole's centre (m) at which friction holds a moment about its normal: that of the
/// corners of a small sole.
const TWIST_RADIUS: f64 = 0.08;
/// Sine of the angle between two soles up to which they are parallel.
const PARALLEL_MAX: f64 = 1e-6;

/// Whether two soles are parallel. Their forces are parallel then, too.
pub(crate) fn are_parallel(feet: [&FootSupport; 2]) -> bool {
    let [a, b] = feet.map(normal);
    a.cross(b).length() <= PARALLEL_MAX
}

/// The larger of the forces along the soles of two feet over what friction holds.
pub(crate) fn friction_excess(feet: [&FootSupport; 2], wrenches: &[FootWrench; 2]) -> f64 {
    let weight = (wrenches[0].0 + wrenches[1].0).length();
    let excess = |(foot, (force, _)): (&FootSupport, &FootWrench)| {
        let press = normal(foot).dot(*force).max(1e-9 * weight);
        along_sole(foot, *force).length() / (foot.friction.coefficient * press)
    };
    feet.into_iter().zip(wrenches).map(excess).fold(0.0, f64::max)
}

/// The wrenches of two feet after they have exchanged forces.
pub(crate) fn exchange_forces(
    feet: [&FootSupport; 2],
    wrenches: [FootWrench; 2],
) -> [FootWrench; 2] {
    let [(first, first_moment), (second, second_moment)] = wrenches;
    let press = [0, 1].map(|at| normal(feet[at]).dot(wrenches[at].0).max(0.0));
    let all = press[0] + press[1];
    if all <= 0.0 {
        return wrenches;
    }
    let arm = feet[0].center - feet[1].center;
    let along = |force: DVec3| {
        press[1] * along_sole(feet[0], force) + press[0] * along_sole(feet[1], force)
    };
    let rest = press[0] * along_sole(feet[1], second) - press[1] * along_sole(feet[0], first);

    let (u, v) = (first + second).normalize_or(DVec3::Z).any_orthonormal_pair();
    let twist = DVec2::new(arm.cross(u).z, arm.cross(v).z);
    let stiffness = press[0] * press[1] / (all * TWIST_RADIUS * TWIST_RADIUS);
    let (uu, vv, uv) = (
        u.dot(along(u)) + stiffness * twist.x * twist.x,
        v.dot(along(v)) + stiffness * twist.y * twist.y,
        u.dot(along(v)) + stiffness * twist.x * twist.y,
    );
    let determinant = uu * vv - uv * uv;
    if determinant <= 0.0 {
        return wrenches;
    }
    let right = DVec2::new(u.dot(rest), v.dot(rest));
    let given =
        (u * (vv * right.x - uv * right.y) + v * (uu * right.y - uv * right.x)) / determinant;
    let moment = arm.cross(given);
    [
        (first + given, first_moment - moment * (press[0] / all)),
        (second - given, second_moment - moment * (press[1] / all)),
    ]
}

fn normal(foot: &FootSupport) -> DVec3 {
    foot.axes.z_axis
}

/// The part of a force along the sole of a foot.
fn along_sole(foot: &FootSupport, force: DVec3) -> DVec3 {
    force - normal(foot) * normal(foot).dot(force)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::timing::support::example_feet::{about_origin, tilted_foot};

    #[test]
    fn feet_on_opposite_slopes_push_against_each_other() {
        // Each slope falls towards the other foot by 0.5 rad, and the robot accelerates sideways:
        // parallel forces are beyond the cone of one foot, which holds 0.54 rad.
        let feet = [&tilted_foot(0, 0.15, 0.5), &tilted_foot(1, -0.15, -0.5)];
        let force = DVec3::new(0.0, 80.0, 600.0);
        let shared = [0.4, 0.6].map(|share| (force * share, DVec3::new(0.0, 3.0, 1.0) * share));
        assert!(friction_excess(feet, &shared) > 1.0);
        let exchanged = exchange_forces(feet, shared);
        assert!(friction_excess(feet, &exchanged) < 0.6);
        let (before, after) = (about_origin(feet, shared), about_origin(feet, exchanged));
        assert!(before.0.distance(after.0) + before.1.distance(after.1) < 1e-9);
    }

    #[test]
    fn without_load_or_slope_nothing_is_exchanged() {
        let force = DVec3::new(20.0, 30.0, 600.0);
        let at = |share: f64| [1.0 - share, share].map(|part| (force * part, DVec3::X * part));
        let level = [&tilted_foot(0, 0.1, 0.0), &tilted_foot(1, -0.1, 0.0)];
        let tilted = [&tilted_foot(0, 0.1, 0.3), &tilted_foot(1, -0.1, 0.0)];
        assert!(are_parallel(level) && !are_parallel(tilted));
        for (feet, share) in [(level, 0.3), (tilted, 0.0), (tilted, 1.0)] {
            for (a, b) in at(share).iter().zip(exchange_forces(feet, at(share))) {
                assert!(a.0.distance(b.0) + a.1.distance(b.1) < 1e-9);
            }
        }
    }
}
