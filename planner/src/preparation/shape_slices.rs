//! The robot's shapes cut into slices, so that boxes around them stay tight when links are
//! inclined.

use glam::DVec3;
use parry3d_f64::transformation::try_convex_hull;
use surefoot_shared_types::{Pose, Shape};

use crate::geometry::bvh::Aabb;
use crate::preparation::tuning::SLICE_THICKNESS_MAX;

/// Part of the robot to which a slice belongs.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum RobotPart {
    /// Any link that belongs to no leg.
    Trunk,
    /// A leg's link above the foot.
    Leg(usize),
    /// A foot.
    Foot(usize),
}

/// The box around a piece of a link's shape.
#[derive(Debug, Clone, Copy)]
pub struct Slice {
    /// The link.
    pub link: usize,
    /// The part of the robot.
    pub robot_part: RobotPart,
    /// The box's frame in the link's.
    pub link_from_slice: Pose,
    /// The box in that frame.
    pub bounds: Aabb,
}

/// Cuts a shape of a link across the longest side of its box `bounds`, which is in the shape's
/// frame.
pub fn slices(
    link: usize,
    robot_part: RobotPart,
    link_from_shape: Pose,
    shape: &Shape,
    bounds: &Aabb,
) -> Vec<Slice> {
    let edges = edges(shape);
    let size = bounds.max - bounds.min;
    let axis = size.max_position();
    let count = libm::ceil(size[axis] / SLICE_THICKNESS_MAX).max(1.0) as usize;
    let cut = |at: usize| bounds.min[axis] + size[axis] * at as f64 / count as f64;
    let slice = |index: usize| {
        let ends = [cut(index), cut(index + 1)];
        let mut piece = *bounds;
        (piece.min[axis], piece.max[axis]) = (ends[0], ends[1]);
        let bounds = edges.as_ref().map_or(piece, |edges| around(edges, axis, ends));
        (bounds.min.x <= bounds.max.x).then_some(Slice {
            link,
            robot_part,
            link_from_slice: link_from_shape,
            bounds,
        })
    };
    (0..count).filter_map(slice).collect()
}

/// The edges of a mesh or convex hull; `None` for shapes that are sliced as their boxes.
fn edges(shape: &Shape) -> Option<Vec<[DVec3; 2]>> {
    let (vertices, triangles) = match shape {
        Shape::Mesh { vertices, triangles, .. } => (vertices.clone(), triangles.clone()),
        Shape::ConvexHull { points, .. } => try_convex_hull(points).ok()?,
        _ => return None,
    };
    let sides = |[a, b, c]: [u32; 3]| [[a, b], [b, c], [c, a]];
    Some(
        triangles
            .into_iter()
            .flat_map(sides)
            .map(|ends| ends.map(|index| vertices[index as usize]))
            .collect(),
    )
}

/// The box around the part of a surface between two heights along an axis. The extreme points of
/// that part lie on the edges.
fn around(edges: &[[DVec3; 2]], axis: usize, [low, high]: [f64; 2]) -> Aabb {
    edges.iter().fold(Aabb::EMPTY, |bounds, &[a, b]| {
        let extent = b[axis] - a[axis];
        let share_at = |height: f64| ((height - a[axis]) / extent).clamp(0.0, 1.0);
        let [first, last] =
            if extent == 0.0 { [0.0, 1.0] } else { [share_at(low), share_at(high)] };
        [first, last]
            .into_iter()
            .map(|share| a.lerp(b, share))
            .filter(|point| (low - ROUNDING..=high + ROUNDING).contains(&point[axis]))
            .fold(bounds, |bounds, point| bounds.union(Aabb { min: point, max: point }))
    })
}

/// Distance of a rounded cut from its plane, m.
const ROUNDING: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    /// A pyramid, one metre high over a square of two metres.
    fn pyramid() -> Shape {
        let corner = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        Shape::ConvexHull {
            points: vec![
                corner(-1.0, -1.0),
                corner(1.0, -1.0),
                corner(1.0, 1.0),
                corner(-1.0, 1.0),
                DVec3::new(0.0, 0.0, 3.0),
            ],
            source: None,
        }
    }

    #[test]
    fn slices_of_a_pyramid_shrink_and_cover_it() {
        let bounds = Aabb { min: DVec3::new(-1.0, -1.0, 0.0), max: DVec3::new(1.0, 1.0, 3.0) };
        let cut = slices(0, RobotPart::Trunk, Pose::IDENTITY, &pyramid(), &bounds);
        assert_eq!(cut.len(), 50);
        for slice in cut {
            let half = 1.0 - slice.bounds.min.z / 3.0;
            assert!(
                (slice.bounds.max.x - half).abs() < 1e-6
                    && (slice.bounds.min.y + half).abs() < 1e-6,
                "{slice:?}"
            );
        }
    }

    #[test]
    fn a_ball_is_sliced_as_its_box() {
        let bounds = Aabb { min: DVec3::splat(-0.05), max: DVec3::splat(0.05) };
        let cut =
            slices(0, RobotPart::Leg(1), Pose::IDENTITY, &Shape::Sphere { radius: 0.05 }, &bounds);
        let volume: f64 =
            cut.iter().map(|slice| (slice.bounds.max - slice.bounds.min).element_product()).sum();
        assert!(cut.len() == 2 && (volume - 1e-3).abs() < 1e-12, "{cut:?}");
    }
}
