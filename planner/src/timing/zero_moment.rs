//! The zero-moment point of a motion keeps its distance to the edge of the support, as the
//! controller demands it: on the plane at the mean height of the soles, inside the hull of all
//! soles' supports.
//!
//! The forces of the contacts are known to exist without it. It is stricter where two soles stand
//! at different heights, and where a centre of pressure may come nearer to the edge of a sole.

use glam::{DVec2, DVec3};
use surefoot_shared_types::message::{Contact, PlanTime};

use crate::geometry::polygon::HalfPlane;
use crate::timing::ground::Ground;
use crate::timing::limit::Limit;
use crate::timing::limits::Level;
use crate::timing::path_dynamics::PathDynamics;
use crate::timing::rate_set::RateSet;
use crate::timing::support::FootWrench;
use crate::timing::tuning::{
    ZERO_MOMENT_BARE_SHARE, ZERO_MOMENT_DEPTH_SHARE, ZERO_MOMENT_PARTIAL_RESERVE,
    ZERO_MOMENT_RESERVE, ZERO_MOMENT_SHIFT_MIN, ZERO_MOMENT_SHIFT_SHARE,
};

/// The ground under the contacts of a span, and how far inside the zero-moment point stays.
#[derive(Debug)]
pub(crate) struct ContactGround {
    ground: Ground,
    /// The margin that the controller demands, m.
    checked: f64,
    /// Distance beyond that margin, m.
    reserve: f64,
}

/// The part of the ground on which the zero-moment point stays.
#[derive(Debug)]
pub(crate) struct ZeroMomentRegion<'a> {
    ground: &'a Ground,
    /// Distance to the edge of the ground's region, m.
    margin: f64,
    /// The margin that the controller demands, m.
    checked: f64,
}

/// The load on the ground of a span.
#[derive(Debug, Clone, Copy, Default)]
pub struct GroundLoad {
    /// Force on the robot, N.
    force: DVec3,
    /// Moment about the point of the ground's plane on the world's z axis, N m.
    moment: DVec3,
}

impl GroundLoad {
    /// The sum with `factor` times another one.
    pub fn plus(&self, other: &Self, factor: f64) -> Self {
        Self {
            force: self.force + other.force * factor,
            moment: self.moment + other.moment * factor,
        }
    }

    /// The load at `part` (0 to 1) of the way to another one.
    pub fn lerp(&self, other: &Self, part: f64) -> Self {
        Self {
            force: self.force + (other.force - self.force) * part,
            moment: self.moment.lerp(other.moment, part),
        }
    }
}

/// The load on the ground at an instant: at rest, by the square of the rate of plan time, and by
/// its change.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct BalanceBasis {
    /// At rest.
    pub at_rest: GroundLoad,
    /// Added by the square of the rate.
    pub by_square: GroundLoad,
    /// Added by the change of the rate (1/s).
    pub by_change: GroundLoad,
}

impl BalanceBasis {
    /// The load while plan time passes like this.
    pub fn moving(&self, at: &PlanTime) -> GroundLoad {
        self.at_rest.plus(&self.by_square, at.rate * at.rate).plus(&self.by_change, at.rate_change)
    }
}

/// The load on the ground at a point of a path: at rest, by unit of its squared speed, and by unit
/// of its acceleration.
#[derive(Debug, Clone, Copy, Default)]
pub struct BalanceTerms {
    at_rest: GroundLoad,
    by_speed: GroundLoad,
    by_acceleration: GroundLoad,
}

impl BalanceTerms {
    /// The terms at `part` (0 to 1) of the way to the next point. `inner` is the load by unit of
    /// squared speed at one and at two thirds of the way: the second derivatives of a path are
    /// cubic between its points.
    pub(crate) fn between(&self, next: &Self, inner: &[GroundLoad; 2], part: f64) -> Self {
        let rest = 1.0 - part;
        let (below, above) = (3.0 * part - 1.0, 3.0 * part - 2.0);
        let by_speed = GroundLoad::default()
            .plus(&self.by_speed, 0.5 * below * above * rest)
            .plus(&inner[0], -4.5 * part * above * rest)
            .plus(&inner[1], 4.5 * part * below * rest)
            .plus(&next.by_speed, 0.5 * part * below * above);
        Self {
            at_rest: self.at_rest.lerp(&next.at_rest, part),
            by_speed,
            by_acceleration: self.by_acceleration.lerp(&next.by_acceleration, part),
        }
    }

    /// The load of a motion with this speed and this acceleration along the path.
    pub(crate) fn at(&self, speed: f64, acceleration: f64) -> BalanceBasis {
        let by_square = GroundLoad::default().plus(&self.by_speed, speed * speed);
        BalanceBasis {
            at_rest: self.at_rest,
            by_square: by_square.plus(&self.by_acceleration, acceleration),
            by_change: GroundLoad::default().plus(&self.by_acceleration, speed),
        }
    }
}

