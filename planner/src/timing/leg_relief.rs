//! Forces and moments that two feet exchange where no share of the load spares the legs.
//!
//! Two feet that share a load with one offset of their centres of pressure leave five of the six
//! numbers of a foot's wrench unused. Where a leg would exert more than its limit, or a sole a
//! moment that its pressure or its friction does not, the wrench of the first foot is projected
//! onto one bound after the other: the torques of both legs, friction, and the supported parts of
//! both soles. That leads to wrenches within all bounds where there are any, and changes
//! continuously with where it begins.

use glam::{DVec2, DVec3};
use heapless::Vec as BoundedVec;
use surefoot_shared_types::base::limits::{JOINTS_MAX, POLYGON_VERTICES_MAX};

use crate::geometry::polygon::{edges, outward_sides};
use crate::timing::contact_rates::ContactProblem;
use crate::timing::force_exchange::friction_excess;
use crate::timing::friction_pyramid::EDGES_MAX;
use crate::timing::support::{FootSupport, FootWrench};
use crate::timing::tuning::{MOMENT_ARM, TORQUE_TOLERANCE};

/// Most bounds: by foot those of the sole's sides, its pressure, friction and twist, two by corner
/// of the sole, and two by joint.
const BOUNDS_MAX: usize = 2 * (6 * POLYGON_VERTICES_MAX + EDGES_MAX + 3) + 2 * JOINTS_MAX;
/// How often all bounds are gone through, at most.
const ROUNDS_MAX: usize = 150;
/// A bound that is exceeded by less, as a share of the load, holds.
const EXCEEDED_MIN: f64 = 1e-5;

/// Distance (m) of the centre of pressure of all the load beyond a sole that counts as none.
const BEYOND_MIN: f64 = 2e-4;
/// Arm (m) at which all the load would exert a moment about a corner that counts as none.
const TURN_MIN: f64 = 2e-3;

/// A bound on the wrench of the first foot: `force . f + moment . m <= most`, with its moment in
/// units of [`MOMENT_ARM`].
#[derive(Debug, Clone, Copy)]
struct Bound {
    force: DVec3,
    moment: DVec3,
    most: f64,
}

impl Bound {
    /// How much a wrench exceeds it, as a distance, N.
    fn excess(&self, (force, moment): FootWrench) -> f64 {
        let squared = self.force.length_squared() + self.moment.length_squared();
        let above = self.force.dot(force) + self.moment.dot(moment) - self.most;
        if squared > 0.0 { above / squared.sqrt() } else { 0.0 }
    }

    /// The nearest wrench within it of one that is `excess` (N) beyond.
    fn nearest(&self, (force, moment): FootWrench, excess: f64) -> FootWrench {
        let length = (self.force.length_squared() + self.moment.length_squared()).sqrt();
        let by = excess / length;
        (force - by * self.force, moment - by * self.moment)
    }
}

/// The wrenches of two feet after they have exchanged forces and moments, so that no torque of a
/// leg is beyond its limit at a rate along the path, and both soles exert them. Wrenches that are
/// so stay. `centers` are those about which moments are given; `problem` has the supports and the
/// efforts that count.
pub(crate) fn relieve_legs(
    problem: &ContactProblem<'_>,
    rate: DVec2,
    given: [FootWrench; 2],
    centers: [DVec3; 2],
) -> [FootWrench; 2] {
    let [first, second] = problem.support.feet.as_slice() else { return given };
    let feet = [first, second];
    let moved = |at: usize, (force, moment): FootWrench, sign: f64| {
        (force, moment + sign * (centers[at] - feet[at].center).cross(force))
    };
    let wrenches = [0, 1].map(|at| moved(at, given[at], 1.0));
    let pair = FootPair::new(feet, wrenches);
    let load = problem.leg_load(rate, &wrenches).max(friction_excess(feet, &wrenches));
    let is_held = [0, 1].into_iter().all(|at| {
        let beyond = |bounds: SoleBounds| moment_beyond(bounds, feet[at], wrenches[at]);
        beyond(side_bounds) <= BEYOND_MIN * pair.force.length()
            && beyond(turn_bounds) <= TURN_MIN * pair.force.length()
    });
    if load <= 1.0 + TORQUE_TOLERANCE && is_held {
        return given;
    }
    let bounds = all_bounds(problem, rate, feet, &pair);
    let start = pair.first(wrenches);
    let found = pair.wrenches(within(&bounds, start, EXCEEDED_MIN * pair.force.length()));
    [0, 1].map(|at| moved(at, found[at], -1.0))
}

