//! Solids on the links of the robot and in the world.

use surefoot_shared_types::robot::model::{LinkIndex, RobotModel};
use surefoot_shared_types::world::world::World;
use surefoot_shared_types::{Pose, Shape};

use crate::geometry::bounds::Bounds;
use crate::geometry::solid::Solid;

/// A solid with its pose in the frame of its link, or in the world.
#[derive(Debug, Clone)]
pub struct CollisionBody {
    /// The link it belongs to; `None` for a part of the world.
    pub link: Option<LinkIndex>,
    /// The link's or the world shape's name.
    pub name: String,
    /// The solid's frame in the link's or the world's.
    pub frame_from_solid: Pose,
    /// The solid.
    pub solid: Solid,
    /// The box around the solid, in its own frame.
    pub local_bounds: Bounds,
    /// The largest distance of any of its points from the origin of the link or of the world, m.
    pub reach: f64,
}

impl CollisionBody {
    fn new(
        link: Option<LinkIndex>,
        name: &str,
        frame_from_solid: Pose,
        shape: &Shape,
    ) -> Result<Self, String> {
        let solid = Solid::new(shape).map_err(|error| format!("{name}: {error}"))?;
        let local_bounds = solid.local_bounds();
        let reach = solid.reach_from(frame_from_solid.inverse().translation);
        Ok(Self { link, name: name.to_owned(), frame_from_solid, solid, local_bounds, reach })
    }

    /// All collision shapes of a robot.
    ///
    /// # Errors
    /// A shape has no form that the checker can compute with.
    pub fn of_robot(model: &RobotModel) -> Result<Vec<Self>, String> {
        let shapes =
            model.links.iter().enumerate().flat_map(|(index, link)| {
                link.shapes.iter().map(move |shape| (index, link, shape))
            });
        shapes
            .map(|(index, link, shape)| {
                Self::new(Some(index), &link.name, shape.link_from_shape, &shape.shape)
            })
            .collect()
    }

    /// All shapes of a world.
    ///
    /// # Errors
    /// A shape has no form that the checker can compute with.
    pub fn of_world(world: &World) -> Result<Vec<Self>, String> {
        world
            .shapes
            .iter()
            .map(|shape| Self::new(None, &shape.name, shape.world_from_shape, &shape.shape))
            .collect()
    }
}

/// The pose of a solid at an instant.
#[derive(Debug, Clone, Copy)]
pub struct SolidPose {
    /// The solid's frame in the world.
    pub world_from_solid: Pose,
    /// The box around the solid, in the world.
    pub bounds: Bounds,
}

impl SolidPose {
    /// The pose of a body whose frame is at `world_from_frame`.
    pub fn new(body: &CollisionBody, world_from_frame: &Pose) -> Self {
        let world_from_solid = *world_from_frame * body.frame_from_solid;
        Self { world_from_solid, bounds: body.local_bounds.transformed(&world_from_solid) }
    }
}
