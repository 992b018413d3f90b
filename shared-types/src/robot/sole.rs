//! Makes sure that a declared sole lies on the foot's own surface: a plan could otherwise claim
//! giant feet.

use glam::DVec3;
use parry3d_f64::query::PointQuery;
use parry3d_f64::shape::Triangle;

use crate::base::input_error::InputError;
use crate::geometry::convex_hull::hull_triangles;
use crate::geometry::shape::Shape;

use crate::robot::model::{Foot, Link};
use crate::robot::spec::FootSpec;
use crate::robot::surface_points::SurfacePoints;

/// How far a sole's corner may be from the surface of the foot's collision shapes, m.
const SOLE_GAP_MAX: f64 = 3e-3;
/// How far a sole may be below all of the foot's shapes, m: the controller refuses a smooth motion
/// whose feet meet the ground farther from where they are declared.
const SOLE_BELOW_MAX: f64 = 5e-4;

/// An error unless every corner of the sole lies on the surface of its link's own shapes.
pub(crate) fn check_sole(foot: &Foot, link: &Link, spec: &FootSpec) -> Result<(), InputError> {
    let input_error =
        |message: String| spec.location.error(format!("foot '{}'", foot.name), message);
    if link.shapes.is_empty() {
        return Err(input_error(format!(
            "its link '{}' has no collision shape (a sphere of radius 0 is none); add one, or list the link under visual_shapes",
            link.name
        )));
    }
    for corner in &foot.polygon {
        let point = foot.link_from_sole * corner.extend(0.0);
        let mut nearest = f64::INFINITY;
        for shape in &link.shapes {
            let local = shape.link_from_shape.inverse() * point;
            nearest = nearest.min(signed_distance(&shape.shape, local).map_err(input_error)?);
        }
        if nearest.abs() > SOLE_GAP_MAX {
            let side = if nearest > 0.0 { "off" } else { "inside" };
            return Err(input_error(format!(
                "sole corner [{}, {}] lies {:.1} mm {side} the collision shapes of link '{}'; at most {:.0} mm is allowed; 'surefoot robot add' finds soles",
                corner.x,
                corner.y,
                1e3 * nearest.abs(),
                link.name,
                1e3 * SOLE_GAP_MAX
            )));
        }
    }
    let below = height_above_sole(foot, link);
    if below > SOLE_BELOW_MAX {
        return Err(input_error(format!(
            "its sole lies {:.1} mm below the collision shapes of link '{}', so that the foot stands in the air; at most {:.1} mm is allowed; 'surefoot robot add' finds soles",
            1e3 * below,
            link.name,
            1e3 * SOLE_BELOW_MAX
        )));
    }
    Ok(())
}

/// How far the shapes of a link lie above the plane of a sole, m.
pub(crate) fn height_above_sole(foot: &Foot, link: &Link) -> f64 {
    let mut surface = SurfacePoints::default();
    for part in &link.shapes {
        surface.add(&part.shape, &part.link_from_shape);
    }
    let down = foot.link_from_sole.rotation * DVec3::NEG_Z;
    foot.link_from_sole.translation.dot(down) - surface.extent(down)
}

/// The distance from a shape's surface to a point in the shape's frame, negative inside. A mesh is
/// only its surface.
fn signed_distance(shape: &Shape, point: DVec3) -> Result<f64, String> {
    let radial = (point.x * point.x + point.y * point.y).sqrt();
    Ok(match shape {
        Shape::Box { half_extents } => {
            let beyond = point.abs() - *half_extents;
            beyond.max(DVec3::ZERO).length() + beyond.max_element().min(0.0)
        }
        Shape::Sphere { radius } => point.length() - radius,
        Shape::Cylinder { radius, half_length } => {
            let beyond = glam::DVec2::new(radial - radius, point.z.abs() - half_length);
            beyond.max(glam::DVec2::ZERO).length() + beyond.max_element().min(0.0)
        }
        Shape::Capsule { radius, half_length } => {
            let along = (point.z.abs() - half_length).max(0.0);
            (radial * radial + along * along).sqrt() - radius
        }
        Shape::ConvexHull { points, .. } => {
            let (corners, triangles) = hull_triangles(points)?;
            let height = triangles
                .iter()
                .filter_map(|triangle| height_above(&corners, *triangle, point))
                .fold(f64::NEG_INFINITY, f64::max);
            if height > 0.0 { surface_distance(&corners, &triangles, point) } else { height }
        }
        Shape::Mesh { vertices, triangles, .. } => surface_distance(vertices, triangles, point),
    })
}

fn surface_distance(vertices: &[DVec3], triangles: &[[u32; 3]], point: DVec3) -> f64 {
    triangles
        .iter()
        .map(|triangle| {
            let [a, b, c] = triangle.map(|index| vertices[index as usize]);
            Triangle::new(a, b, c).distance_to_local_point(point, false)
        })
        .fold(f64::INFINITY, f64::min)
}

/// How far a point lies outside the plane of an outward triangle; `None` for a sliver.
fn height_above(vertices: &[DVec3], triangle: [u32; 3], point: DVec3) -> Option<f64> {
    let [a, b, c] = triangle.map(|index| vertices[index as usize]);
    (b - a).cross(c - a).try_normalize().map(|normal| normal.dot(point - a))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn assert_distances(shape: &Shape, expected: &[([f64; 3], f64)]) {
        for (point, distance) in expected {
            let found = signed_distance(shape, DVec3::from_array(*point)).unwrap();
            assert!((found - distance).abs() < 1e-9, "{shape:?} {point:?}: {found}");
        }
    }

    #[test]
    fn distances_count_from_the_surface_and_are_negative_inside() {
        let half_extents = DVec3::new(0.3, 0.2, 0.1);
        let corner = |bits: usize| {
            let sign = |axis: usize| if bits >> axis & 1 == 1 { 1.0 } else { -1.0 };
            half_extents * DVec3::new(sign(0), sign(1), sign(2))
        };
        let hull = Shape::ConvexHull { points: (0..8).map(corner).collect(), source: None };
        for block in [Shape::Box { half_extents }, hull] {
            assert_distances(&block, &[([0.6, 0.6, 0.0], 0.5), ([0.0, 0.0, 0.07], -0.03)]);
        }
        let ball = Shape::Sphere { radius: 0.1 };
        assert_distances(&ball, &[([0.0, 0.3, 0.4], 0.4), ([0.0, 0.0, 0.04], -0.06)]);
        let drum = Shape::Cylinder { radius: 0.1, half_length: 0.2 };
        let drum_points = [([0.24, 0.32, 0.6], 0.5), ([0.05, 0.0, 0.0], -0.05)];
        assert_distances(&drum, &drum_points);
        let capsule = Shape::Capsule { radius: 0.1, half_length: 0.2 };
        let capsule_points = [([0.3, 0.0, 0.6], 0.4), ([0.0, 0.05, 0.1], -0.05)];
        assert_distances(&capsule, &capsule_points);
    }
}