/// The bounds of both legs and both soles.
fn all_bounds(
    problem: &ContactProblem<'_>,
    rate: DVec2,
    feet: [&FootSupport; 2],
    pair: &FootPair,
) -> BoundedVec<Bound, BOUNDS_MAX> {
    let mut bounds = BoundedVec::<Bound, BOUNDS_MAX>::new();
    for (at, foot) in feet.into_iter().enumerate() {
        leg_bounds(problem, rate, foot, &mut |force, moment, most| {
            let _fits = bounds.push(pair.bound(at, force, moment, most));
        });
    }
    for (at, foot) in feet.into_iter().enumerate() {
        sole_bounds(foot, &mut |force, moment| {
            let _fits = bounds.push(pair.bound(at, force, moment, 0.0));
        });
    }
    bounds
}

/// Calls back with the forces and moments of bounds `force . f + moment . m <= 0` on the wrench of
/// a foot.
type SoleBounds = fn(&FootSupport, &mut dyn FnMut(DVec3, DVec3));

/// The largest moment of a wrench beyond some bounds of a sole, N m.
fn moment_beyond(bounds: SoleBounds, foot: &FootSupport, (force, moment): FootWrench) -> f64 {
    let mut most = 0.0_f64;
    bounds(foot, &mut |by_force, by_moment| {
        most = most.max(by_force.dot(force) + by_moment.dot(moment));
    });
    most
}

/// A wrench of the first foot within the bounds, or near them where there is none.
fn within(bounds: &[Bound], mut wrench: FootWrench, exceeded_min: f64) -> FootWrench {
    for _ in 0..ROUNDS_MAX {
        let mut most = 0.0_f64;
        for bound in bounds {
            let excess = bound.excess(wrench);
            if excess > 0.0 {
                wrench = bound.nearest(wrench, excess);
                most = most.max(excess);
            }
        }
        if most <= exceeded_min {
            break;
        }
    }
    wrench
}

/// Two feet and what they bear together.
struct FootPair {
    /// From the centre of the first foot to that of the second one, m.
    arm: DVec3,
    /// N.
    force: DVec3,
    /// About the centre of the first foot, N m.
    moment: DVec3,
}

impl FootPair {
    fn new([first, second]: [&FootSupport; 2], wrenches: [FootWrench; 2]) -> Self {
        let arm = second.center - first.center;
        let [(of_first, about_first), (of_second, about_second)] = wrenches;
        let moment = about_first + about_second + arm.cross(of_second);
        Self { arm, force: of_first + of_second, moment }
    }

    /// The wrench of the first foot, its moment in units of [`MOMENT_ARM`].
    fn first(&self, [(force, moment), _]: [FootWrench; 2]) -> FootWrench {
        (force, moment / MOMENT_ARM)
    }

    /// The wrenches of both feet, each about its own centre.
    fn wrenches(&self, (force, moment): FootWrench) -> [FootWrench; 2] {
        let (moment, other) = (moment * MOMENT_ARM, self.force - force);
        [(force, moment), (other, self.moment - moment - self.arm.cross(other))]
    }

    /// The bound `force . f + moment . m <= most` on the wrench of a foot.
    fn bound(&self, foot: usize, force: DVec3, moment: DVec3, most: f64) -> Bound {
        if foot == 0 {
            return Bound { force, moment: moment * MOMENT_ARM, most };
        }
        let along = force - moment.cross(self.arm);
        let most = most - along.dot(self.force) - moment.dot(self.moment);
        Bound { force: -along, moment: moment * -MOMENT_ARM, most }
    }
}

