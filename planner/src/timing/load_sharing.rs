//! How two feet share the load, for the feed-forward torques of double support.
//!
//! The second foot bears the share `l` of the force; both centres of pressure have the same offset
//! from the centres of their soles, which is that of the whole pressure from the point at `l`
//! between them. For equal parallel soles that reaches every wrench of both. `l` follows a schedule
//! so that a foot lands and leaves without load, within the shares for which both centres of
//! pressure stay inside and both legs bear their load. Where no share keeps one offset inside both
//! soles, as where the world supports a part of one, the feet exchange moments until each centre of
//! pressure is inside its own. On soles that are inclined against each other the feet exchange
//! forces first, and the shares are those that friction holds, too. All of it is continuous in time
//! where the shares are an interval.

use glam::{DVec2, DVec3};
use heapless::Vec as BoundedVec;
use surefoot_shared_types::message::Contact;

use crate::base::smooth_step::smooth_step;
use crate::geometry::polygon::outward_sides;
use crate::timing::force_exchange::{are_parallel, exchange_forces, friction_excess};
use crate::timing::path_point::PathSpan;
use crate::timing::support::{FootSupport, FootWrench, Support};

/// Share of the load on the second foot at both ends of a double support; `None` where the robot
/// stands before or after on both feet.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct LoadSchedule {
    /// At its beginning.
    pub start: Option<f64>,
    /// At its end.
    pub end: Option<f64>,
}

/// Part of a double support over which the load moves away from the schedule's ends.
const HANDOVER: f64 = 0.3;
/// Parts of the range of shares: from the fourth one on, shares so many parts from the wanted one
/// are tried to either side.
const SHARE_STEPS: u32 = 24;
const FIRST_STEP: u32 = 4;
/// Nearer ones are tried at the range over these powers of the ratio, from a 500th of it on: a foot
/// that has just landed on a narrow support bears a share only between narrow limits.
const NEAR_RATIO: f64 = 1.3;
const NEAR_POWERS: std::ops::RangeInclusive<i32> = 8..=24;
/// Halvings of the step between a share that is borne and one that is not.
const SHARE_HALVINGS: usize = 30;
/// How often the feet exchange moments, at most.
const EXCHANGES: usize = 12;
/// Rounds along the sides of a sole in which a point is moved inside.
const SIDE_ROUNDS: usize = 3;
/// Distance (m) of a centre of pressure beyond its sole that counts as a whole excess.
const BEYOND_UNIT: f64 = 0.01;
/// Such a distance (m) that does not count.
const BEYOND_MIN: f64 = 1e-4;
/// A force across a sole (N) that counts as none.
const NO_LOAD: f64 = 1e-9;

impl LoadSchedule {
    /// How a double support takes over the load: none on a foot that has just landed or will lift
    /// off. `spans` are those of the whole path, and `before` are the contacts on which the robot
    /// stands before them, if it moves there.
    pub fn beside(before: &[Contact], spans: &[PathSpan], span: usize) -> Self {
        let share_beside = |contacts: &[Contact]| match contacts {
            [single] => Some(f64::from(single.limb)),
            _ => None,
        };
        let contacts_before = match span.checked_sub(1) {
            Some(last) => spans[last].contacts.as_slice(),
            None => before,
        };
        let contacts_after = spans.get(span + 1).map_or(&[][..], |next| next.contacts.as_slice());
        Self { start: share_beside(contacts_before), end: share_beside(contacts_after) }
    }

    /// How far the load is away from the schedule's ends at `progress` (0 to 1): 0 where a foot has
    /// none, 1 in the middle.
    pub fn freedom(&self, progress: f64) -> f64 {
        let from =
            |end: Option<f64>, distance: f64| end.map_or(1.0, |_| smooth_step(distance / HANDOVER));
        from(self.start, progress) * from(self.end, 1.0 - progress)
    }

    /// The scheduled share at `progress` (0 to 1), where `free` is the share that balances best.
    fn share(&self, progress: f64, free: f64) -> f64 {
        let towards = |end: Option<f64>, distance: f64| match end {
            Some(end) => (end - free) * (1.0 - smooth_step(distance / HANDOVER)),
            None => 0.0,
        };
        free + towards(self.start, progress) + towards(self.end, 1.0 - progress)
    }
}

