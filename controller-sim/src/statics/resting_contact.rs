//! The part of a sole on which a rigid foot can hold the weight.
//!
//! A foot rests where the air between its underside and the ground is least. A point with more air
//! carries only after the foot has tilted towards it, and with the foot the robot tilts: its centre
//! of mass moves by its height times the tilt. With the tilt `r` towards the direction `e`, the
//! foot stands on the point `x` with the least `air - r x.e`, and holds all centres of mass up to
//! `x.e - height r` along `e`. The best tilt of a list counts, so no more is counted than one of
//! them holds. The foot may tilt to the side of the direction as well, by a milliradian at most,
//! and the support is less by as much motion: three points that are not quite level all carry.

use glam::DVec2;

use crate::geometry::polygon;
use crate::statics::tuning::{
    CONTACT_POINTS_MAX, EVEN_AIR_MAX, REST_BISECTIONS, REST_DIRECTIONS, REST_SIDE_OFF_MAX,
    REST_SIDE_TILTS, REST_TILT_MIN, REST_TILT_STEP, REST_TILTS, TOUCH_GAP_MAX,
};

/// The air under a point of the sole.
#[derive(Debug, Clone, Copy)]
pub(crate) struct AirSample {
    /// In the sole frame, m.
    pub(crate) at: DVec2,
    /// The distance from the underside of the foot down to the ground, m; negative where they
    /// overlap.
    pub(crate) air: f64,
    /// Whether the ground there can carry.
    pub(crate) is_carrying: bool,
}

/// The part of the sole over which a centre of mass at `height` (m) may be, counter-clockwise;
/// fewer than three vertices where there is none.
pub(crate) fn resting_region(samples: &[AirSample], height: f64) -> Vec<DVec2> {
    let least = samples.iter().map(|sample| sample.air).fold(f64::INFINITY, f64::min);
    let touching: Vec<AirSample> =
        samples.iter().copied().filter(|sample| sample.air <= least + TOUCH_GAP_MAX).collect();
    let carrying: Vec<DVec2> =
        touching.iter().filter(|sample| sample.is_carrying).map(|sample| sample.at).collect();
    let hull = polygon::hull(&carrying);
    let kept = polygon::outermost_vertices(&hull, CONTACT_POINTS_MAX);
    let region: Vec<DVec2> = kept.into_iter().map(|index| hull[index]).collect();
    let is_level = |sample: &AirSample| sample.is_carrying && sample.air <= least + EVEN_AIR_MAX;
    if touching.iter().all(is_level) {
        return region;
    }
    let touching = lowest(touching);
    let reach = |along: DVec2| Reach::new(&touching, along, height);
    let mut reaches = around(&reach);
    reaches.extend(outward(&region).map(reach));
    // The sides between the places that hold in these directions.
    let held: Vec<DVec2> = reaches.iter().filter_map(|reach| reach.at).collect();
    let held = polygon::hull(&held);
    let between: Vec<Reach> = outward(&held).map(reach).collect();
    let clipped = reaches
        .iter()
        .chain(&between)
        .fold(region, |region, reach| polygon::clip(&region, reach.direction, reach.distance));
    polygon::hull(&clipped)
}

/// The reaches in all directions: the more of them, the farther apart the points are on which the
/// foot stands in two that follow each other. Between these points lies a side of the region.
fn around(reach: &impl Fn(DVec2) -> Reach) -> Vec<Reach> {
    let mut found: Vec<Reach> =
        (0..REST_DIRECTIONS).map(|k| reach(polygon::direction(k, REST_DIRECTIONS))).collect();
    for _ in 0..REST_BISECTIONS {
        let count = found.len();
        let mut finer: Vec<Reach> = Vec::with_capacity(2 * count);
        for (index, one) in found.iter().enumerate() {
            let next = &found[(index + 1) % count];
            finer.push(*one);
            if one.is_far_from(next) {
                finer.push(reach((one.direction + next.direction).normalize_or_zero()));
            }
        }
        if finer.len() == count {
            break;
        }
        found = finer;
    }
    found
}

/// The outward normals of a polygon's sides.
fn outward(polygon: &[DVec2]) -> impl Iterator<Item = DVec2> + '_ {
    polygon::sides(polygon).filter_map(|(a, b)| (-(b - a).perp()).try_normalize())
}

