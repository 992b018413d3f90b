//! The checker's form of a shape: a convex core with a rounding radius, or a triangle mesh.

use glam::DVec3;
use parry3d_f64::shape::{Ball, Capsule, Cuboid, Cylinder, SupportMap};
use surefoot_shared_types::Shape;

use crate::geometry::bounds::Bounds;
use crate::geometry::hull::Hull;
use crate::geometry::mesh_solid::MeshSolid;

/// The sharp part of a convex solid.
#[derive(Debug, Clone)]
pub enum Core {
    /// A box, by its half extents.
    Box(DVec3),
    /// A segment along z, by its half length; a point if that is 0.
    Segment(f64),
    /// A cylinder along z.
    Cylinder {
        /// Its radius, m.
        radius: f64,
        /// Half its length, m.
        half_length: f64,
    },
    /// The hull of some points.
    Hull(Hull),
    /// A triangle of a mesh.
    Triangle([DVec3; 3]),
}

impl SupportMap for Core {
    fn local_support_point(&self, direction: DVec3) -> DVec3 {
        match self {
            Self::Box(half) => DVec3::select(direction.cmpge(DVec3::ZERO), *half, -*half),
            Self::Segment(half_length) => DVec3::new(0.0, 0.0, half_length.copysign(direction.z)),
            Self::Cylinder { radius, half_length } => {
                let across =
                    direction.truncate().try_normalize().unwrap_or(glam::DVec2::X) * *radius;
                across.extend(half_length.copysign(direction.z))
            }
            Self::Hull(hull) => hull.support(direction),
            Self::Triangle(corners) => furthest(corners, direction),
        }
    }
}

fn furthest(points: &[DVec3], direction: DVec3) -> DVec3 {
    let mut best = (f64::NEG_INFINITY, DVec3::ZERO);
    for point in points {
        let reach = point.dot(direction);
        if reach > best.0 {
            best = (reach, *point);
        }
    }
    best.1
}

/// A convex solid: its core, grown by a radius.
#[derive(Debug, Clone)]
pub struct Convex {
    /// The sharp part.
    pub core: Core,
    /// The distance by which the solid extends beyond its core, m; 0 unless that is a segment.
    pub radius: f64,
}

/// Sides of the polyhedron around a round solid.
const ROUND_SIDES: u32 = 24;

impl Convex {
    /// The triangles of its surface; of a round solid, of a polyhedron with its vertices on the
    /// surface.
    pub fn surface(&self) -> Vec<[DVec3; 3]> {
        let (vertices, triangles) = match &self.core {
            Core::Box(half) => Cuboid::new(*half).to_trimesh(),
            Core::Segment(0.0) => Ball::new(self.radius).to_trimesh(ROUND_SIDES, ROUND_SIDES),
            Core::Segment(half_length) => {
                let ends = [-*half_length, *half_length].map(|z| DVec3::new(0.0, 0.0, z));
                Capsule::new(ends[0], ends[1], self.radius).to_trimesh(ROUND_SIDES, ROUND_SIDES)
            }
            Core::Cylinder { radius, half_length } => {
                // parry's cylinder lies along y.
                let (vertices, triangles) =
                    Cylinder::new(*half_length, *radius).to_trimesh(ROUND_SIDES);
                let turned = |at: DVec3| DVec3::new(at.x, -at.z, at.y);
                (vertices.into_iter().map(turned).collect(), triangles)
            }
            Core::Hull(hull) => return hull.triangles().to_vec(),
            Core::Triangle(corners) => return vec![*corners],
        };
        let corners = |triangle: [u32; 3]| triangle.map(|index| vertices[index as usize]);
        triangles.into_iter().map(corners).collect()
    }
}

/// A solid in its own frame.
#[derive(Debug, Clone)]
pub enum Solid {
    /// A convex one.
    Convex(Convex),
    /// A surface of triangles.
    Mesh(Box<MeshSolid>),
}