/// The bounds of the torques of a leg.
fn leg_bounds(
    problem: &ContactProblem<'_>,
    rate: DVec2,
    foot: &FootSupport,
    add: &mut dyn FnMut(DVec3, DVec3, f64),
) {
    let frames = &problem.dynamics.frames;
    for &joint in &problem.chains[foot.limb] {
        let taken = |force, moment| frames.torque_of_wrench(joint, force, moment, foot.center);
        let force = DVec3::AXES.map(|axis| taken(axis, DVec3::ZERO)).into();
        let moment = DVec3::AXES.map(|axis| taken(DVec3::ZERO, axis)).into();
        let free = problem.dynamics.torque(joint).at(rate);
        let most = problem.efforts_part * problem.efforts[joint];
        add(force, moment, most + free);
        add(-force, -moment, most - free);
    }
}

/// The bounds of a sole, which hold for any part of a wrench within them.
fn sole_bounds(foot: &FootSupport, add: &mut dyn FnMut(DVec3, DVec3)) {
    let normal = foot.axes.z_axis;
    let twist = foot.friction.coefficient * foot.twist_arm;
    for (outward, offset) in foot.friction.sides() {
        add(foot.axes * outward.extend(-offset), DVec3::ZERO);
    }
    for sign in [1.0, -1.0] {
        add(-twist * normal, sign * normal);
    }
    side_bounds(foot, add);
    turn_bounds(foot, add);
    add(-normal, DVec3::ZERO);
}

/// The bounds of the moment that the pressure on a sole exerts: of a foot without load any moment
/// is beyond them.
fn side_bounds(foot: &FootSupport, add: &mut dyn FnMut(DVec3, DVec3)) {
    for (outward, offset) in outward_sides(&foot.polygon) {
        add(-offset * foot.axes.z_axis, foot.axes * DVec3::new(outward.y, -outward.x, 0.0));
    }
}

