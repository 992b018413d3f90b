//! Samples on the crests of curved ground, such as the top line of a bar.
//!
//! A crest lies between the points of the grid, now nearer to one and now to another, and a foot
//! seems to stand on the nearest ones. On the crest itself all samples have the same air.

use glam::DVec2;

use crate::statics::sole_support::ray_sample::RaySample;
use crate::statics::underside::{FineGrid, SolePoint};

/// Samples where the air is least between two neighbours on the grid. `fine` are the samples of the
/// grid points `indices`. The foot may be beside a crest as far as beside a point of the grid, and
/// misses as much of it there.
pub(super) fn crests(
    grid: &FineGrid,
    indices: &[usize],
    fine: &[RaySample],
    sample: impl Fn(SolePoint) -> RaySample,
) -> Vec<RaySample> {
    let outermost = grid.outermost_offsets();
    let mut found = Vec::new();
    for (index, one) in indices.iter().zip(fine) {
        for next in grid.next(*index) {
            let other = indices.binary_search(&next).ok().and_then(|place| fine.get(place));
            let Some(at) = other.and_then(|other| place_between(one, other)) else { continue };
            let height = one.point.height;
            let mut crest = sample(SolePoint { at, height });
            for offset in &outermost {
                let beside = sample(SolePoint { at: at + offset, height });
                crest.most_air = crest.most_air.max(beside.air);
            }
            found.push(crest);
        }
    }
    found
}

/// The place between two samples of a curved surface where it is level along the line through them
/// and falls to both sides. On a cylinder and a ball the sine of the inclination changes evenly.
fn place_between(one: &RaySample, other: &RaySample) -> Option<DVec2> {
    let way = other.point.at - one.point.at;
    let incline = |sample: &RaySample| {
        let gradient = sample.gradient;
        gradient.dot(way) / (way.length() * (1.0 + gradient.length_squared()).sqrt())
    };
    let (falls, rises) = (incline(one), incline(other));
    let is_same = one.is_round && other.is_round && one.point.height == other.point.height;
    (is_same && falls < 0.0 && rises > 0.0).then(|| one.point.at + way * (falls / (falls - rises)))
}
