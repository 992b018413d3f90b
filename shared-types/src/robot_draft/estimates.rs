//! Estimates of what a URDF does not state: efforts, velocities and inertias.

use glam::DVec3;

use crate::robot::urdf_link::LIGHT_MAX;
use crate::robot_draft::body::LinkShapes;
use crate::robot_draft::skeleton::{NodeIndex, RANGE, Skeleton, lacks_range};

/// Effort of a leg's joint, N m per kg of the whole robot. Knees of published humanoids lie between
/// 2 and 6.
const LEG_EFFORT: f64 = 3.0;
/// Effort of any other joint, N m per kg of the whole robot.
const OTHER_EFFORT: f64 = 0.5;
/// Speed of a joint, rad/s; geared joints of humanoids reach 4 to 20.
const VELOCITY: f64 = 4.0;
/// The least extent that stands for a link, m.
const EXTENT_MIN: f64 = 0.02;

/// The effort of a joint that the URDF does not state; `None` where it does.
pub(crate) fn missing_effort(skeleton: &Skeleton, node: NodeIndex, is_leg: bool) -> Option<f64> {
    let stated = skeleton.urdf_joint(node)?.limit.as_ref().and_then(|limit| limit.effort);
    let is_missing = !stated.is_some_and(|effort| effort != 0.0);
    let share = if is_leg { LEG_EFFORT } else { OTHER_EFFORT };
    is_missing.then(|| share * skeleton.mass_below(0))
}

/// The speed of a joint that the URDF does not state; `None` where it does.
pub(crate) fn missing_velocity(skeleton: &Skeleton, node: NodeIndex) -> Option<f64> {
    let stated = skeleton.urdf_joint(node)?.limit.as_ref().and_then(|limit| limit.velocity);
    (!stated.is_some_and(|velocity| velocity != 0.0)).then_some(VELOCITY)
}

/// The range of a joint that the URDF does not state; `None` where it does.
pub(crate) fn missing_range(skeleton: &Skeleton, node: NodeIndex) -> Option<[f64; 2]> {
    lacks_range(skeleton.urdf_joint(node)?).then_some([-RANGE, RANGE])
}

/// The moments of inertia of a link whose inertia is 0: those of a box of its mass around its
/// shapes.
pub(crate) fn missing_inertia(
    skeleton: &Skeleton,
    shapes: &LinkShapes,
    node: NodeIndex,
) -> Option<DVec3> {
    let link = &skeleton.urdf.links[skeleton.nodes[node].urdf_link];
    if link.mass <= LIGHT_MAX || link.inertia != glam::DMat3::ZERO {
        return None;
    }
    let surface = shapes.surface(skeleton, node);
    let size = DVec3::from_array(DVec3::AXES.map(|axis| {
        let size = surface.extent(axis) + surface.extent(-axis);
        if size.is_finite() { size.max(EXTENT_MIN) } else { EXTENT_MIN }
    }));
    let squares = size * size;
    Some(link.mass / 12.0 * (DVec3::splat(squares.element_sum()) - squares))
}
