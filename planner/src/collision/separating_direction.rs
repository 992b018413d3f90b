//! Directions along which two bodies of the robot are usually apart: one projection replaces most
//! of the expensive distance tests.

use glam::{DAffine3, DVec3};
use parry3d_f64::shape::SupportMap;

use crate::collision::robot_bodies::Part;
use crate::geometry::solid::Solid;

/// A direction from one body to another along which they are apart in the standing posture.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SeparatingDirection {
    /// The direction, of length 1, in the first body's node frame.
    direction: DVec3,
    /// Extent of the first body along it from the node's origin, m.
    height: f64,
}

impl SeparatingDirection {
    /// A direction (of length 1, in the part's frame) with the extent of a convex part along it;
    /// `None` for a mesh.
    pub(crate) fn beyond(part: &Part, direction: DVec3) -> Option<Self> {
        let Solid::Convex(convex) = &part.solid else { return None };
        let in_node = part.node_from_part.rotation * direction;
        let top = part.node_from_part * convex.core.local_support_point(direction);
        Some(Self { direction: in_node, height: in_node.dot(top) + convex.radius })
    }

    /// Whether the second body's part is farther than `margin` (m) beyond the first body; `true` is
    /// certain. The frames of the nodes are given in any common frame.
    pub(crate) fn is_separated(
        &self,
        frame_a: &DAffine3,
        (part, frame_b): (&Part, &DAffine3),
        margin: f64,
    ) -> bool {
        let Solid::Convex(convex) = &part.solid else { return false };
        let direction = frame_a.matrix3 * self.direction;
        let b = &frame_b.matrix3;
        let in_node =
            DVec3::new(b.x_axis.dot(direction), b.y_axis.dot(direction), b.z_axis.dot(direction));
        let in_part = part.part_from_node.matrix3 * in_node;
        let part_origin = direction.dot(frame_b.translation - frame_a.translation)
            + in_node.dot(part.node_from_part.translation);
        let free = part_origin - self.height - margin;
        // The bounding box first, then the solid itself.
        let lowest =
            in_part.dot(part.bounds.center()) - in_part.abs().dot(part.bounds.half_extents());
        free + lowest > 0.0
            || free + in_part.dot(convex.core.local_support_point(-in_part)) - convex.radius > 0.0
    }
}