/// The wrench of each foot. `force` and `moment` about the world's origin are those of all;
/// `excess` is the largest ratio of a leg's torque to its limit under the wrenches of both feet.
pub fn share_load(
    support: &Support,
    (force, moment): (DVec3, DVec3),
    (schedule, progress): (&LoadSchedule, f64),
    excess: impl Fn(&[FootWrench; 2]) -> f64,
) -> BoundedVec<FootWrench, 2> {
    let [first, second] = support.feet.as_slice() else {
        let about = |foot: &FootSupport| moment - foot.center.cross(force);
        return support.feet.iter().map(|foot| (force, about(foot))).collect();
    };
    let feet = [first, second];
    let shared = SharedLoad::new(feet, (force, moment));
    let (low, high) = shared.range;
    let wanted = schedule.share(progress, shared.balanced);
    let wanted = if low <= high { wanted.clamp(low, high) } else { wanted };
    let wrenches = if low <= high && are_parallel(feet) {
        let excess_at = |share: f64| Excess::of_legs(excess(&shared.split(share)));
        shared.split(nearest_borne(wanted, shared.range, excess_at))
    } else {
        let excess_at = |share: f64| {
            let wrenches = shared.split_within(feet, share);
            let of_legs = excess(&wrenches).max(friction_excess(feet, &wrenches));
            Excess::of_legs(of_legs).and_beyond(feet, &wrenches)
        };
        shared.split_within(feet, nearest_borne(wanted, (0.0, 1.0), excess_at))
    };
    wrenches.into_iter().collect()
}

/// How far a share of the load is beyond what the feet bear.
#[derive(Debug, Clone, Copy, PartialEq)]
struct Excess {
    /// At most 1 where it is borne.
    largest: f64,
    /// The same with the centre of pressure of a foot counted by its part of the load. Where no
    /// share is borne, the one with the least is taken: a foot without load has no centre.
    by_load: f64,
}

impl Excess {
    /// Of the largest ratio of a leg's torque, or of a sole's friction, to its limit.
    fn of_legs(ratio: f64) -> Self {
        Self { largest: ratio, by_load: ratio }
    }

    /// The same and that of the centres of pressure beyond their soles: the farthest one, and the
    /// one whose distance times the foot's part of the load is largest.
    fn and_beyond(self, feet: [&FootSupport; 2], wrenches: &[FootWrench; 2]) -> Self {
        let press = [0, 1].map(|at| feet[at].axes.z_axis.dot(wrenches[at].0).max(NO_LOAD));
        let (mut farthest, mut by_load) = (0.0_f64, 0.0_f64);
        for at in 0..2 {
            let offset = pressure_offset(feet[at], wrenches[at].0, wrenches[at].1);
            let distance = offset.distance(nearest_within(feet[at], offset));
            if distance > BEYOND_MIN {
                farthest = farthest.max(distance);
                by_load = by_load.max(distance * (press[at] / (press[0] + press[1])));
            }
        }
        Self {
            largest: self.largest + farthest / BEYOND_UNIT,
            by_load: self.by_load + by_load / BEYOND_UNIT,
        }
    }
}

/// The share nearest to `wanted` within a range that is borne; the one with the least excess where
/// there is none.
fn nearest_borne(wanted: f64, (low, high): (f64, f64), excess: impl Fn(f64) -> Excess) -> f64 {
    let at_once = excess(wanted);
    if at_once.largest <= 1.0 {
        return wanted;
    }
    let mut least = (at_once.by_load, wanted);
    let mut nearer = 0.0;
    let range = high - low;
    let near = NEAR_POWERS.rev().map(|power| range / libm::pow(NEAR_RATIO, f64::from(power)));
    let step = range / f64::from(SHARE_STEPS);
    let far = (FIRST_STEP..=SHARE_STEPS).map(|count| f64::from(count) * step);
    for distance in near.chain(far) {
        for side in [-1.0, 1.0] {
            let share = wanted + side * distance;
            if !(low..=high).contains(&share) {
                continue;
            }
            let found = excess(share);
            if found.largest <= 1.0 {
                return borne_between(wanted + side * nearer, share, excess);
            }
            least = if found.by_load < least.0 { (found.by_load, share) } else { least };
        }
        nearer = distance;
    }
    least.1
}

/// The share next to `beyond`, which is not borne, that is borne as `borne` is.
fn borne_between(mut beyond: f64, mut borne: f64, excess: impl Fn(f64) -> Excess) -> f64 {
    for _ in 0..SHARE_HALVINGS {
        let middle = 0.5 * (beyond + borne);
        if excess(middle).largest <= 1.0 { borne = middle } else { beyond = middle }
    }
    borne
}

/// A load that two feet share.
struct SharedLoad {
    force: DVec3,
    /// The moment about the centre of each foot, N m.
    moments: [DVec3; 2],
    /// The least and the largest share on the second foot for which both centres of pressure are
    /// inside; the least exceeds the largest where there is none.
    range: (f64, f64),
    /// The share that balances best.
    balanced: f64,
}

impl SharedLoad {
    /// `force` and `moment` about the world's origin are those of all.
    fn new([first, second]: [&FootSupport; 2], (force, moment): (DVec3, DVec3)) -> Self {
        let moments = [first, second].map(|foot| moment - foot.center.cross(force));
        let range = [first, second].map(|foot| shares_within(foot, force, moments));
        Self {
            force,
            moments,
            range: (range[0].0.max(range[1].0), range[0].1.min(range[1].1)),
            balanced: balanced_share(first, force, moments),
        }
    }