/// The samples on which some tilt lets the foot stand, and some others: of the samples on a line
/// along y or x only the corners of the lower hull of their air can be.
fn lowest(samples: Vec<AirSample>) -> Vec<AirSample> {
    let of_columns = lower_hulls(samples, |at| [at.x, at.y]);
    lower_hulls(of_columns, |at| [at.y, at.x])
}

/// The corners of the lower hulls of the air along all lines. `split` gives a place's line and its
/// place on it.
fn lower_hulls(mut samples: Vec<AirSample>, split: fn(DVec2) -> [f64; 2]) -> Vec<AirSample> {
    samples.sort_by(|a, b| {
        let ([line, at], [other_line, other_at]) = (split(a.at), split(b.at));
        line.total_cmp(&other_line).then(at.total_cmp(&other_at))
    });
    let mut kept: Vec<AirSample> = Vec::new();
    let mut first = 0;
    for sample in samples {
        if kept.last().is_some_and(|last| split(last.at)[0] != split(sample.at)[0]) {
            first = kept.len();
        }
        while let [.., from, middle] = kept[first..] {
            let [from_at, middle_at, at] = [from, middle, sample].map(|point| split(point.at)[1]);
            let is_above = (middle.air - from.air) * (at - from_at)
                >= (sample.air - from.air) * (middle_at - from_at);
            if !is_above {
                break;
            }
            kept.pop();
        }
        kept.push(sample);
    }
    kept
}

/// How far along a direction a centre of mass may be.
#[derive(Clone, Copy)]
struct Reach {
    direction: DVec2,
    /// In metres; minus infinity where nothing carries.
    distance: f64,
    /// A place as far as that.
    at: Option<DVec2>,
    /// The point on which the foot stands then.
    stands_on: Option<DVec2>,
}

impl Reach {
    /// The reach along a direction: the best of those with the foot tilted to either side a little,
    /// so that it stands on all of three points. The robot moves as far to that side.
    fn new(touching: &[AirSample], direction: DVec2, height: f64) -> Self {
        let nothing = Self { direction, distance: f64::NEG_INFINITY, at: None, stands_on: None };
        let along: Vec<f64> = touching.iter().map(|sample| sample.at.dot(direction)).collect();
        let last = along.iter().copied().fold(f64::NEG_INFINITY, f64::max);
        REST_SIDE_TILTS.iter().fold(nothing, |best, side_tilt| {
            if last - height * side_tilt.abs() <= best.distance {
                return best;
            }
            let sideways = *side_tilt * direction.perp();
            let air = |sample: &AirSample| sample.air - sideways.dot(sample.at);
            let air: Vec<f64> = touching.iter().map(air).collect();
            best.or_tilted((touching, &air, &along), last, height, side_tilt.abs())
        })
    }

    /// This one, or one that is farther: that of a foot with this `air` (m) under some points, as
    /// far `along` the direction (m), the `last` one farthest. It is tilted sideways by `side_tilt`
    /// (rad).
    fn or_tilted(
        mut self,
        (touching, air, along): (&[AirSample], &[f64], &[f64]),
        last: f64,
        height: f64,
        side_tilt: f64,
    ) -> Self {
        for step in 0..=REST_TILTS {
            let tilt = REST_TILT_MIN.max(REST_TILT_STEP * f64::from(step));
            let moved = height * (tilt + side_tilt);
            if last - moved <= self.distance {
                break;
            }
            let mut lowest = (f64::INFINITY, 0);
            for (index, (air, along)) in air.iter().zip(along).enumerate() {
                let air = air - tilt * along;
                if air < lowest.0 {
                    lowest = (air, index);
                }
            }
            let Some(stood_on) = touching.get(lowest.1) else { break };
            let distance = along[lowest.1] - moved;
            if lowest.0.is_finite() && stood_on.is_carrying && distance > self.distance {
                self.distance = distance;
                self.at = Some(stood_on.at - moved * self.direction);
                self.stands_on = Some(stood_on.at);
            }
        }
        self
    }

