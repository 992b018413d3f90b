//! Contact forces of one stance foot in closed form: a share of the force at three corners around
//! the centre of pressure, and a turn about it for the moment about the sole's normal.

use glam::{DVec2, DVec3};

use crate::geometry::polygon::cross;
use crate::timing::support::FootSupport;

/// How far the share of a corner may be below 0 by rounding: of a sole, less than 1 um.
const SHARE_ROUNDING: f64 = 1e-6;
/// Rounding of the corners of a rectangle, m.
const SIDES_ROUNDING: f64 = 1e-9;
/// Least mean squared distance (m2) of the corners from the centre of pressure that bears a moment.
const SPREAD_MIN: f64 = 1e-9;

/// Whether these forces bear a wrench: a force (N) and a moment about the foot's centre (N m).
/// Where they do not, others may.
pub(crate) fn holds(foot: &FootSupport, force: DVec3, moment: DVec3) -> bool {
    let (force, moment) = (foot.axes.transpose() * force, foot.axes.transpose() * moment);
    if force.z <= 0.0 {
        return false;
    }
    let pressure = DVec2::new(-moment.y, moment.x) / force.z;
    let turning = moment.z - pressure.perp_dot(force.truncate());
    let Some(corners) = corners_around(&foot.polygon, pressure) else { return false };
    let arms = corners.map(|(share, corner)| (share, corner - pressure));
    let spread: f64 = arms.iter().map(|(share, arm)| share * arm.length_squared()).sum();
    if spread < SPREAD_MIN {
        return false;
    }
    arms.iter().all(|(share, arm)| {
        let tangent = force.truncate() + arm.perp() * (turning / spread);
        *share == 0.0 || foot.friction.holds(tangent, force.z)
    })
}

/// Whether any forces at the corners of a foot whose polygon is a rectangle along its axes bear a
/// wrench: a force (N) and a moment about the foot's centre (N m), by friction along both axes
/// [Caron et al. 2015]. Not known of other polygons.
pub(crate) fn rectangle_holds(foot: &FootSupport, force: DVec3, moment: DVec3) -> bool {
    let Some(half) = half_sides(&foot.polygon) else { return false };
    let (force, moment) = (foot.axes.transpose() * force, foot.axes.transpose() * moment);
    let friction = foot.friction.along_axes();
    let twist_max = friction * (half.x + half.y) * force.z;
    let used = |sign: f64| {
        let along = half.y * force.x - sign * friction * moment.x;
        let across = half.x * force.y - sign * friction * moment.y;
        along.abs() + across.abs() - sign * moment.z
    };
    force.z > 0.0
        && force.truncate().abs().max_element() <= friction * force.z
        && moment.x.abs() <= half.y * force.z
        && moment.y.abs() <= half.x * force.z
        && used(1.0).max(used(-1.0)) <= twist_max
}

/// Half of the sides of a rectangle along the axes whose middle is the origin.
fn half_sides(polygon: &[DVec2]) -> Option<DVec2> {
    let [first, ..] = *polygon else { return None };
    let half = first.abs();
    let is_corner = |corner: &DVec2| (corner.abs() - half).abs().max_element() <= SIDES_ROUNDING;
    (polygon.len() == 4 && polygon.iter().all(is_corner)).then_some(half)
}

/// Three corners of a convex polygon (counter-clockwise) around a point, with the shares of which
/// the point is the mean.
fn corners_around(polygon: &[DVec2], at: DVec2) -> Option<[(f64, DVec2); 3]> {
    let first = *polygon.first()?;
    polygon[1..].windows(2).find_map(|pair| {
        let corners = [first, pair[0], pair[1]];
        let area = cross(corners[0], corners[1], corners[2]);
        let shares = [0, 1, 2]
            .map(|index| cross(corners[(index + 1) % 3], corners[(index + 2) % 3], at) / area);
        let is_inside = area > 0.0 && shares.iter().all(|share| *share >= -SHARE_ROUNDING);
        is_inside.then(|| [0, 1, 2].map(|index| (shares[index].max(0.0), corners[index])))
    })
}
