//! From the shapes of a world to faces and curved surfaces.

use std::f64::consts::{PI, TAU};

use glam::DVec3;
use parry3d_f64::transformation::try_convex_hull;
use surefoot_shared_types::world::world::{World, WorldShape};
use surefoot_shared_types::{Pose, Shape};

use crate::foot_placement::elements::{CurvedSurface, Face, FaceKind, SurfaceEnds};
use crate::foot_placement::sole_support::SurfacesError;
use crate::foot_placement::tuning::{CYLINDER_SAGITTA, CYLINDER_SIDES_MAX};
use crate::geometry::coplanar_faces::merge_coplanar;
use crate::geometry::polygon::{FACE_VERTICES_MAX, spanned};

/// The elements of a world.
#[derive(Debug, Default)]
pub(crate) struct WorldElements {
    /// All faces.
    pub faces: Vec<Face>,
    /// Their vertices.
    pub vertices: Vec<DVec3>,
    /// All curved surfaces.
    pub curved_surfaces: Vec<CurvedSurface>,
}

/// The elements of a world's shapes.
///
/// # Errors
/// A convex hull without volume (named).
pub(crate) fn elements_of(world: &World) -> Result<WorldElements, SurfacesError> {
    let mut elements = WorldElements::default();
    for shape in &world.shapes {
        elements.add(shape)?;
    }
    Ok(elements)
}

impl WorldElements {
    fn add(&mut self, world_shape: &WorldShape) -> Result<(), SurfacesError> {
        let pose = world_shape.world_from_shape;
        match &world_shape.shape {
            Shape::Box { half_extents } => self.add_box(&pose, *half_extents),
            Shape::Sphere { radius } => {
                self.add_curved(&pose, *radius, 0.0, SurfaceEnds::Spherical)
            }
            Shape::Capsule { radius, half_length } => {
                self.add_curved(&pose, *radius, *half_length, SurfaceEnds::Spherical)
            }
            Shape::Cylinder { radius, half_length } => {
                self.add_curved(&pose, *radius, *half_length, SurfaceEnds::Flat);
                self.add_cylinder_faces(&pose, *radius, *half_length);
            }
            Shape::ConvexHull { points, .. } => {
                let error = |message: &str| SurfacesError::Shape {
                    shape: world_shape.name.clone(),
                    message: message.into(),
                };
                let (vertices, triangles) = try_convex_hull(points)
                    .map_err(|_| error("its points span no volume; give at least four that do"))?;
                self.add_triangles(&pose, &vertices, &triangles, FaceKind::Solid);
            }
            Shape::Mesh { vertices, triangles, .. } => {
                self.add_triangles(&pose, vertices, triangles, FaceKind::Mesh)
            }
        }
        Ok(())
    }

    fn add_box(&mut self, pose: &Pose, half: DVec3) {
        for axis in 0..3 {
            for sign in [-1.0, 1.0] {
                let mut normal = DVec3::ZERO;
                normal[axis] = sign;
                let (u, v) = (
                    normal.any_orthonormal_vector(),
                    normal.cross(normal.any_orthonormal_vector()),
                );
                let corner = |a: f64, b: f64| *pose * ((normal + a * u + b * v) * half);
                self.add_face(
                    &[corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)],
                    FaceKind::Solid,
                );
            }
        }
    }

    fn add_curved(&mut self, pose: &Pose, radius: f64, half_length: f64, ends: SurfaceEnds) {
        let end = DVec3::Z * half_length;
        self.curved_surfaces.push(CurvedSurface { a: *pose * -end, b: *pose * end, radius, ends });
    }

    /// The caps, and flat sides that make the cylinder an obstacle to a sole that would cross it.
    fn add_cylinder_faces(&mut self, pose: &Pose, radius: f64, half_length: f64) {
        let sides_exact = PI / libm::acos((1.0 - CYLINDER_SAGITTA / radius).max(0.5));
        let sides = (sides_exact.ceil() as usize).clamp(16, CYLINDER_SIDES_MAX);
        let rim = |i: usize, count: usize, z: f64| {
            let (sin, cos) = libm::sincos(TAU * i as f64 / count as f64);
            *pose * DVec3::new(radius * cos, radius * sin, z)
        };
        for i in 0..sides {
            let [low, high] = [-half_length, half_length];
            self.add_face(
                &[
                    rim(i, sides, low),
                    rim(i + 1, sides, low),
                    rim(i + 1, sides, high),
                    rim(i, sides, high),
                ],
                FaceKind::CylinderSide,
            );
        }
        let cap_sides = sides.min(FACE_VERTICES_MAX);
        let top: Vec<DVec3> = (0..cap_sides).map(|i| rim(i, cap_sides, half_length)).collect();
        let bottom: Vec<DVec3> =
            (0..cap_sides).rev().map(|i| rim(i, cap_sides, -half_length)).collect();
        self.add_face(&top, FaceKind::CylinderCap);
        self.add_face(&bottom, FaceKind::CylinderCap);
    }

    fn add_triangles(
        &mut self,
        pose: &Pose,
        vertices: &[DVec3],
        triangles: &[[u32; 3]],
        kind: FaceKind,
    ) {
        let points: Vec<DVec3> = vertices.iter().map(|&v| *pose * v).collect();
        let mut corners = Vec::new();
        merge_coplanar(&points, triangles, |face| {
            corners.clear();
            corners.extend(face.iter().map(|&i| points[i as usize]));
            self.add_face(&corners, kind);
        });
    }

    /// Adds a convex polygon. A polygon without area is left out.
    fn add_face(&mut self, corners: &[DVec3], kind: FaceKind) {
        let Some(normal) = spanned(corners).try_normalize() else { return };
        let offset = corners.iter().map(|&p| normal.dot(p)).sum::<f64>() / corners.len() as f64;
        self.faces.push(Face {
            normal,
            offset,
            first: self.vertices.len() as u32,
            count: corners.len() as u32,
            kind,
        });
        self.vertices.extend_from_slice(corners);
    }
}
