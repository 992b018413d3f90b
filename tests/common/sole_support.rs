//! The support of a sole: level tops of a world's boxes and meshes and the area over which a
//! sole's contact points spread.

use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3, dvec2};
use surefoot_shared_types::base::spatial::{rotation_about, yaw_of};
use surefoot_shared_types::world::load::load_world;
use surefoot_shared_types::world::world::{World, WorldShape};
use surefoot_shared_types::{Pose, Shape};

/// A sole point counts as supported within this height of a surface, m.
const CONTACT_GAP: f64 = 3e-3;
/// Sole outline in the sole frame, m.
pub const SOLE: [DVec2; 4] =
    [dvec2(-0.09, -0.07), dvec2(0.13, -0.07), dvec2(0.13, 0.07), dvec2(-0.09, 0.07)];
/// Length and width of the sole, m.
pub const SOLE_SIZE: DVec2 = dvec2(0.22, 0.14);
/// The longest step a rough model of the reference robot finds on flat ground, between sole
/// centres, m.
pub const LONGEST_STEP: f64 = 0.75;

/// A folder of `configs/`.
pub fn configs(folder: &str) -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("configs").join(folder)
}

/// A shipped world by name.
pub fn world(name: &str) -> World {
    load_world(&configs("worlds").join(format!("{name}.toml"))).unwrap()
}

/// The shapes whose name begins with `prefix`, in file order.
pub fn named<'a>(world: &'a World, prefix: &str) -> Vec<&'a WorldShape> {
    world.shapes.iter().filter(|shape| shape.name.starts_with(prefix)).collect()
}

/// The one shape of that name.
pub fn shape<'a>(world: &'a World, name: &str) -> &'a WorldShape {
    world
        .shapes
        .iter()
        .find(|shape| shape.name == name)
        .unwrap_or_else(|| panic!("no shape '{name}'"))
}

/// Half extents of a box shape.
pub fn half_extents(shape: &WorldShape) -> DVec3 {
    match shape.shape {
        Shape::Box { half_extents } => half_extents,
        _ => panic!("'{}' is not a box", shape.name),
    }
}

/// Lower and upper corner of a box that is not rotated.
pub fn bounds(shape: &WorldShape) -> (DVec3, DVec3) {
    let pose = &shape.world_from_shape;
    assert!((pose.rotation.w.abs() - 1.0).abs() < 1e-12, "'{}' is rotated", shape.name);
    (pose.translation - half_extents(shape), pose.translation + half_extents(shape))
}

/// The level faces of a box or a mesh: the height and the counter-clockwise outline of each, seen
/// from above.
fn level_faces(shape: &WorldShape) -> Vec<(f64, Vec<DVec2>)> {
    let Shape::Mesh { vertices, triangles, .. } = &shape.shape else {
        return top_face(shape).into_iter().collect();
    };
    let corners = triangles
        .iter()
        .map(|triangle| triangle.map(|index| shape.world_from_shape * vertices[index as usize]));
    let level =
        corners.filter(|[a, b, c]| a.z == b.z && a.z == c.z && (*b - *a).cross(*c - *a).z > 0.0);
    level.map(|corners| (corners[0].z, corners.map(DVec3::truncate).to_vec())).collect()
}

/// The level top of a box: its height and its counter-clockwise outline seen from above.
pub fn top_face(shape: &WorldShape) -> Option<(f64, Vec<DVec2>)> {
    let Shape::Box { half_extents: half } = shape.shape else { return None };
    let pose = &shape.world_from_shape;
    if (pose.rotation * DVec3::Z).z < 1.0 - 1e-9 {
        return None;
    }
    let corners = [(-1.0, -1.0), (1.0, -1.0), (1.0, 1.0), (-1.0, 1.0)];
    let outline =
        corners.map(|(x, y)| (*pose * DVec3::new(x * half.x, y * half.y, half.z)).truncate());
    Some((pose.translation.z + half.z, outline.to_vec()))
}

