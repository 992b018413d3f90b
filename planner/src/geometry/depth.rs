//! How deep a point lies in a solid.

use glam::DVec3;

use crate::geometry::solid::{Convex, Core, Solid};

impl Solid {
    /// A lower bound of how far a point in the solid's frame lies below its surface, m; negative
    /// outside, where it is minus an upper bound of the distance. Minus infinity where no bound is
    /// known, as for a mesh.
    pub fn depth(&self, point: DVec3) -> f64 {
        match self {
            Self::Convex(convex) => convex.depth(point),
            Self::Mesh(_) => f64::NEG_INFINITY,
        }
    }
}

impl Convex {
    fn depth(&self, point: DVec3) -> f64 {
        let core = match &self.core {
            Core::Point => -point.length(),
            Core::LineSegment { half_length } => {
                let along = point.z.clamp(-half_length, *half_length);
                -(point - DVec3::new(0.0, 0.0, along)).length()
            }
            Core::Box { half_extents } => inside(*half_extents - point.abs()),
            Core::Cylinder { radius, half_length } => {
                let left = radius - point.truncate().length();
                inside(DVec3::new(left, left.max(0.0), half_length - point.z.abs()))
            }
            Core::Hull(hull) => hull.inner_radius() - (point - hull.aabb().center()).length(),
            Core::Triangle(_) => f64::NEG_INFINITY,
        };
        core + self.radius
    }
}

/// The depth of a point that is this far from the faces of a box, inside positive, by axis.
fn inside(left: DVec3) -> f64 {
    let least = left.min_element();
    if least >= 0.0 { least } else { -left.min(DVec3::ZERO).length() }
}

#[cfg(test)]
mod tests {
    use surefoot_shared_types::Shape;

    use super::*;

    #[test]
    fn a_point_is_as_deep_as_it_is_far_from_the_surface() {
        let depth = |shape: Shape, point: [f64; 3]| {
            Solid::new(&shape, "shape").unwrap().depth(DVec3::from(point))
        };
        let cube = || Shape::Box { half_extents: DVec3::new(1.0, 2.0, 3.0) };
        assert_eq!(depth(cube(), [0.5, 0.0, 0.0]), 0.5);
        assert_eq!(depth(cube(), [4.0, 0.0, 7.0]), -5.0);
        let capsule = || Shape::Capsule { radius: 0.5, half_length: 1.0 };
        assert_eq!(depth(capsule(), [0.0, 0.25, 0.9]), 0.25);
        assert_eq!(depth(capsule(), [0.0, 0.0, 2.0]), -0.5);
        let cylinder = || Shape::Cylinder { radius: 0.5, half_length: 1.0 };
        assert_eq!(depth(cylinder(), [0.25, 0.0, 0.0]), 0.25);
        assert_eq!(depth(cylinder(), [0.0, 3.5, 5.0]), -5.0);
        let corners = (0..8).map(|corner| {
            DVec3::from_array(
                [0, 1, 2].map(|axis| if corner >> axis & 1 == 0 { 1.0 } else { -1.0 }),
            )
        });
        let hull = Shape::ConvexHull { points: corners.collect(), source: None };
        let inner = depth(hull.clone(), [0.0; 3]);
        assert!(inner > 0.99 && inner <= 1.0, "{inner}");
        assert!(depth(hull, [0.9, 0.9, 0.9]) < 0.1);
    }
}
