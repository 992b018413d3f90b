//! Planes that a sole may lie in, features seen in them, and candidate placements on them.

use std::cmp::Ordering;

use glam::{DMat3, DQuat, DVec2, DVec3};
use surefoot_shared_types::Pose;

use crate::foot_placement::sole_fit::extent;
use crate::geometry::polygon::FACE_VERTICES_MAX;

/// A plane that a sole may lie in.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Plane {
    /// Origin straight above or below the ideal position, z its normal, x the ideal heading.
    pub world_from_plane: Pose,
    /// The normal in the world.
    pub normal: DVec3,
    /// Distance of the ideal position from the plane, m: a lower bound of the candidates' costs.
    pub distance: f64,
}

/// A feature seen in a plane.
#[derive(Debug, Clone)]
pub(crate) struct Footprint {
    /// A face's outline, a line's two ends, or a point; in the plane frame.
    pub outline: heapless::Vec<DVec2, FACE_VERTICES_MAX>,
    /// The unit direction across its narrow side.
    pub across: DVec2,
}

impl Footprint {
    /// Its extent along a direction, m.
    pub fn extent(&self, direction: DVec2) -> [f64; 2] {
        extent(self.outline.iter().copied(), direction)
    }
}

/// A placement to examine. The better of two candidates is the greater, so that a heap returns it
/// first.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Candidate {
    /// Smaller is tried first, m.
    pub cost: f64,
    /// The placement.
    pub world_from_sole: Pose,
}

impl Candidate {
    /// A fixed order among candidates of equal cost.
    fn rank(&self) -> f64 {
        let p = self.world_from_sole.translation;
        p.x + 3.0 * p.y + 7.0 * p.z + 11.0 * self.world_from_sole.rotation.z
    }
}

impl Ord for Candidate {
    fn cmp(&self, other: &Self) -> Ordering {
        other.cost.total_cmp(&self.cost).then_with(|| other.rank().total_cmp(&self.rank()))
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Candidate {}

/// The pose at `position` whose z axis is `normal` (pointing up) and whose x axis, seen from above,
/// has the heading `yaw` (rad).
pub(crate) fn pose_on_plane(position: DVec3, normal: DVec3, yaw: f64) -> Pose {
    let (sin, cos) = libm::sincos(yaw);
    let heading = DVec3::new(cos, sin, 0.0);
    let x = (heading * normal.z - DVec3::Z * heading.dot(normal)).normalize();
    Pose::from_parts(
        position,
        DQuat::from_mat3(&DMat3::from_cols(x, normal.cross(x), normal)).normalize(),
    )
}
