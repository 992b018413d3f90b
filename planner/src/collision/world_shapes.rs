//! The world's shapes in a bounding volume hierarchy.

use glam::{DMat3, DQuat, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::world::world::World;

use crate::collision::robot_bodies::{CollisionBody, Part};
use crate::collision::tuning::NEARBY_MAX;
use crate::geometry::bvh::{Aabb, Bvh};
use crate::geometry::narrow_phase::is_within;
use crate::geometry::shape_error::ShapeError;
use crate::geometry::solid::{Convex, Core, Solid};

/// The compiled shapes of the world.
#[derive(Debug, Clone)]
pub(crate) struct WorldShapes {
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

/// The shapes near the robot, listed once for all of its bodies.
#[derive(Debug)]
pub(crate) struct Nearby {
    shapes: heapless::Vec<(u32, Aabb), NEARBY_MAX>,
    /// Whether the list is complete; otherwise each body queries the tree.
    is_complete: bool,
}

impl Nearby {
    /// An incomplete list.
    pub(crate) const INCOMPLETE: Self = Self { shapes: heapless::Vec::new(), is_complete: false };

    /// The indices of the listed shapes.
    pub(crate) fn indices(&self) -> impl Iterator<Item = usize> + '_ {
        self.shapes.iter().map(|(index, _)| *index as usize)
    }

    /// Their bounding boxes.
    pub(crate) fn boxes(&self) -> impl Iterator<Item = &Aabb> + '_ {
        self.shapes.iter().map(|(_, bounds)| bounds)
    }
}

impl WorldShapes {
    /// Compiles a world.
    ///
    /// # Errors
    /// A shape or its pose cannot be used.
    pub(crate) fn new(world: &World) -> Result<Self, ShapeError> {
        let mut shapes = Vec::with_capacity(world.shapes.len());
        let mut bounds = Vec::with_capacity(world.shapes.len());
        for shape in &world.shapes {
            let owner = format!("world shape '{}'", shape.name);
            ShapeError::require_finite(&shape.world_from_shape, &owner)?;
            let solid = Solid::new(&shape.shape, &owner)?;
            let rotation = DMat3::from_quat(shape.world_from_shape.rotation);
            bounds.push(solid.aabb().transformed(&rotation, shape.world_from_shape.translation));
            shapes.push(PlacedSolid { shape_from_world: shape.world_from_shape.inverse(), solid });
        }
        let all = bounds.iter().copied().fold(Aabb::EMPTY, Aabb::union);
        Ok(Self { shapes, tree: Bvh::new(&bounds, 1), boxes: bounds, bounds: all })
    }

    /// Bounding box of all shapes.
    pub(crate) fn bounds(&self) -> Aabb {
        self.bounds
    }

    /// The shapes whose bounding boxes overlap a box.
    pub(crate) fn nearby(&self, around: &Aabb) -> Nearby {
        let mut shapes = heapless::Vec::new();
        let is_full = |index: usize| shapes.push((index as u32, self.boxes[index])).is_err();
        let is_complete = self.tree.find(|bounds| bounds.overlaps(around), is_full).is_none();
        Nearby { shapes, is_complete }
    }

    /// Calls `examine` with the bounding box of each shape that overlaps a box.
    pub(crate) fn for_each_box(&self, around: &Aabb, mut examine: impl FnMut(&Aabb)) {
        self.tree.find(
            |bounds| bounds.overlaps(around),
            |index| {
                if self.boxes[index].overlaps(around) {
                    examine(&self.boxes[index]);
                }
                false
            },
        );
    }

    /// Whether the bounding box of any shape comes within `reach` (m) of a point; `nearby` lists
    /// all candidates or is incomplete.
    pub(crate) fn reaches(&self, center: DVec3, reach: f64, nearby: &Nearby) -> bool {
        if nearby.is_complete {
            return nearby.shapes.iter().any(|(_, bounds)| bounds.reaches(center, reach));
        }
        self.tree.find(|bounds| bounds.reaches(center, reach), |_| true).is_some()
    }

    /// The first shape within `margin` (m) of a body, in the tree's order; `nearby` lists all
    /// candidates or is incomplete.
    pub(crate) fn hit(
        &self,
        body: &CollisionBody,
        world_from_node: &Pose,
        margin: f64,
        nearby: &Nearby,
    ) -> Option<usize> {
        let is_reached = self.reaches(
            *world_from_node * body.sphere.center,
            body.sphere.radius + margin,
            nearby,
        );
        is_reached.then(|| {
            body.parts.iter().find_map(|part| self.part_hit(part, world_from_node, margin, nearby))
        })?
    }

    /// The first shape that overlaps a box, in the tree's order.
    pub(crate) fn box_hit(&self, world_from_box: &Pose, half_extents: DVec3) -> Option<usize> {
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

    /// A lower bound of how far a point lies below the surface of a shape, m; minus infinity where
    /// no bound is known.
    pub(crate) fn depth(&self, index: usize, point: DVec3) -> f64 {
        let shape = &self.shapes[index];
        shape.solid.depth(shape.shape_from_world * point)
    }

    /// The first shape that a ball touches, in the tree's order.
    pub(crate) fn ball_hit(&self, center: DVec3, radius: f64) -> Option<usize> {
        let ball = Solid::Convex(Convex { core: Core::Point, radius });
        let touches = |index: usize| {
            let shape = &self.shapes[index];
            let shape_from_ball =
                Pose::from_parts(shape.shape_from_world * center, DQuat::IDENTITY);
            is_within(&shape.solid, &ball, &shape_from_ball, 0.0)
        };
        self.tree.find(|bounds| bounds.reaches(center, radius), touches)
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
        if nearby.is_complete {
            let mut near = nearby
                .shapes
                .iter()
                .filter(|(_, bounds)| bounds.overlaps(&around))
                .map(|&(index, _)| index as usize);
            return near.find(|&index| touches(index));
        }
        self.tree.find(|bounds| bounds.overlaps(&around), touches)
    }

    /// Heap memory, bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.shapes.as_slice())
            + size_of_val(self.boxes.as_slice())
            + self.shapes.iter().map(|shape| shape.solid.bytes()).sum::<usize>()
            + self.tree.bytes()
    }
}

/// A pose moved by `distance` (m) along `normal`, a direction in its own frame.
pub(crate) fn lifted(pose: &Pose, normal: DVec3, distance: f64) -> Pose {
    Pose::from_parts(pose.translation + pose.rotation * normal * distance, pose.rotation)
}