impl ContactGround {
    /// The load at a point of a path.
    pub fn terms(&self, dynamics: &PathDynamics) -> BalanceTerms {
        let [at_rest, by_speed, by_acceleration] =
            [&dynamics.standing, &dynamics.by_speed, &dynamics.by_acceleration]
                .map(|effort| self.load((effort.force, effort.moment), dynamics.origin));
        BalanceTerms { at_rest, by_speed, by_acceleration }
    }

    /// The load of a wrench about a point (world, m).
    pub fn load(&self, (force, moment): (DVec3, DVec3), point: DVec3) -> GroundLoad {
        let arm = point - DVec3::Z * self.ground.height;
        GroundLoad { force, moment: moment + arm.cross(force) }
    }

    /// The force of a load (N) and its moment about the world's origin (N m).
    pub fn wrench(&self, load: &GroundLoad) -> FootWrench {
        let arm = DVec3::Z * self.ground.height;
        (load.force, load.moment + arm.cross(load.force))
    }

    /// The ground under these contacts. `checked` is the margin (m) that the controller demands,
    /// `is_partial`: whether the world supports only a part of a sole.
    pub fn new(contacts: &[Contact], checked: f64, is_partial: bool) -> Self {
        let ground = Ground::under(contacts);
        let depth = ground.region.margin(ground.region.centroid()).max(0.0);
        let wanted = if is_partial { ZERO_MOMENT_PARTIAL_RESERVE } else { ZERO_MOMENT_RESERVE };
        Self { ground, checked, reserve: wanted.min(ZERO_MOMENT_DEPTH_SHARE * depth) }
    }

    /// The region of a level, `extra` (m) further inside.
    pub fn region(&self, level: Level, extra: f64) -> ZeroMomentRegion<'_> {
        let share = match level {
            Level::Inclined | Level::Full | Level::Steep | Level::NarrowSole => 1.0,
            Level::Bare | Level::Unsupported => ZERO_MOMENT_BARE_SHARE,
        };
        let margin = self.checked + share * self.reserve + extra;
        ZeroMomentRegion { ground: &self.ground, margin, checked: self.checked }
    }
}