    /// The wrenches of both feet at a share of the second one.
    fn split(&self, share: f64) -> [FootWrench; 2] {
        let moment = self.moments[0] * (1.0 - share) + self.moments[1] * share;
        [1.0 - share, share].map(|part| (self.force * part, moment * part))
    }

    /// The wrenches of both feet at a share of the second one, after they have exchanged forces and
    /// each centre of pressure is moved into its sole, as far as the other one allows.
    fn split_within(&self, feet: [&FootSupport; 2], share: f64) -> [FootWrench; 2] {
        let mut wrenches = exchange_forces(feet, self.split(share));
        for round in 0..EXCHANGES {
            let at = round % 2;
            let (force, moment) = wrenches[at];
            let offset = pressure_offset(feet[at], force, moment);
            let change = nearest_within(feet[at], offset) - offset;
            let press = (feet[at].axes.transpose() * force).z;
            let given = feet[at].axes * DVec3::new(change.y * press, -change.x * press, 0.0);
            wrenches[at].1 += given;
            wrenches[1 - at].1 -= given;
        }
        wrenches
    }
}

/// The offset within a sole that is nearest to another one, or near to it at a corner.
fn nearest_within(foot: &FootSupport, mut offset: DVec2) -> DVec2 {
    for _ in 0..SIDE_ROUNDS {
        for (normal, side) in outward_sides(&foot.polygon) {
            offset -= normal * (normal.dot(offset) - side).max(0.0);
        }
    }
    offset
}

/// Wrenches of both feet that add up to that of all, for a few shares of the load for which both
/// centres of pressure are inside. `load` is the force of all, and the moment about the world's
/// origin.
pub(crate) fn splits(
    feet: [&FootSupport; 2],
    load: (DVec3, DVec3),
) -> impl Iterator<Item = [FootWrench; 2]> {
    let shared = SharedLoad::new(feet, load);
    let (low, high) = shared.range;
    let (low, high) = if low > high && low <= high + SHARE_ROUNDING {
        let middle = (0.5 * (low + high)).clamp(0.0, 1.0);
        (middle, middle)
    } else {
        (low, high)
    };
    let free = shared.balanced.clamp(low, high.max(low));
    let between = [0.5, 0.25, 0.75, 0.0, 1.0].map(|part| low + (high - low) * part);
    let count = match high - low {
        width if width > SHARE_ROUNDING => 1 + between.len(),
        width if width >= 0.0 => 1,
        _ => 0,
    };
    [free].into_iter().chain(between).take(count).map(move |share| shared.split(share))
}

/// How far apart by rounding the least and the largest share may be.
const SHARE_ROUNDING: f64 = 1e-6;

/// The offset of the centre of pressure in the axes of a sole, m.
fn pressure_offset(foot: &FootSupport, force: DVec3, moment: DVec3) -> DVec2 {
    let axes = foot.axes.transpose();
    let (force, moment) = (axes * force, axes * moment);
    DVec2::new(-moment.y, moment.x) / force.z.max(NO_LOAD)
}

/// The share for which the offset is least, 0 to 1.
fn balanced_share(foot: &FootSupport, force: DVec3, moments: [DVec3; 2]) -> f64 {
    let [a, b] = moments.map(|moment| pressure_offset(foot, force, moment));
    let along = b - a;
    let length_squared = along.length_squared();
    if length_squared < 1e-12 { 0.5 } else { (-a.dot(along) / length_squared).clamp(0.0, 1.0) }
}

/// The least and the largest share for which the offset is within a sole.
fn shares_within(foot: &FootSupport, force: DVec3, moments: [DVec3; 2]) -> (f64, f64) {
    let [a, b] = moments.map(|moment| pressure_offset(foot, force, moment));
    let (mut low, mut high) = (0.0_f64, 1.0_f64);
    for (normal, offset) in outward_sides(&foot.polygon) {
        let (depth, slope) = (offset - normal.dot(a), normal.dot(b - a));
        if slope > 1e-12 {
            high = high.min(depth / slope);
        } else if slope < -1e-12 {
            low = low.max(depth / slope);
        } else if depth < 0.0 {
            high = f64::NEG_INFINITY;
        }
    }
    (low, high)
}

#[cfg(test)]
mod tests {
    use surefoot_shared_types::message::SupportMode;

    use super::*;
    use crate::constraints::foothold::Ground;
    use crate::timing::friction_pyramid::FrictionPyramid;

