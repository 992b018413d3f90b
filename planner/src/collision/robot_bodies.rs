//! The robot's links as bodies: solids with the balls around them, and which of them stand on the
//! ground.

use glam::{DAffine3, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::robot::model::{Link, RobotModel};

use crate::geometry::CollisionError;
use crate::geometry::bvh::Aabb;
use crate::geometry::distance::LineSegment;
use crate::geometry::narrow_phase::segment_within;
use crate::geometry::solid::Solid;
use crate::kinematics::KinematicTree;
use crate::kinematics::tree::affine;
use crate::robot::bounding_spheres::{
    BODIES_MAX, BodySphere, BoundingSphere, body_spheres, shape_sphere,
};

/// One collision shape of a link.
#[derive(Debug, Clone)]
pub struct Part {
    /// The solid's frame in the node's.
    pub node_from_part: Pose,
    /// The same, inverse.
    pub part_from_node: DAffine3,
    /// The solid.
    pub solid: Solid,
    /// The box around the solid in its own frame.
    pub bounds: Aabb,
    /// A sphere around it, in the node's frame.
    pub sphere: BoundingSphere,
    /// The core in the node's frame where it is a point or a segment; the solid is all within its
    /// radius of it.
    pub core_segment: Option<LineSegment>,
}

/// A link with at least one collision shape.
#[derive(Debug, Clone)]
pub struct CollisionBody {
    /// The link.
    pub link: usize,
    /// The node that carries it.
    pub node: usize,
    /// That node's link, whose frame is the node's.
    pub node_link: usize,
    /// The link's frame in the node's.
    pub node_from_link: Pose,
    /// Its shapes.
    pub parts: Vec<Part>,
    /// A sphere around them all, in the node's frame.
    pub sphere: BoundingSphere,
    /// The foot that it is, or is rigidly joined to.
    pub foot: Option<FootBody>,
}

/// What a body knows of the foot that it belongs to.
#[derive(Debug, Clone, Copy)]
pub struct FootBody {
    /// Index into `RobotModel::feet`.
    pub limb: usize,
    /// This body's node frame in the sole frame.
    pub sole_from_node: Pose,
    /// The sole's normal, out of the ground, in this body's node frame.
    pub node_normal: DVec3,
}

impl CollisionBody {
    /// All bodies of a robot, first those of held nodes, in link order.
    pub fn all(model: &RobotModel, tree: &KinematicTree) -> Result<Vec<Self>, CollisionError> {
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

    /// Heap bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(self.parts.as_slice())
            + self.parts.iter().map(|part| part.solid.bytes()).sum::<usize>()
    }
}

impl Part {
    fn all(link: &Link, node_from_link: &Pose) -> Result<Vec<Self>, CollisionError> {
        let parts = link.shapes.iter().enumerate().map(|(index, placed)| {
            let owner = format!("link '{}', shape {index}", link.name);
            if !placed.link_from_shape.is_finite() {
                return Err(CollisionError::BadNumber {
                    owner,
                    what: "the pose",
                    requirement: "finite",
                });
            }
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
}

impl Part {
    /// Whether a segment in the frame in which the node's frame is `frame` comes within `reach` (m)
    /// of this part.
    pub fn is_within_of_segment(
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
