//! Whether two bodies of the robot come within a margin of each other.

use glam::DAffine3;
use surefoot_shared_types::Pose;

use crate::collision::robot_bodies::{CollisionBody, Part};
use crate::geometry::distance::{exceeds, segment_segment_distance_squared};
use crate::geometry::narrow_phase::is_within;
use crate::kinematics::tree::{affine, pose};

/// Whether two bodies come within `margin` (m) of each other, for these poses of their nodes.
pub(crate) fn bodies_within(
    a: &CollisionBody,
    world_from_a: &Pose,
    b: &CollisionBody,
    world_from_b: &Pose,
    margin: f64,
) -> bool {
    let (world_from_a, world_from_b) = (affine(world_from_a), affine(world_from_b));
    let reach = a.sphere.radius + b.sphere.radius + margin;
    let centers = [
        world_from_a.transform_point3(a.sphere.center),
        world_from_b.transform_point3(b.sphere.center),
    ];
    !exceeds(centers[0].distance_squared(centers[1]), reach * reach)
        && parts_within((a, &world_from_a), (b, &world_from_b), margin)
}

/// Whether two bodies whose spheres are near each other come within `margin` (m) of each other. The
/// frames of their nodes are given in any common frame.
pub(crate) fn parts_within(
    a: (&CollisionBody, &DAffine3),
    b: (&CollisionBody, &DAffine3),
    margin: f64,
) -> bool {
    b.0.parts.iter().any(|part_b| {
        let center_b = b.1.transform_point3(part_b.sphere.center);
        a.0.parts.iter().any(|part_a| {
            let reach = part_a.sphere.radius + part_b.sphere.radius + margin;
            let center_a = a.1.transform_point3(part_a.sphere.center);
            let is_near = !exceeds((center_b - center_a).length_squared(), reach * reach);
            is_near && two_parts_within((part_a, a.1), (part_b, b.1), margin)
        })
    })
}

/// Whether two parts whose spheres are near each other come within `margin` (m) of each other.
fn two_parts_within(a: (&Part, &DAffine3), b: (&Part, &DAffine3), margin: f64) -> bool {
    match (&a.0.core_segment, &b.0.core_segment) {
        // Both parts are spheres, which were compared before.
        (Some(core_a), Some(core_b)) if core_a.is_point() && core_b.is_point() => true,
        (Some(core_a), Some(core_b)) => {
            let reach = a.0.solid.radius() + b.0.solid.radius() + margin;
            !exceeds(
                segment_segment_distance_squared(core_a.placed(a.1), core_b.placed(b.1)),
                reach * reach,
            )
        }
        (_, Some(core_segment)) => {
            a.0.is_within_of_segment(a.1, core_segment.placed(b.1), b.0.solid.radius() + margin)
        }
        (Some(core_segment), _) => {
            b.0.is_within_of_segment(b.1, core_segment.placed(a.1), a.0.solid.radius() + margin)
        }
        (None, None) => {
            let [from_a, from_b] = [a, b].map(|(part, frame)| pose(frame) * part.node_from_part);
            is_within(&a.0.solid, &b.0.solid, &from_a.inv_mul(&from_b), margin)
        }
    }
}