    /// A level foot that is supported over this half of its width.
    fn foot(limb: usize, y: f64, half: f64) -> FootSupport {
        FootSupport {
            limb,
            center: DVec3::new(0.0, y, 0.0),
            polygon: [(-0.1, -half), (0.1, -half), (0.1, half), (-0.1, half)]
                .map(DVec2::from)
                .into_iter()
                .collect(),
            twist_arm: 0.1,
            axes: glam::DMat3::IDENTITY,
            friction: FrictionPyramid::with_four_sides(0.6),
        }
    }

    #[test]
    fn the_nearest_share_that_the_legs_bear_is_taken() {
        // The first leg bears at most 0.6 of the load, the second one at most 0.7.
        let excess = |share: f64| Excess::of_legs(((1.0 - share) / 0.6).max(share / 0.7));
        let range = (0.1, 0.9);
        assert_eq!(nearest_borne(0.5, range, excess), 0.5);
        assert!((nearest_borne(0.1, range, excess) - 0.4).abs() < 1e-8);
        assert!((nearest_borne(0.9, range, excess) - 0.7).abs() < 1e-8);
        let too_weak = |share: f64| Excess::of_legs(1.0 + (share - 0.3).abs());
        assert!((nearest_borne(0.8, range, too_weak) - 0.3).abs() < 0.04);
    }

    #[test]
    fn a_share_that_is_borne_between_narrow_limits_is_found() {
        let narrow =
            |share: f64| Excess::of_legs(if (share - 0.02).abs() < 3e-3 { 0.5 } else { 9.0 });
        let found = nearest_borne(0.0, (0.0, 1.0), narrow);
        assert!((found - 0.017).abs() < 1e-8, "{found}");
    }

    #[test]
    fn where_no_share_is_borne_a_foot_without_load_stays_without() {
        // Both supports are narrow, and the pressure is 3 mm beyond the one of the first foot,
        // towards neither. No share has both centres of pressure inside.
        let [first, second] = [foot(0, 0.1, 0.01), foot(1, -0.1, 0.002)];
        let force = DVec3::new(0.0, 0.0, 600.0);
        let moment = DVec3::new(0.113 * 600.0, 0.0, 0.0);
        let support = Support { feet: [first, second].into_iter().collect() };
        let schedule = LoadSchedule { start: Some(0.0), end: None };
        let shared = share_load(&support, (force, moment), (&schedule, 0.0), |_| 0.5);
        assert!(shared[1].0.z < 0.03 * 600.0, "{shared:?}");
        assert!(shared[1].1.length() < 3.1e-3 * 600.0, "{shared:?}");
    }

    #[test]
    fn a_foot_lands_and_leaves_without_load_after_a_step_that_is_retraced_too() {
        let contact = |limb: u32| Contact { limb, ..bytemuck::Zeroable::zeroed() };
        let span = |limbs: &[u32]| PathSpan {
            first: 0,
            last: 1,
            starts_at_rest: false,
            support: SupportMode::Double,
            contacts: limbs.iter().map(|limb| contact(*limb)).collect(),
            grounds: [Ground::Even; 2],
        };
        let spans = [span(&[0, 1]), span(&[0]), span(&[0, 1])];
        let beside = |before: &[Contact], at| LoadSchedule::beside(before, &spans, at);
        let first = LoadSchedule { start: None, end: Some(0.0) };
        assert_eq!(beside(&[], 0), first);
        assert_eq!(beside(&[contact(0), contact(1)], 0), first);
        assert_eq!(beside(&[contact(1)], 0), LoadSchedule { start: Some(1.0), ..first });
        assert_eq!(beside(&[contact(1)], 2), LoadSchedule { start: Some(0.0), end: None });
    }

    #[test]
    fn feet_of_which_one_is_narrow_exchange_moments() {
        let (wide, narrow) = (foot(0, 0.1, 0.04), foot(1, -0.1, 0.002));
        // The pressure is at y = 0.12: 2 cm beyond the middle of the wide sole.
        let force = DVec3::new(0.0, 0.0, 600.0);
        let moment = DVec3::new(0.12 * 600.0, 0.0, 0.0);
        let shared = SharedLoad::new([&wide, &narrow], (force, moment));
        let wrenches = shared.split_within([&wide, &narrow], 0.08);
        let within = Excess::of_legs(0.0);
        assert_eq!(within.and_beyond([&wide, &narrow], &wrenches), within);
        let about =
            |(foot, (force, moment)): (&FootSupport, FootWrench)| moment + foot.center.cross(force);
        let sum: DVec3 = [&wide, &narrow].into_iter().zip(wrenches).map(about).sum();
        assert!(sum.distance(moment) < 1e-9, "{sum}");
        let [a, b] = [0, 1].map(|at| {
            let (force, moment) = wrenches[at];
            pressure_offset([&wide, &narrow][at], force, moment).y
        });
        assert!(a <= 0.04 + 1e-4 && b.abs() <= 0.002 + 1e-4, "{a} {b}");
    }
}
