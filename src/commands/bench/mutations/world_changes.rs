//! Changes of the world and of the robot's strength.

use glam::{DQuat, DVec3};
use surefoot_shared_types::base::spatial::rotation_about;
use surefoot_shared_types::plan_format::blocks::{PoseBlock, SceneShapeBlock, ShapeBlock};

use super::subject::{Subject, push, turn};

/// How far from the root an obstacle is put, m.
const OBSTACLE_REACH: f64 = 0.6;

/// A shape is elsewhere, m.
pub(super) fn move_shape(subject: &mut Subject, size: f64) -> bool {
    let way = size * subject.direction();
    push(&mut shape_near_foot(subject).pose.xyz, way);
    true
}

/// A shape is turned about its middle, rad.
pub(super) fn turn_shape(subject: &mut Subject, size: f64) -> bool {
    let rotation = rotation_about(subject.direction(), size);
    turn(&mut shape_near_foot(subject).pose.quat_xyzw, rotation);
    true
}

/// A box is smaller by this factor, with its top where it was.
pub(super) fn shrink_shape(subject: &mut Subject, factor: f64) -> bool {
    let shape = shape_near_foot(subject);
    let ShapeBlock::Box { half_extents } = &mut shape.shape else { return false };
    let up = DQuat::from_array(shape.pose.quat_xyzw) * DVec3::Z;
    let lower = half_extents[2] * (1.0 - 1.0 / factor);
    *half_extents = half_extents.map(|half| half / factor);
    push(&mut shape.pose.xyz, lower * up);
    true
}

/// A shape near a foot is not there.
pub(super) fn remove_shape(subject: &mut Subject, _: f64) -> bool {
    let name = shape_near_foot(subject).name.clone();
    subject.plan.scene.shapes.retain(|shape| shape.name != name);
    !subject.plan.scene.shapes.is_empty()
}

/// The ground is so many times more slippery.
pub(super) fn slippery(subject: &mut Subject, factor: f64) -> bool {
    subject.plan.scene.mu /= factor;
    true
}

/// A cube with this half side is somewhere near the robot's way, m.
pub(super) fn obstacle(subject: &mut Subject, size: f64) -> bool {
    let (at, way) = (subject.waypoint(), subject.direction());
    let root = DVec3::from(subject.plan.waypoints[at].root_xyz);
    let reach = subject.random.uniform(0.0, OBSTACLE_REACH);
    let xyz = (root + reach * way).to_array();
    subject.plan.scene.shapes.push(SceneShapeBlock {
        name: "obstacle".into(),
        pose: PoseBlock { xyz, quat_xyzw: DQuat::IDENTITY.to_array() },
        shape: ShapeBlock::Box { half_extents: [size; 3] },
    });
    true
}

/// All motors are weaker by this factor.
pub(super) fn weaken(subject: &mut Subject, factor: f64) -> bool {
    let scale = &mut subject.plan.robot.effort_scale;
    *scale = Some(scale.unwrap_or(1.0) / factor);
    true
}

/// The shape of the world whose middle is nearest to a foothold.
fn shape_near_foot(subject: &mut Subject) -> &mut SceneShapeBlock {
    let sole = DVec3::from(subject.contact().sole_pose.xyz);
    let shapes = &mut subject.plan.scene.shapes;
    let distance = |shape: &SceneShapeBlock| DVec3::from(shape.pose.xyz).distance(sole);
    let nearest = (0..shapes.len())
        .min_by(|&a, &b| distance(&shapes[a]).total_cmp(&distance(&shapes[b])))
        .unwrap_or(0);
    &mut shapes[nearest]
}