/// The sole frame at a place in the world, level.
pub fn sole_at(position: DVec3, yaw: f64) -> Pose {
    Pose::from_parts(position, rotation_about(DVec3::Z, yaw))
}

/// The points at which a level sole rests on level box tops: the corners of each clipped face.
pub fn contacts(world: &World, world_from_sole: &Pose) -> Vec<DVec2> {
    let sole: Vec<DVec2> =
        SOLE.iter().map(|point| (*world_from_sole * point.extend(0.0)).truncate()).collect();
    let tops = world.shapes.iter().flat_map(level_faces);
    let near =
        tops.filter(|(height, _)| (height - world_from_sole.translation.z).abs() <= CONTACT_GAP);
    near.flat_map(|(_, outline)| clip(&sole, &outline)).collect()
}

/// The area of the convex hull of a sole's contact points, m2.
pub fn support_area(world: &World, world_from_sole: &Pose) -> f64 {
    area(&hull(contacts(world, world_from_sole)))
}

/// Whether the sole's outline lies wholly on level tops at its height, on one face or several side
/// by side.
pub fn rests_wholly(world: &World, world_from_sole: &Pose) -> bool {
    let sole: Vec<DVec2> =
        SOLE.iter().map(|point| (*world_from_sole * point.extend(0.0)).truncate()).collect();
    let tops = world.shapes.iter().flat_map(level_faces);
    let near =
        tops.filter(|(height, _)| (height - world_from_sole.translation.z).abs() <= CONTACT_GAP);
    let covered: f64 = near.map(|(_, outline)| area(&clip(&sole, &outline))).sum();
    covered >= area(&sole) - 1e-9
}

/// The part of a convex polygon inside a convex, counter-clockwise one (Sutherland and Hodgman's
/// clipping).
pub fn clip(subject: &[DVec2], clipper: &[DVec2]) -> Vec<DVec2> {
    let mut kept = subject.to_vec();
    for (index, &from) in clipper.iter().enumerate() {
        let edge = clipper[(index + 1) % clipper.len()] - from;
        let inside = |point: DVec2| edge.perp_dot(point - from);
        let polygon = std::mem::take(&mut kept);
        for (at, &here) in polygon.iter().enumerate() {
            let next = polygon[(at + 1) % polygon.len()];
            let (a, b) = (inside(here), inside(next));
            if a >= 0.0 {
                kept.push(here);
            }
            if a * b < 0.0 {
                kept.push(here + (next - here) * (a / (a - b)));
            }
        }
    }
    kept
}

/// The convex hull, counter-clockwise (Andrew's monotone chain).
pub fn hull(mut points: Vec<DVec2>) -> Vec<DVec2> {
    points.sort_by(|a, b| a.x.total_cmp(&b.x).then(a.y.total_cmp(&b.y)));
    let half = |points: &mut dyn Iterator<Item = DVec2>| {
        let mut chain: Vec<DVec2> = Vec::new();
        for point in points {
            while chain.len() >= 2
                && (chain[chain.len() - 1] - chain[chain.len() - 2])
                    .perp_dot(point - chain[chain.len() - 1])
                    <= 0.0
            {
                chain.pop();
            }
            chain.push(point);
        }
        chain.pop();
        chain
    };
    let mut chain = half(&mut points.iter().copied());
    chain.extend(half(&mut points.iter().rev().copied()));
    chain
}

/// The area of a counter-clockwise polygon, m2.
pub fn area(polygon: &[DVec2]) -> f64 {
    polygon
        .iter()
        .enumerate()
        .map(|(at, point)| 0.5 * point.perp_dot(polygon[(at + 1) % polygon.len()]))
        .sum()
}

/// The heading of a shape, rad.
pub fn heading(shape: &WorldShape) -> f64 {
    yaw_of(shape.world_from_shape.rotation)
}
