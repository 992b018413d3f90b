//! Half planes of rates that no contact forces within friction and soles leave: where all soles lie
//! in one plane, the centre of pressure is inside their hull, and the force is within the friction
//! of the most favourable sole.

use glam::{DVec2, DVec3};
use heapless::Vec as BoundedVec;
use surefoot_shared_types::base::limits::POLYGON_VERTICES_MAX;

use crate::geometry::convex_region::ConvexRegion;
use crate::geometry::polygon::outward_sides;
use crate::timing::limit::Limit;
use crate::timing::path_dynamics::{Affine, PathDynamics};
use crate::timing::rate_set::RateSet;
use crate::timing::support::{FootSupport, Support};

/// Largest distance (m) of a sole's centre from the plane of another one in that plane.
const PLANE_DISTANCE_MAX: f64 = 1e-7;
/// Least cosine of the angle between the normals of two soles in one plane.
const NORMALS_COSINE_MIN: f64 = 1.0 - 1e-12;

/// Keeps the rates within these half planes.
pub(crate) fn clip(dynamics: &PathDynamics, support: &Support, rates: &mut RateSet) {
    let Some((first, others)) = support.feet.split_first() else { return };
    if !others.iter().all(|foot| lies_in_plane_of(first, foot)) {
        return;
    }
    let wrench = dynamics.wrench_along(&first.axes, first.center);
    let [across_x, across_y, press, about_x, about_y, _] = wrench;
    for (normal, offset) in pressure_sides(first, others) {
        let beyond = [(about_x, normal.y), (about_y, -normal.x), (press, -offset)];
        clip_by(rates, beyond, Limit::CentreOfPressure);
    }
    for (normal, _) in first.friction.sides() {
        let direction = first.axes * normal.extend(0.0);
        let limits = support.feet.iter().map(|foot| friction_along(foot, direction));
        let limit = limits.fold(0.0, f64::max);
        let beyond = [(across_x, normal.x), (across_y, normal.y), (press, -limit)];
        clip_by(rates, beyond, Limit::Friction);
    }
}

/// Keeps the rates for which a weighted sum is not positive.
fn clip_by(rates: &mut RateSet, sum: [(Affine, f64); 3], limit: Limit) {
    let slope: DVec2 = sum.iter().map(|(affine, weight)| affine.slope * *weight).sum();
    let constant: f64 = sum.iter().map(|(affine, weight)| affine.constant * weight).sum();
    rates.clip(slope, -constant, limit);
}

fn lies_in_plane_of(first: &FootSupport, foot: &FootSupport) -> bool {
    let normal = first.axes.z_axis;
    normal.dot(foot.axes.z_axis) >= NORMALS_COSINE_MIN
        && normal.dot(foot.center - first.center).abs() <= PLANE_DISTANCE_MAX
}

/// The sides of the hull of soles in one plane, in the frame of the first one: outward normals with
/// offsets.
fn pressure_sides(
    first: &FootSupport,
    others: &[FootSupport],
) -> BoundedVec<(DVec2, f64), { 4 * POLYGON_VERTICES_MAX }> {
    if others.is_empty() {
        return outward_sides(&first.polygon).collect();
    }
    let into_axes = first.axes.transpose();
    let corners_of = |foot: &FootSupport| {
        let shift = into_axes * (foot.center - first.center);
        let turn = into_axes * foot.axes;
        let corners = foot.polygon.clone();
        corners.into_iter().map(move |corner| (shift + turn * corner.extend(0.0)).truncate())
    };
    let hull = ConvexRegion::hull(others.iter().chain([first]).flat_map(corners_of));
    outward_sides(hull.vertices()).collect()
}

/// The largest part of the normal force along a direction in the plane of a sole.
fn friction_along(foot: &FootSupport, direction: DVec3) -> f64 {
    foot.friction.along((foot.axes.transpose() * direction).truncate())
}
