//! The surface of a shape as triangles.

use glam::DVec3;
use parry3d_f64::shape::{Ball, Capsule, Cuboid, Cylinder};
use parry3d_f64::transformation::try_convex_hull;
use surefoot_shared_types::Shape;

/// Sides of a round shape.
const SIDES: u32 = 64;

/// Vertices and triangles of a shape's surface, in its own frame. Round shapes have flat sides. A
/// hull without volume has none.
pub(crate) fn triangles_of(shape: &Shape) -> (Vec<DVec3>, Vec<[u32; 3]>) {
    match shape {
        Shape::Box { half_extents } => Cuboid::new(*half_extents).to_trimesh(),
        Shape::Sphere { radius } => Ball::new(*radius).to_trimesh(SIDES, SIDES),
        Shape::Cylinder { radius, half_length } => {
            let (mut vertices, triangles) = Cylinder::new(*half_length, *radius).to_trimesh(SIDES);
            // The axis of the library's cylinder is y.
            vertices.iter_mut().for_each(|v| *v = DVec3::new(v.x, -v.z, v.y));
            (vertices, triangles)
        }
        Shape::Capsule { radius, half_length } => {
            let end = DVec3::Z * *half_length;
            Capsule::new(-end, end, *radius).to_trimesh(SIDES, SIDES)
        }
        Shape::ConvexHull { points, .. } => try_convex_hull(points).unwrap_or_default(),
        Shape::Mesh { vertices, triangles, .. } => (vertices.clone(), triangles.clone()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_shape_has_the_extent_that_it_states() {
        let corners = [-1.0, 1.0].map(|z| {
            [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)].map(|(x, y)| DVec3::new(x, y, z))
        });
        let hull = Shape::ConvexHull { points: corners.concat(), source: None };
        let (vertices, triangles) = triangles_of(&hull);
        let cases = [
            (Shape::Box { half_extents: DVec3::new(0.1, 0.2, 0.3) }, DVec3::new(0.1, 0.2, 0.3)),
            (Shape::Sphere { radius: 0.2 }, DVec3::splat(0.2)),
            (Shape::Cylinder { radius: 0.1, half_length: 0.4 }, DVec3::new(0.1, 0.1, 0.4)),
            (Shape::Capsule { radius: 0.1, half_length: 0.4 }, DVec3::new(0.1, 0.1, 0.5)),
            (hull, DVec3::ONE),
            (Shape::Mesh { vertices, triangles, source: None }, DVec3::ONE),
        ];
        for (shape, extent) in cases {
            let (vertices, triangles) = triangles_of(&shape);
            assert!(triangles.iter().flatten().all(|&corner| (corner as usize) < vertices.len()));
            let highest = vertices.iter().fold(DVec3::ZERO, |most, vertex| most.max(vertex.abs()));
            assert!((highest - extent).abs().max_element() < 2e-3, "{shape:?}: {highest}");
        }
    }
}
