//! Limits of the centre of pressure from the ankle's torques.
//!
//! The torque of an ankle joint grows with the distance between the centre of pressure and the
//! joint's axis, whatever the posture of the rest of the robot. So each joint admits a strip of the
//! sole.

use glam::DVec2;
use heapless::Vec as BoundedVec;
use surefoot_shared_types::base::limits::POLYGON_VERTICES_MAX;
use surefoot_shared_types::robot::model::JointKind;
use surefoot_shared_types::world::world::GRAVITY;

use crate::geometry::polygon::{HalfPlane, area_and_centroid, clipped_to};
use crate::kinematics::leg::Leg;
use crate::robot::mass_tree::MassTree;
use crate::robot::tuning::{ANKLE_JOINTS, ANKLE_REGION_SHARE_MIN};

/// Each half plane adds at most one vertex.
const CLIPPED_MAX: usize = POLYGON_VERTICES_MAX + 2 * ANKLE_JOINTS;

/// A polygon after clipping, in the sole frame, m.
type Clipped = BoundedVec<DVec2, CLIPPED_MAX>;

/// Half planes of the sole frame in which the ankle can hold the robot's weight, for a level sole.
#[derive(Debug, Clone, Default)]
pub struct AnkleLimits {
    half_planes: BoundedVec<HalfPlane, { 2 * ANKLE_JOINTS }>,
}

impl AnkleLimits {
    /// The limits of a leg in the standing posture. The half planes are wider by `margin` (m),
    /// since the centre of mass keeps that margin to the border of the region.
    pub fn new(leg: &Leg, standing_q: &[f64], mass_tree: &MassTree, margin: f64) -> Self {
        let sole_from_root = leg.root_from_sole(standing_q).inverse();
        let ankle = leg.axes(standing_q).skip(leg.joints().len().saturating_sub(ANKLE_JOINTS));
        let mut half_planes = BoundedVec::new();
        for (joint, root_from_joint) in ankle.filter(|(joint, _)| joint.kind == JointKind::Revolute)
        {
            let motion = sole_from_root * root_from_joint;
            let (axis, point) = (motion.rotation * joint.axis, motion * joint.point);
            // A vertical force of 1 N at p has the torque `arm . (p - point)`, in m.
            let arm = DVec2::new(-axis.y, axis.x);
            let torque_max = mass_tree.usable_effort(joint.index) / (mass_tree.mass() * GRAVITY)
                + margin * arm.length();
            let center = arm.dot(point.truncate());
            half_planes.extend(
                [(-arm, -(torque_max + center)), (arm, -(torque_max - center))]
                    .map(|(normal, offset)| HalfPlane { normal, offset }),
            );
        }
        Self { half_planes }
    }

    /// The part of a polygon (sole frame, m) in which the ankle can hold the weight. If almost
    /// nothing is left the whole polygon is returned, and the torque check decides.
    pub fn clip(&self, polygon: &[DVec2]) -> Clipped {
        let whole: Clipped = polygon.iter().copied().take(POLYGON_VERTICES_MAX).collect();
        let clipped = self
            .half_planes
            .iter()
            .fold(whole.clone(), |clipped, half_plane| clipped_to(&clipped, half_plane));
        if area_and_centroid(&clipped).0 < ANKLE_REGION_SHARE_MIN * area_and_centroid(&whole).0 {
            whole
        } else {
            clipped
        }
    }
}