    /// Whether the foot stands on another point than in a direction beside this one, so that the
    /// side between both may lie too far off.
    fn is_far_from(&self, other: &Self) -> bool {
        let half_angle = 0.5 * self.direction.perp_dot(other.direction).abs();
        match (self.stands_on, other.stands_on) {
            (Some(one), Some(other)) => one.distance(other) * half_angle > REST_SIDE_OFF_MAX,
            (None, None) => false,
            _ => true,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEIGHT: f64 = 0.8;

    /// A sole of 0.2 m by 0.1 m over ground `air(x, y)` below it.
    fn over(air: impl Fn(DVec2) -> Option<f64>) -> Vec<AirSample> {
        let grid = (0..=200).flat_map(|x| (0..=100).map(move |y| (x, y)));
        grid.map(|(x, y)| 1e-3 * DVec2::new(f64::from(x) - 100.0, f64::from(y) - 50.0))
            .filter_map(|at| Some(AirSample { at, air: air(at)?, is_carrying: true }))
            .collect()
    }

    fn extent(region: &[DVec2]) -> [f64; 2] {
        region.iter().fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], at| {
            [low.min(at.x), high.max(at.x)]
        })
    }

    #[test]
    fn level_ground_carries_the_whole_sole() {
        let [low, high] = extent(&resting_region(&over(|_| Some(0.002)), HEIGHT));
        assert!((low + 0.1).abs() < 2e-5 && (high - 0.1).abs() < 2e-5, "{low} {high}");
    }

    #[test]
    fn a_log_lower_than_the_centre_of_mass_carries_nothing_and_a_flat_hill_most() {
        let round = |radius: f64| over(move |at| Some(at.x * at.x / (2.0 * radius)));
        // Of the log the grid of 1 mm leaves less than half a millimetre to either side.
        assert!(polygon::area(&resting_region(&round(0.5), HEIGHT)) < 1e-4);
        // The foot stands at radius x tilt, the centre of mass moves height x tilt.
        let [low, high] = extent(&resting_region(&round(8.0), HEIGHT));
        // Up to the end of the sole, at a tilt of 12.5 mrad.
        let wanted = (8.0 - HEIGHT) * 0.0125;
        assert!((high - wanted).abs() < 1e-3 && (low + wanted).abs() < 1e-3, "{low} {high}");
    }

    #[test]
    fn a_tilted_sole_rests_on_the_edge_that_touches() {
        let tilted = |degrees: f64| {
            let slope = libm::tan(degrees.to_radians());
            over(move |at| (at.x.abs() < 0.033).then_some(slope * at.x))
        };
        assert!(polygon::area(&resting_region(&tilted(4.9), HEIGHT)) < 1e-6);
        // At half a degree it tilts by 8.7 mrad to stand on all of the beam.
        let [low, high] = extent(&resting_region(&tilted(0.5), HEIGHT));
        let wanted = 0.032 - HEIGHT * 9e-3;
        assert!((high - wanted).abs() < 1e-4 && (low + 0.032).abs() < 1e-4, "{low} {high}");
    }

    #[test]
    fn two_bars_carry_from_line_to_line() {
        let bar = |x: f64, middle: f64| (x - middle) * (x - middle) / 0.04;
        let air = over(|at| Some(bar(at.x, -0.06).min(bar(at.x, 0.07))));
        let [low, high] = extent(&resting_region(&air, HEIGHT));
        assert!((low + 0.06).abs() < 1e-3 && (high - 0.07).abs() < 1e-3, "{low} {high}");
    }

