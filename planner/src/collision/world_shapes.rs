//! The world's shapes behind a tree of boxes.

use glam::{DMat3, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::world::world::World;

use crate::collision::robot_bodies::{CollisionBody, Part};
use crate::geometry::CollisionError;
use crate::geometry::bvh::{Aabb, Bvh};
use crate::geometry::narrow_phase::is_within;
use crate::geometry::solid::{Convex, Core, Solid};

/// The world, prepared.
#[derive(Debug, Clone)]
pub struct WorldShapes {
    shapes: Vec<PlacedSolid>,
    tree: Bvh,
    boxes: Vec<Aabb>,
    bounds: Aabb,
}

#[derive(Debug, Clone)]
struct PlacedSolid {
    shape_from_world: Pose,
    solid: Solid,
}

/// The shapes near the robot, found once for all of its bodies.
#[derive(Debug)]
pub struct Nearby {
    shapes: heapless::Vec<(u32, Aabb), NEARBY_MAX>,
    /// Whether these are all of them; otherwise the tree is asked for each body.
    is_all: bool,
}

/// Up to so many shapes a loop over them is faster than the tree.
const NEARBY_MAX: usize = 24;

impl Nearby {
    /// Nothing is known of what is near.
    pub const UNKNOWN: Self = Self { shapes: heapless::Vec::new(), is_all: false };
}

impl WorldShapes {
    /// Prepares a world.
    pub fn new(world: &World) -> Result<Self, CollisionError> {
        let mut shapes = Vec::with_capacity(world.shapes.len());
        let mut bounds = Vec::with_capacity(world.shapes.len());
        for shape in &world.shapes {
            let owner = format!("world shape '{}'", shape.name);
            if !shape.world_from_shape.is_finite() {
                return Err(CollisionError::BadNumber {
                    owner,
                    what: "the pose",
                    requirement: "finite",
                });
            }
            let solid = Solid::new(&shape.shape, &owner)?;
            let rotation = DMat3::from_quat(shape.world_from_shape.rotation);
            bounds.push(solid.aabb().transformed(&rotation, shape.world_from_shape.translation));
            shapes.push(PlacedSolid { shape_from_world: shape.world_from_shape.inverse(), solid });
        }
        let all = bounds.iter().copied().fold(Aabb::EMPTY, Aabb::union);
        Ok(Self { shapes, tree: Bvh::new(&bounds, 1), boxes: bounds, bounds: all })
    }

    /// The box around all shapes.
    pub fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The shapes that may meet anything within a box.
    pub fn nearby(&self, around: &Aabb) -> Nearby {
        let mut shapes = heapless::Vec::new();
        let is_too_many = |index: usize| shapes.push((index as u32, self.boxes[index])).is_err();
        let is_all = self.tree.find(|bounds| bounds.overlaps(around), is_too_many).is_none();
        Nearby { shapes, is_all }
    }

    /// Whether any shape's box comes within `reach` (m) of a point; `nearby` holds all that may.
    pub fn reaches(&self, center: DVec3, reach: f64, nearby: &Nearby) -> bool {
        if nearby.is_all {
            return nearby.shapes.iter().any(|(_, bounds)| bounds.reaches(center, reach));
        }
        self.tree.find(|bounds| bounds.reaches(center, reach), |_| true).is_some()
    }

    /// The first shape within `margin` of a body, in the tree's order; `nearby` holds all that may
    /// be.
    pub fn hit(
        &self,
        body: &CollisionBody,
        world_from_node: &Pose,
        margin: f64,
        nearby: &Nearby,
    ) -> Option<usize> {
        let may_be = self.reaches(
            *world_from_node * body.sphere.center,
            body.sphere.radius + margin,
            nearby,
        );
        may_be.then(|| {
            body.parts.iter().find_map(|part| self.part_hit(part, world_from_node, margin, nearby))
        })?
    }

    /// The first shape that meets a box, in the tree's order.
    pub fn box_hit(&self, world_from_box: &Pose, half_extents: DVec3) -> Option<usize> {
        let solid = Solid::Convex(Convex { core: Core::Box { half_extents }, radius: 0.0 });
        let bounds = Aabb { min: -half_extents, max: half_extents };
        let around = bounds
            .transformed(&DMat3::from_quat(world_from_box.rotation), world_from_box.translation);
        let touches = |index: usize| {
            let shape = &self.shapes[index];
            is_within(&shape.solid, &solid, &(shape.shape_from_world * *world_from_box), 0.0)
        };
        self.tree.find(|bounds| bounds.overlaps(&around), touches)
    }

    fn part_hit(
        &self,
        part: &Part,
        world_from_node: &Pose,
        margin: f64,
        nearby: &Nearby,
    ) -> Option<usize> {
        let world_from_part = *world_from_node * part.node_from_part;
        let rotation = DMat3::from_quat(world_from_part.rotation);
        let around = part.bounds.transformed(&rotation, world_from_part.translation).grown(margin);
        let touches = |index: usize| {
            let shape = &self.shapes[index];
            is_within(
                &shape.solid,
                &part.solid,
                &(shape.shape_from_world * world_from_part),
                margin,
            )
        };
        if nearby.is_all {
            let mut near = nearby
                .shapes
                .iter()
                .filter(|(_, bounds)| bounds.overlaps(&around))
                .map(|&(index, _)| index as usize);
            return near.find(|&index| touches(index));
        }
        self.tree.find(|bounds| bounds.overlaps(&around), touches)
    }

    /// Heap bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.shapes.as_slice())
            + size_of_val(self.boxes.as_slice())
            + self.shapes.iter().map(|shape| shape.solid.bytes()).sum::<usize>()
            + self.tree.bytes()
    }
}

/// A pose moved by `distance` along `normal`, a direction in its own frame.
pub fn lifted(pose: &Pose, normal: DVec3, distance: f64) -> Pose {
    Pose::from_parts(pose.translation + pose.rotation * normal * distance, pose.rotation)
}