impl Solid {
    /// The checker's form of a shape.
    ///
    /// # Errors
    /// The hull or mesh is degenerate.
    pub fn new(shape: &Shape) -> Result<Self, String> {
        let convex = |core, radius| Ok(Self::Convex(Convex { core, radius }));
        match shape {
            Shape::Box { half_extents } => convex(Core::Box(*half_extents), 0.0),
            Shape::Sphere { radius } => convex(Core::Segment(0.0), *radius),
            Shape::Capsule { radius, half_length } => convex(Core::Segment(*half_length), *radius),
            Shape::Cylinder { radius, half_length } => {
                convex(Core::Cylinder { radius: *radius, half_length: *half_length }, 0.0)
            }
            Shape::ConvexHull { points, source } => {
                convex(Core::Hull(Hull::new(points, source.as_ref())?), 0.0)
            }
            Shape::Mesh { vertices, triangles, .. } => {
                Ok(Self::Mesh(Box::new(MeshSolid::new(vertices, triangles)?)))
            }
        }
    }

    /// Its furthest point along a direction, in its own frame.
    pub fn furthest(&self, direction: DVec3) -> DVec3 {
        match self {
            Self::Convex(convex) => {
                let beyond = convex.radius * direction.normalize_or_zero();
                convex.core.local_support_point(direction) + beyond
            }
            Self::Mesh(mesh) => furthest(mesh.surface.vertices(), direction),
        }
    }

    /// The box around it, in its own frame.
    pub fn local_bounds(&self) -> Bounds {
        match self {
            Self::Convex(convex) => {
                let reach = |axis| convex.core.local_support_point(axis);
                let ends = DVec3::AXES.into_iter().flat_map(|axis| [reach(axis), reach(-axis)]);
                Bounds::of_points(ends).expanded(convex.radius)
            }
            Self::Mesh(mesh) => Bounds::of_points(mesh.surface.vertices().iter().copied()),
        }
    }

    /// The largest distance of any of its points from `centre` (m, its own frame), or a little
    /// more.
    pub fn reach_from(&self, centre: DVec3) -> f64 {
        let furthest = |points: &[DVec3]| {
            points.iter().map(|point| point.distance(centre)).fold(0.0, f64::max)
        };
        match self {
            Self::Convex(Convex { core: Core::Hull(hull), .. }) => furthest(hull.points()),
            Self::Convex(_) => {
                let bounds = self.local_bounds();
                (bounds.low - centre).abs().max((bounds.high - centre).abs()).length()
            }
            Self::Mesh(mesh) => furthest(mesh.surface.vertices()),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::check_robot::{box_of, mesh, randoms};

    #[test]
    fn no_point_of_a_solid_is_further_than_its_reach() {
        let mut random = randoms(6);
        let mut vector = || DVec3::from_array([0; 3].map(|_| random(-0.4, 0.4)));
        let hull = |points: Vec<DVec3>| Shape::ConvexHull { points, source: None };
        let shapes = [
            (box_of(0.1, 0.2, 0.3), 1.0),
            (mesh([0.1, 0.2, 0.3], 2), 1.0),
            (hull((0..12).map(|_| vector()).collect()), 1.0),
            (Shape::Sphere { radius: 0.2 }, 0.55),
            (Shape::Capsule { radius: 0.1, half_length: 0.2 }, 0.75),
            (Shape::Cylinder { radius: 0.1, half_length: 0.2 }, 0.75),
        ];
        for ((shape, exact), _) in shapes.iter().flat_map(|shape| (0..8).map(move |k| (shape, k))) {
            let (solid, centre) = (Solid::new(shape).unwrap(), vector());
            let points: Vec<DVec3> = match &solid {
                Solid::Convex(convex) => convex.surface().into_iter().flatten().collect(),
                Solid::Mesh(mesh) => mesh.surface.vertices().to_vec(),
            };
            let furthest = points.iter().map(|at| at.distance(centre)).fold(0.0, f64::max);
            let reach = solid.reach_from(centre);
            assert!(furthest <= reach + 1e-12, "{shape:?} {centre}: {furthest} {reach}");
            // The box around a round solid reaches further.
            assert!(furthest >= exact * reach - 1e-12, "{shape:?} {centre}: {furthest} {reach}");
        }
    }
}
