//! The robot's links as collision bodies: solids with bounding spheres.

use glam::{DAffine3, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::model::{Link, RobotModel};

use crate::collision::error::CollisionError;
use crate::geometry::bvh::Aabb;
use crate::geometry::distance::LineSegment;
use crate::geometry::narrow_phase::segment_within;
use crate::geometry::shape_error::ShapeError;
use crate::geometry::solid::Solid;
use crate::kinematics::tree::{KinematicTree, affine};
use crate::robot::bounding_spheres::{
    BODIES_MAX, BodySphere, BoundingSphere, body_spheres, shape_sphere,
};

/// One collision shape of a link.
#[derive(Debug, Clone)]
pub(crate) struct Part {
    /// Pose of the solid in the node's frame.
    pub(crate) node_from_part: Pose,
    /// Its inverse.
    pub(crate) part_from_node: DAffine3,
    /// The solid.
    pub(crate) solid: Solid,
    /// Bounding box of the solid in its own frame.
    pub(crate) bounds: Aabb,
    /// Bounding sphere in the node's frame.
    pub(crate) sphere: BoundingSphere,
    /// The core in the node's frame, if it is a point or a segment; the solid consists of all
    /// points within its radius of the core.
    pub(crate) core_segment: Option<LineSegment>,
}

/// A link with at least one collision shape.
#[derive(Debug, Clone)]
pub(crate) struct CollisionBody {
    /// Index of the link.
    pub(crate) link: usize,
    /// The node that moves it.
    pub(crate) node: usize,
    /// The node's own link, whose frame is the node's frame.
    pub(crate) node_link: usize,
    /// Pose of the link in the node's frame.
    pub(crate) node_from_link: Pose,
    /// Its collision shapes.
    pub(crate) parts: Vec<Part>,
    /// Bounding sphere of all shapes in the node's frame.
    pub(crate) sphere: BoundingSphere,
    /// The foot that the link is, or is fixed to.
    pub(crate) foot: Option<FootBody>,
}

/// The foot of a body.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FootBody {
    /// Index into `RobotModel::feet`.
    pub(crate) limb: usize,
    /// Pose of the body's node in the sole frame.
    pub(crate) sole_from_node: Pose,
    /// Normal of the sole, away from the ground, in the body's node frame.
    pub(crate) node_normal: DVec3,
}

impl CollisionBody {
    /// All bodies of a robot: first those of upper-body nodes, each group in link order.
    ///
    /// # Errors
    /// A shape cannot be used, or there are too many bodies.
    pub(crate) fn all(
        model: &RobotModel,
        tree: &KinematicTree,
    ) -> Result<Vec<Self>, CollisionError> {
        let bodies =
            body_spheres(model, tree).into_iter().map(|BodySphere { link, node, sphere }| {
                let node_from_link = tree.of_link(link).1;
                let parts = Part::all(&model.links[link], &node_from_link)?;
                let node_link = tree.nodes()[node].link;
                Ok(Self {
                    link,
                    node,
                    node_link,
                    node_from_link,
                    parts,
                    sphere,
                    foot: foot_of(model, tree, node),
                })
            });
        let bodies: Vec<Self> = bodies.collect::<Result<_, CollisionError>>()?;
        if bodies.len() > BODIES_MAX {
            return Err(CollisionError::TooManyBodies { count: bodies.len(), max: BODIES_MAX });
        }
        Ok(bodies)
    }

    /// Heap memory, bytes.
    pub(crate) fn bytes(&self) -> usize {
        size_of_val(self.parts.as_slice())
            + self.parts.iter().map(|part| part.solid.bytes()).sum::<usize>()
    }
}

impl Part {
    fn all(link: &Link, node_from_link: &Pose) -> Result<Vec<Self>, ShapeError> {
        let parts = link.shapes.iter().enumerate().map(|(index, placed)| {
            let owner = format!("link '{}', shape {index}", link.name);
            ShapeError::require_finite(&placed.link_from_shape, &owner)?;
            let solid = Solid::new(&placed.shape, &owner)?;
            let node_from_part = *node_from_link * placed.link_from_shape;
            let BoundingSphere { center, radius } = shape_sphere(&placed.shape);
            let sphere = BoundingSphere { center: node_from_part * center, radius };
            Ok(Self {
                bounds: solid.aabb(),
                core_segment: solid.core_segment(&node_from_part),
                part_from_node: affine(&node_from_part.inverse()),
                node_from_part,
                solid,
                sphere,
            })
        });
        parts.collect()
    }

    /// Whether a segment comes within `reach` (m) of this part. The segment and the node's frame
    /// `frame` are given in a common frame.
    pub(crate) fn is_within_of_segment(
        &self,
        frame: &DAffine3,
        core_segment: LineSegment,
        reach: f64,
    ) -> bool {
        let part_from_frame = |point: DVec3| {
            let r = &frame.matrix3;
            let point = point - frame.translation;
            self.part_from_node.transform_point3(DVec3::new(
                r.x_axis.dot(point),
                r.y_axis.dot(point),
                r.z_axis.dot(point),
            ))
        };
        let start = part_from_frame(core_segment.start);
        let core_segment = LineSegment {
            start,
            delta: part_from_frame(core_segment.start + core_segment.delta) - start,
        };
        segment_within(&self.solid, core_segment, reach)
    }
}

fn foot_of(model: &RobotModel, tree: &KinematicTree, node: usize) -> Option<FootBody> {
    let limb = model.feet.iter().position(|foot| tree.of_link(foot.link).0 == node)?;
    let foot = &model.feet[limb];
    let node_from_sole = tree.of_link(foot.link).1 * foot.link_from_sole;
    Some(FootBody {
        limb,
        sole_from_node: node_from_sole.inverse(),
        node_normal: node_from_sole.rotation * DVec3::Z,
    })
}
