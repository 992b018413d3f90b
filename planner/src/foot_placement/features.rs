//! Gathering the features near the ideal of a query: surface elements that may support a sole.

use parry3d_f64::bounding_volume::Aabb;

use crate::foot_placement::request::PlacementQuery;
use crate::foot_placement::scratch::Scratch;
use crate::foot_placement::surfaces::Surfaces;
use crate::foot_placement::tuning::GATHERING_STEPS;

/// Lists the nearest features within reach that may support a sole, nearest first.
pub(crate) fn gather(surfaces: &Surfaces, scratch: &mut Scratch, query: &PlacementQuery) {
    for step in (0..GATHERING_STEPS).rev() {
        scratch.features.clear();
        gather_in(surfaces, scratch, query, &query.region(1.0 / f64::from(1 << step)));
        if scratch.features.len() >= surfaces.config().features_max {
            break;
        }
    }
}

fn gather_in(surfaces: &Surfaces, scratch: &mut Scratch, query: &PlacementQuery, region: &Aabb) {
    for (count, id) in surfaces.elements_in(region).enumerate() {
        if count >= surfaces.config().support_elements_max {
            scratch.features.count_dropped();
            break;
        }
        if !surfaces.may_carry(id) {
            continue;
        }
        list_feature(surfaces, scratch, query, id);
    }
    keep_nearest(scratch, surfaces.config().features_max);
}

/// Lists a feature by its distance from the ideal. Of too many only the nearest stay.
pub(crate) fn list_feature(
    surfaces: &Surfaces,
    scratch: &mut Scratch,
    query: &PlacementQuery,
    id: u32,
) {
    if scratch.features.is_full() {
        keep_nearest(scratch, surfaces.config().features_max);
    }
    let ideal = query.ideal.translation;
    let (aside, height) = surfaces.distance_and_height(id, ideal.truncate());
    scratch.features.push((aside + (height - ideal.z).abs(), id));
}

/// Sorts the listed features by distance and keeps the `count` nearest.
pub(crate) fn keep_nearest(scratch: &mut Scratch, count: usize) {
    scratch.features.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
    scratch.features.truncate(count);
}