    #[test]
    fn a_bar_and_a_post_carry_what_lies_between_them() {
        // A bar under one end of the sole, turned between two of the directions, and a post.
        for turned in [11.0, -11.0, 191.0] {
            let along = DVec2::from_angle(f64::to_radians(turned));
            let post = -0.05 * along;
            let air = |at: DVec2| {
                let (bar, beside) = (at.dot(along) - 0.05, at.distance(post));
                (bar * bar).min(beside * beside) / 0.04
            };
            let region = resting_region(&over(|at| Some(air(at))), HEIGHT);
            let furthest = region.iter().map(|at| at.dot(along)).fold(f64::NEG_INFINITY, f64::max);
            assert!((furthest - 0.05).abs() < 1e-3, "{turned}: {furthest}");
            let nearest = region.iter().map(|at| at.dot(along)).fold(f64::INFINITY, f64::min);
            assert!((nearest + 0.05).abs() < 2e-3, "{turned}: {nearest}");
            // The sides from the post lead to the ends of the bar.
            let ends = over(|at| ((at.dot(along) - 0.05).abs() < 5e-4).then_some(0.0));
            let ends = polygon::hull(&ends.iter().map(|end| end.at).collect::<Vec<_>>());
            let triangle = polygon::hull(&[ends, vec![post]].concat());
            let beyond = region.iter().map(|at| -polygon::margin(&triangle, *at));
            let beyond = beyond.fold(f64::NEG_INFINITY, f64::max);
            assert!(beyond < 2e-3, "{turned}: {beyond}");
            let (found, whole) = (polygon::area(&region), polygon::area(&triangle));
            assert!(found > 0.9 * whole, "{turned}: {found} {whole}");
        }
    }

    #[test]
    fn a_rib_tips_the_foot_and_one_that_cannot_carry_leaves_nothing() {
        let mut samples = over(|_| Some(1e-3));
        assert!(polygon::area(&resting_region(&samples, HEIGHT)) > 0.0199);
        let is_rib = |sample: &&mut AirSample| sample.at.x.abs() < 1.5e-3;
        samples.iter_mut().filter(is_rib).for_each(|rib| rib.air = 0.0);
        let [low, high] = extent(&resting_region(&samples, HEIGHT));
        // 1 mm over 99 mm: 10.1 mrad.
        let wanted = 0.1 - HEIGHT * 10.5e-3;
        assert!((high - wanted).abs() < 1e-4 && (low + wanted).abs() < 1e-4, "{low} {high}");
        samples.iter_mut().filter(is_rib).for_each(|rib| rib.is_carrying = false);
        assert!(resting_region(&samples, HEIGHT).len() < 3);
    }

    #[test]
    fn the_lowest_samples_hold_as_much_as_all() {
        let air = |at: DVec2| 2e-3 * libm::sin(40.0 * at.x + 55.0 * at.y) * libm::cos(30.0 * at.y);
        let samples = over(|at| Some(air(at)));
        let kept = lowest(samples.clone());
        assert!(kept.len() * 5 < samples.len(), "{} of {}", kept.len(), samples.len());
        for k in 0..48 {
            let direction = polygon::direction(k, 48);
            let [all, few] = [&samples, &kept].map(|of| Reach::new(of, direction, 0.1).distance);
            assert!((all - few).abs() < 1e-12, "{k}: {all} {few}");
        }
    }

    #[test]
    fn three_peaks_carry_what_lies_between_them_whatever_their_directions() {
        for turned in 0..12 {
            let turn = DVec2::from_angle(0.13 * f64::from(turned));
            let peaks = [(0.045, -0.03), (0.03, 0.035), (-0.045, 0.005)];
            let peaks = peaks.map(|(x, y)| turn.rotate(DVec2::new(x, y)));
            // Around each of them the ground falls by 30 mrad, more than a resting foot tilts.
            let nearest =
                |at: DVec2| peaks.map(|peak| at.distance(peak)).into_iter().reduce(f64::min);
            let samples = over(|at| Some(0.03 * nearest(at)?));
            let region = resting_region(&samples, HEIGHT);
            let beyond = region.iter().map(|at| -polygon::margin(&polygon::hull(&peaks), *at));
            let beyond = beyond.fold(f64::NEG_INFINITY, f64::max);
            assert!(beyond < 1.5e-3, "{turned}: {beyond}");
            assert!(polygon::area(&region) > 0.8 * polygon::area(&polygon::hull(&peaks)));
        }
    }

    #[test]
    fn nothing_and_lines_carry_nothing() {
        assert!(resting_region(&[], HEIGHT).len() < 3);
        let line = over(|at| (at.x == 0.0).then_some(0.0));
        assert!(!line.is_empty() && polygon::area(&resting_region(&line, HEIGHT)) < 1e-6);
        let nowhere = over(|_| Some(f64::NAN));
        assert!(polygon::area(&resting_region(&nowhere, HEIGHT)) < 1e-6);
    }
}
