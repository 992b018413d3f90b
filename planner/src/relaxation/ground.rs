//! The ground of the relaxed problem: the voxels that surfaces may touch on which a sole can stand.

use glam::{DVec2, DVec3};

use crate::foot_placement::Surfaces;
use crate::geometry::bvh::Aabb;
use crate::relaxation::grid::{Grid, LEVELS};
use crate::relaxation::tuning::{COLUMNS_PER_ELEMENT, TOLERANCE};

/// The bounding box of the elements from `first` on, at most `count`, that may carry a sole.
pub(crate) fn bounds_of(surfaces: &Surfaces, first: u32, count: u32) -> Aabb {
    let last = (first + count).min(surfaces.element_count());
    let carrying = (first..last).filter(|&id| surfaces.may_carry(id));
    carrying.map(|id| surfaces.bounds(id)).fold(Aabb::EMPTY, Aabb::union)
}

/// Adds the voxels that an element may touch to the ground, if a sole may touch it. Returns its
/// size, as the number of small elements that cost as much.
///
/// A column is touched if its rectangle comes within the element's outline; the heights there are
/// those of the element at the point nearest to the column's centre, and as much higher or lower as
/// the steepest ground rises between two points of a column.
pub(crate) fn add_element(surfaces: &Surfaces, grid: &Grid, ground: &mut [u64], id: u32) -> usize {
    if !surfaces.may_bear(id) {
        return 1;
    }
    let bounds = surfaces.bounds(id);
    let reach = DVec2::splat(0.5 * grid.cell).length() + surfaces.radius(id);
    let rise = 2.0 * reach * surfaces.steepest_tan() + surfaces.radius(id);
    let is_small = (bounds.max - bounds.min).truncate().max_element() <= grid.cell;
    let mut count = 0;
    for column in grid.columns_in(bounds.min.truncate(), bounds.max.truncate()) {
        count += 1;
        let mut heights = [bounds.min.z, bounds.max.z];
        if !is_small {
            let center = grid.center(column, 0).truncate();
            let (distance, height) = surfaces.distance_and_height(id, center);
            if distance > reach {
                continue;
            }
            heights = [heights[0].max(height - rise), heights[1].min(height + rise)];
        }
        ground[column] |= grid.levels_in(heights[0], heights[1]);
    }
    1 + count / COLUMNS_PER_ELEMENT
}

/// Calls `examine` with the heights of each element that may carry a sole, at its points at most
/// `reach` (m) from a column: the lowest and the highest.
pub(crate) fn for_each_height(
    surfaces: &Surfaces,
    grid: &Grid,
    (column, reach): (usize, f64),
    mut examine: impl FnMut([f64; 2]),
) {
    let place = grid.voxels(column, [0, LEVELS - 1]);
    let center = place.center().truncate();
    let half_diagonal = DVec2::splat(0.5 * grid.cell).length();
    surfaces.for_each_in(&place.grown(reach + TOLERANCE), |id| {
        let around = half_diagonal + reach + TOLERANCE + surfaces.radius(id);
        let (distance, height) = surfaces.distance_and_height(id, center);
        if !surfaces.may_carry(id) || distance > around {
            return;
        }
        let normal_z = surfaces.normal_z(id).clamp(surfaces.steepest_cos, 1.0);
        let slope = libm::sqrt(1.0 - normal_z * normal_z) / normal_z;
        let rise = 2.0 * around * slope + surfaces.radius(id);
        let bounds = surfaces.bounds(id);
        examine([bounds.min.z.max(height - rise), bounds.max.z.min(height + rise)]);
    });
}

/// The point of the ground in a box that is nearest to a point.
pub(crate) fn nearest_ground(surfaces: &Surfaces, region: &Aabb, from: DVec3) -> Option<DVec3> {
    let mut nearest: Option<DVec3> = None;
    surfaces.for_each_in(region, |id| {
        if surfaces.may_bear(id) {
            let point = surfaces.nearest_point(id, from.truncate());
            if nearest.is_none_or(|known| point.distance(from) < known.distance(from)) {
                nearest = Some(point);
            }
        }
    });
    nearest
}
