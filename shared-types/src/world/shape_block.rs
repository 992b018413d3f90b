//! Turns the plan format's pose and shape blocks into validated values. World files use the same
//! blocks.

use std::path::Path;

use glam::{DQuat, DVec3};

use crate::base::spatial::Pose;
use crate::base::text_file::{check_numbers, check_positive};
use crate::geometry::convex_hull::hull_points;
use crate::geometry::shape::Shape;
use crate::mesh::file_name::find_file;
use crate::mesh::store::MeshStore;
use crate::plan_format::blocks::{PoseBlock, ShapeBlock};

/// How far a quaternion's length may be from 1.
const QUATERNION_TOLERANCE: f64 = 1e-4;

/// The pose in a block; the message names the problem of it.
pub(crate) fn pose_from_block(block: &PoseBlock) -> Result<Pose, String> {
    pose_from_arrays(block.xyz, block.quat_xyzw)
}

/// The pose with this position (m) and unit quaternion (x, y, z, w).
pub(crate) fn pose_from_arrays(xyz: [f64; 3], quat_xyzw: [f64; 4]) -> Result<Pose, String> {
    check_numbers("position", &xyz)?;
    check_numbers("quaternion", &quat_xyzw)?;
    let rotation = DQuat::from_array(quat_xyzw);
    if (rotation.length() - 1.0).abs() > QUATERNION_TOLERANCE {
        return Err(format!(
            "quaternion {quat_xyzw:?} has length {}; it must be 1 within {QUATERNION_TOLERANCE}",
            rotation.length()
        ));
    }
    Ok(Pose::from_parts(xyz.into(), rotation.normalize()))
}

/// The shape in a block, mesh paths relative to `base_dir`; the message names the problem of it.
pub(crate) fn shape_from_block(
    block: &ShapeBlock,
    base_dir: &Path,
    meshes: &mut MeshStore,
) -> Result<Shape, String> {
    let scale_of = |scale: &Option<[f64; 3]>| scale.map_or(DVec3::ONE, DVec3::from_array);
    match block {
        ShapeBlock::Box { half_extents } => {
            check_positive("half_extents", half_extents)?;
            Ok(Shape::Box { half_extents: (*half_extents).into() })
        }
        ShapeBlock::Sphere { radius } => {
            check_positive("radius", &[*radius])?;
            Ok(Shape::Sphere { radius: *radius })
        }
        ShapeBlock::Cylinder { radius, length } => {
            check_positive("radius", &[*radius])?;
            check_positive("length", &[*length])?;
            Ok(Shape::Cylinder { radius: *radius, half_length: 0.5 * length })
        }
        ShapeBlock::Capsule { radius, length } => {
            check_positive("radius", &[*radius])?;
            check_positive("length", &[*length])?;
            Ok(Shape::Capsule { radius: *radius, half_length: 0.5 * length })
        }
        ShapeBlock::Convex { points: Some(points), path: None, scale: None } => {
            hull_from_points(points)
        }
        ShapeBlock::Convex { points: None, path: Some(path), scale } => {
            meshes.hull(&find_file(base_dir, path), scale_of(scale))
        }
        ShapeBlock::Convex { .. } => {
            Err("convex needs either points, or a path with an optional scale".into())
        }
        ShapeBlock::Mesh { path, scale } => {
            meshes.surface(&find_file(base_dir, path), scale_of(scale))
        }
    }
}

fn hull_from_points(points: &[[f64; 3]]) -> Result<Shape, String> {
    check_numbers("points", points.as_flattened())?;
    let points = hull_points(points.iter().map(|point| DVec3::from_array(*point)).collect())?;
    Ok(Shape::ConvexHull { points, source: None })
}