impl ZeroMomentRegion<'_> {
    /// Keeps the rates whose zero-moment point is inside, at a point of a path. A motion may move
    /// it by a little even where the configuration at rest is beyond.
    pub fn clip(&self, terms: &BalanceTerms, rates: &mut RateSet) {
        let BalanceTerms { at_rest, by_speed, by_acceleration } = terms;
        for side in self.ground.region.sides() {
            let [x, u, rest] =
                [by_speed, by_acceleration, at_rest].map(|load| self.excess(side, load));
            let spare = (-rest).max(self.shift(rest, at_rest.force.z));
            rates.clip(DVec2::new(x, u), spare, Limit::ZeroMoment);
        }
    }

    /// Whether the zero-moment point of a load is inside.
    pub fn contains(&self, load: &GroundLoad) -> bool {
        self.ground.region.sides().iter().all(|side| self.excess(side, load) <= 0.0)
    }

    /// Whether the zero-moment point of a load is inside, or at least not further beyond than a
    /// motion may move it. `at_rest` gives the load of the configuration at rest.
    pub fn holds(&self, moving: &GroundLoad, at_rest: impl FnOnce() -> GroundLoad) -> bool {
        if self.contains(moving) {
            return true;
        }
        let rest = at_rest();
        self.ground.region.sides().iter().all(|side| {
            let [moving, at_rest] = [moving, &rest].map(|load| self.excess(side, load));
            moving - at_rest <= (-at_rest).max(self.shift(at_rest, rest.force.z))
        })
    }

    /// How far any motion may move the zero-moment point towards a side, times the load. `rest` is
    /// its excess at rest.
    fn shift(&self, rest: f64, press: f64) -> f64 {
        let left = (self.margin - self.checked) * press - rest;
        (ZERO_MOMENT_SHIFT_MIN * press).min(ZERO_MOMENT_SHIFT_SHARE * left.max(0.0))
    }

    /// How far the zero-moment point of a load is beyond a side, times the load. The point is
    /// `(-m_y, m_x) / f_z`; inside, its depth is at least the margin.
    fn excess(&self, side: &HalfPlane, load: &GroundLoad) -> f64 {
        let limit = side.offset + self.margin;
        limit * load.force.z - side.normal.dot(DVec2::new(-load.moment.y, load.moment.x))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use surefoot_shared_types::message::SupportMode;

    use crate::geometry::convex_region::ConvexRegion;
    use crate::timing::contact_rates::soles_hold;
    use crate::timing::path_point::PathSpan;
    use crate::timing::support::Support;

    #[test]
    fn near_the_edge_a_motion_uses_a_part_of_what_the_controller_leaves() {
        let corners = [(-0.1, -0.05), (0.1, -0.05), (0.1, 0.05), (-0.1, 0.05)];
        let region = ConvexRegion::hull(corners.map(DVec2::from));
        let ground =
            ContactGround { ground: Ground { height: 0.0, region }, checked: 5e-3, reserve: 4e-3 };
        let region = ground.region(Level::Bare, 0.0);
        let load = |depth: f64| GroundLoad {
            force: 500.0 * DVec3::Z,
            moment: DVec3::Y * 500.0 * (depth - 0.1),
        };
        for (rest, least) in [(5.5e-3, 5.1e-3), (6.5e-3, 5.5e-3), (0.02, 7e-3)] {
            let holds = |depth: f64| region.holds(&load(depth), || load(rest));
            assert!(holds(least + 1e-6) && !holds(least - 1e-6), "{rest}");
            let mut rates = RateSet::within(1.0, 1.0);
            let by_acceleration = load(0.0).plus(&load(5e-3), -1.0);
            let terms = BalanceTerms { at_rest: load(rest), by_acceleration, ..Default::default() };
            region.clip(&terms, &mut rates);
            let [_, most] = rates.accelerations_at(0.0).unwrap();
            assert!((most - ((rest - least) / 5e-3).min(1.0)).abs() < 1e-9, "{rest} {most}");
        }
    }

    #[test]
    fn the_load_by_squared_speed_is_cubic_between_points() {
        let load = |of: f64| GroundLoad {
            force: DVec3::new(3.0, -1.0, 1.0) * of,
            moment: DVec3::new(-1.0, 2.0, 4.0) * of,
        };
        let cubic = |t: f64| load(3.0 - 2.0 * t + 5.0 * t * t - 7.0 * t * t * t);
        let terms = |t: f64| BalanceTerms {
            at_rest: load(t),
            by_speed: cubic(t),
            by_acceleration: load(2.0 - t),
        };
        let inner = [1.0, 2.0].map(|part| cubic(part / 3.0));
        for part in [0.0, 0.2, 0.5, 0.9, 1.0] {
            let found = terms(0.0).between(&terms(1.0), &inner, part);
            let expected = terms(part);
            for (a, b) in [
                (found.at_rest, expected.at_rest),
                (found.by_speed, expected.by_speed),
                (found.by_acceleration, expected.by_acceleration),
            ] {
                let off = a.plus(&b, -1.0);
                assert!(off.force.length() + off.moment.length() < 1e-12, "{part}: {a:?} {b:?}");
            }
        }
    }

    /// A step of H1-2 up a spiral: its stance soles with 19 cm between their heights.
    fn spiral_step() -> PathSpan {
        let corners = [
            [-0.0835, -0.0329],
            [-0.0759, -0.0405],
            [0.13319, -0.04032],
            [0.17132, -0.02196],
            [0.17132, 0.02196],
            [0.13155, 0.0405],
            [-0.07787, 0.04024],
            [-0.0835, 0.0329],
        ];
        let contact = |limb: u32, position: [f64; 3], [sin, cos]: [f64; 2]| {
            let mut contact: Contact = bytemuck::Zeroable::zeroed();
            (contact.limb, contact.position) = (limb, position);
            (contact.rotation, contact.polygon_len) = ([0.0, 0.0, sin, cos], corners.len() as u32);
            contact.polygon[..corners.len()].copy_from_slice(&corners);
            contact
        };
        let left = [-0.10687865975, 0.50874721527, 1.131429];
        let right = [0.24986517078, 0.5356868676, 0.942857];
        let contacts = [
            contact(0, left, [0.9531906198481629, 0.3023700418915128]),
            contact(1, right, [0.9808930888117418, 0.19454754771356206]),
        ];
        PathSpan {
            first: 0,
            last: 1,
            starts_at_rest: false,
            support: SupportMode::Double,
            contacts: contacts.into_iter().collect(),
            grounds: Default::default(),
        }
    }

    #[test]
    fn a_zero_moment_point_inside_is_not_enough_on_feet_at_different_heights() {
        let span = spiral_step();
        let ground = ContactGround::new(&span.contacts, 5e-3, false);
        let support = Support::new(&span, Level::Bare, 0.0, 0.6);
        let holds = |force: DVec3, moment: DVec3| {
            let load = ground.load((force, moment), DVec3::ZERO);
            assert!(ground.region(Level::Bare, 0.0).contains(&load));
            soles_hold(&support, ground.wrench(&load))
        };
        // While it brakes. A linear program finds no forces within friction, either.
        let force = DVec3::new(-168.844, 20.549, 647.617);
        assert!(!holds(force, DVec3::new(310.442, -377.087, 92.595)));
        // At rest between the feet.
        let at = DVec3::new(0.07, 0.52, 1.0);
        assert!(holds(650.0 * DVec3::Z, at.cross(650.0 * DVec3::Z)));
    }
}
