//! The world and the footsteps as markers, and as a scene of Foxglove.

use glam::DVec3;
use parry3d_f64::transformation::try_convex_hull;
use surefoot_shared_types::Shape;
use surefoot_shared_types::base::spatial::Pose as SpatialPose;
use surefoot_shared_types::world::world::{World, WorldShape};

use crate::export::error::ExportError;
use crate::export::ros::foxglove::{
    Color, CubePrimitive, CylinderPrimitive, LinePrimitive, SceneEntity, SceneUpdate,
    SpherePrimitive, TriangleListPrimitive,
};
use crate::export::ros::messages::{
    ColorRgba, Footstep, FootstepArray, Header, Point, Pose, Vector3, WORLD_FRAME,
};
use crate::export::ros::visualization::{
    CUBE, CYLINDER, LINE_STRIP, Marker, MarkerArray, SPHERE, TRIANGLE_LIST,
};

/// The world's colour.
const GREY: [f32; 3] = [0.6, 0.6, 0.6];
/// The colours of left and right footsteps.
const FEET: [[f32; 3]; 2] = [[0.1, 0.4, 0.9], [0.9, 0.3, 0.1]];
/// Width of a sole's outline, m.
const LINE_WIDTH: f64 = 0.005;

/// A solid as both kinds of scene draw it.
struct Part {
    kind: i32,
    world_from_part: SpatialPose,
    size: DVec3,
    corners: Vec<DVec3>,
}

/// The shapes of a world as markers.
///
/// # Errors
/// The convex hull of a shape has no volume.
pub fn world_markers(world: &World) -> Result<MarkerArray, ExportError> {
    let mut markers = Vec::new();
    for shape in &world.shapes {
        for part in parts(shape)? {
            markers.push(Marker {
                header: Header::at(0.0, WORLD_FRAME),
                ns: shape.name.clone(),
                id: markers.len() as i32,
                r#type: part.kind,
                pose: (&part.world_from_part).into(),
                scale: part.size.into(),
                color: rgba(GREY),
                points: part.corners.iter().map(|&corner| corner.into()).collect(),
                ..Marker::default()
            });
        }
    }
    Ok(MarkerArray { markers })
}

/// The soles of footsteps as closed lines.
pub fn footstep_markers(footsteps: &FootstepArray) -> MarkerArray {
    let marker = |(id, step): (usize, &Footstep)| Marker {
        header: footsteps.header.clone(),
        ns: format!("footsteps_{}", step.foot),
        id: id as i32,
        r#type: LINE_STRIP,
        pose: step.sole_pose.clone(),
        scale: DVec3::new(LINE_WIDTH, 0.0, 0.0).into(),
        color: rgba(colour_of(&step.foot)),
        points: step.polygon.iter().chain(step.polygon.first()).cloned().collect(),
        ..Marker::default()
    };
    MarkerArray { markers: footsteps.footsteps.iter().enumerate().map(marker).collect() }
}

/// The world and the footsteps for Foxglove.
///
/// # Errors
/// The convex hull of a shape has no volume.
pub fn scene_update(world: &World, footsteps: &FootstepArray) -> Result<SceneUpdate, ExportError> {
    let entity = |id: &str| SceneEntity {
        frame_id: WORLD_FRAME.to_owned(),
        id: id.to_owned(),
        ..SceneEntity::default()
    };
    let mut entities = Vec::new();
    for shape in &world.shapes {
        let mut entity = entity(&format!("world/{}", shape.name));
        parts(shape)?.into_iter().for_each(|part| add_part(&mut entity, part));
        entities.push(entity);
    }
    let mut outlines = entity("footsteps");
    outlines.lines = footsteps
        .footsteps
        .iter()
        .map(|step| LinePrimitive {
            // A closed line.
            r#type: 1,
            pose: step.sole_pose.clone(),
            thickness: LINE_WIDTH,
            points: step.polygon.clone(),
            color: color(colour_of(&step.foot)),
            ..LinePrimitive::default()
        })
        .collect();
    entities.push(outlines);
    Ok(SceneUpdate { deletions: Vec::new(), entities })
}

fn add_part(entity: &mut SceneEntity, part: Part) {
    let pose: Pose = (&part.world_from_part).into();
    let (size, color): (Vector3, Color) = (part.size.into(), color(GREY));
    match part.kind {
        CUBE => entity.cubes.push(CubePrimitive { pose, size, color }),
        SPHERE => entity.spheres.push(SpherePrimitive { pose, size, color }),
        CYLINDER => {
            let (bottom_scale, top_scale) = (1.0, 1.0);
            let cylinder = CylinderPrimitive { pose, size, bottom_scale, top_scale, color };
            entity.cylinders.push(cylinder);
        }
        _ => {
            let points: Vec<Point> = part.corners.iter().map(|&corner| corner.into()).collect();
            let list = TriangleListPrimitive { pose, points, color, ..Default::default() };
            entity.triangles.push(list);
        }
    }
}

/// The solids of a shape: a capsule is a cylinder and two balls.
fn parts(shape: &WorldShape) -> Result<Vec<Part>, ExportError> {
    let solid = |kind: i32, height: f64, size: DVec3| {
        let shape_from_part = SpatialPose::from_translation(height * DVec3::Z);
        let world_from_part = shape.world_from_shape * shape_from_part;
        Part { kind, world_from_part, size, corners: Vec::new() }
    };
    let ball = |radius: f64, height: f64| solid(SPHERE, height, DVec3::splat(2.0 * radius));
    let cylinder =
        |radius: f64, half: f64| solid(CYLINDER, 0.0, 2.0 * DVec3::new(radius, radius, half));
    let triangles = |vertices: &[DVec3], triangles: &[[u32; 3]]| {
        let corner = |&index: &u32| vertices[index as usize];
        let corners = triangles.iter().flatten().map(corner).collect();
        Part { corners, ..solid(TRIANGLE_LIST, 0.0, DVec3::ONE) }
    };
    Ok(match &shape.shape {
        Shape::Box { half_extents } => vec![solid(CUBE, 0.0, 2.0 * *half_extents)],
        Shape::Sphere { radius } => vec![ball(*radius, 0.0)],
        Shape::Cylinder { radius, half_length } => vec![cylinder(*radius, *half_length)],
        Shape::Capsule { radius, half_length } => {
            let ends = [-half_length, *half_length].map(|height| ball(*radius, height));
            ends.into_iter().chain([cylinder(*radius, *half_length)]).collect()
        }
        Shape::ConvexHull { points, .. } => {
            let (vertices, faces) = try_convex_hull(points).map_err(|error| {
                ExportError::writer("mcap", format!("shape '{}': {error}", shape.name))
            })?;
            vec![triangles(&vertices, &faces)]
        }
        Shape::Mesh { vertices, triangles: faces, .. } => vec![triangles(vertices, faces)],
    })
}

fn colour_of(foot: &str) -> [f32; 3] {
    FEET[usize::from(foot == "right")]
}

fn rgba([r, g, b]: [f32; 3]) -> ColorRgba {
    ColorRgba { r, g, b, a: 1.0 }
}

fn color([r, g, b]: [f32; 3]) -> Color {
    Color { r: r.into(), g: g.into(), b: b.into(), a: 1.0 }
}