/// The bounds of the moment about each corner of a sole: friction exerts at most as much as the
/// pressure at its distance from the two sides there. On a rectangle these are the bounds that
/// forces at the corners have (Caron, Pham, Nakamura 2015: "Stability of surface contacts").
fn turn_bounds(foot: &FootSupport, add: &mut dyn FnMut(DVec3, DVec3)) {
    let tangent = foot.friction.along_axes();
    let normal = foot.axes.z_axis;
    let sides = outward_sides(&foot.polygon);
    let next = outward_sides(&foot.polygon).cycle().skip(1);
    let corners = edges(&foot.polygon).filter(|(a, b)| a.distance_squared(*b) > 0.0);
    for (((_, corner), a), b) in corners.zip(sides).zip(next) {
        let (outward, offset) = (a.0 + b.0, a.1 + b.1);
        let held_force = tangent * offset * normal;
        let held_moment = tangent * (foot.axes * DVec3::new(outward.y, -outward.x, 0.0));
        let about_corner = foot.axes * DVec3::new(corner.y, -corner.x, 0.0);
        for sign in [1.0, -1.0] {
            add(sign * about_corner - held_force, sign * normal + held_moment);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::{Random, Stream};
    use crate::timing::support::example_feet::{about_origin, tilted_foot};

    fn sole_excess(foot: &FootSupport, wrench: FootWrench) -> f64 {
        moment_beyond(sole_bounds, foot, wrench)
    }

    #[test]
    fn an_ankle_beyond_its_limit_leaves_load_to_the_other_foot() {
        // Both centres of pressure are 8 cm ahead; the ankle of the first foot, which bears nearly
        // all, holds 6 cm of it.
        let feet = [&tilted_foot(0, 0.1, 0.0), &tilted_foot(1, -0.1, 0.1)];
        let shared = [0.98, 0.02].map(|part| (600.0 * part * DVec3::Z, -48.0 * part * DVec3::Y));
        let pair = FootPair::new(feet, shared);
        let mut bounds = vec![pair.bound(0, DVec3::ZERO, -DVec3::Y, 36.0)];
        for (at, foot) in feet.into_iter().enumerate() {
            sole_bounds(foot, &mut |force, moment| bounds.push(pair.bound(at, force, moment, 0.0)));
        }
        let found = pair.wrenches(within(&bounds, pair.first(shared), 1e-3));
        let without_load = |foot| moment_beyond(side_bounds, foot, (DVec3::ZERO, DVec3::X));
        assert_eq!(feet.map(without_load), [1.0; 2]);
        assert!(-found[0].1.y <= 36.01 && found[1].0.z > 50.0, "{found:?}");
        for (foot, wrench) in feet.into_iter().zip(found) {
            assert!(sole_excess(foot, wrench) < 0.1, "{found:?}");
        }
        let [before, after] = [shared, found].map(|wrenches| about_origin(feet, wrenches));
        assert!(before.0.distance(after.0) + before.1.distance(after.1) < 1e-9);
    }

    /// The wrench of forces at the corners of a sole, each within the friction along both axes.
    fn wrench_of_corners(foot: &FootSupport, random: &mut Random) -> FootWrench {
        let tangent = foot.friction.along_axes();
        let mut sum = (DVec3::ZERO, DVec3::ZERO);
        for corner in &foot.polygon {
            let press = random.uniform(0.0, 300.0);
            let [x, y] = [(); 2].map(|()| random.uniform(-tangent, tangent) * press);
            let force = foot.axes * DVec3::new(x, y, press);
            sum.0 += force;
            sum.1 += (foot.axes * corner.extend(0.0)).cross(force);
        }
        sum
    }

    #[test]
    fn forces_at_the_corners_are_within_the_bounds_about_them() {
        let foot = tilted_foot(0, 0.1, 0.2);
        let mut random = Random::new(1, Stream::Preparation, 0, 0);
        for _ in 0..200 {
            let wrench = wrench_of_corners(&foot, &mut random);
            assert!(moment_beyond(turn_bounds, &foot, wrench) < 1e-9, "{wrench:?}");
            let turned = (wrench.0, wrench.1 + 200.0 * foot.axes.z_axis);
            assert!(moment_beyond(turn_bounds, &foot, turned) > 1.0, "no friction holds 200 N m");
        }
    }

    #[test]
    fn soles_that_bear_their_load_near_a_corner_turn_the_robot_by_opposite_forces() {
        // 25 N m about each foot, whose 450 N lie 1 cm from a corner: its friction holds 4 N m.
        let feet = [&tilted_foot(0, 0.15, 0.0), &tilted_foot(1, -0.15, 0.0)];
        let force = 450.0 * DVec3::Z;
        let moment = DVec3::new(-0.09, 0.045, 0.0).cross(force) + 25.0 * DVec3::Z;
        let shared = [(force, moment); 2];
        assert!(feet.iter().all(|foot| moment_beyond(turn_bounds, foot, (force, moment)) > 15.0));
        let pair = FootPair::new(feet, shared);
        let mut bounds = vec![];
        for (at, foot) in feet.into_iter().enumerate() {
            sole_bounds(foot, &mut |force, moment| bounds.push(pair.bound(at, force, moment, 0.0)));
        }
        let found = pair.wrenches(within(&bounds, pair.first(shared), 1e-3));
        assert!(found[0].0.x < -100.0 && found[1].0.x > 100.0, "{found:?}");
        for (foot, wrench) in feet.into_iter().zip(found) {
            assert!(sole_excess(foot, wrench) < 0.5, "{found:?}");
        }
        let [before, after] = [shared, found].map(|wrenches| about_origin(feet, wrenches));
        assert!(before.0.distance(after.0) + before.1.distance(after.1) < 1e-9);
    }

    #[test]
    fn a_bound_of_either_foot_is_that_of_its_own_wrench() {
        let feet = [&tilted_foot(0, 0.15, 0.3), &tilted_foot(1, -0.1, -0.2)];
        let wrenches = [
            (DVec3::new(30.0, -20.0, 400.0), DVec3::new(3.0, -5.0, 1.0)),
            (DVec3::new(-10.0, 25.0, 200.0), DVec3::new(-2.0, 4.0, 0.5)),
        ];
        let pair = FootPair::new(feet, wrenches);
        let (force, moment) = (DVec3::new(0.3, -0.2, 0.5), DVec3::new(2.0, 1.0, -3.0));
        for (at, (of_foot, about_foot)) in wrenches.into_iter().enumerate() {
            let most = force.dot(of_foot) + moment.dot(about_foot);
            let bound = pair.bound(at, force, moment, most);
            assert!(bound.excess(pair.first(wrenches)).abs() < 1e-9, "{at}");
            let back = pair.wrenches(pair.first(wrenches))[at];
            assert!(back.0.distance(of_foot) + back.1.distance(about_foot) < 1e-9, "{at}");
        }
    }
}
