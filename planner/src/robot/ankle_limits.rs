//! Where on its sole an ankle can hold the robot's whole weight: its joints turn the sole against
//! the leg, so each of their torques grows with the distance of the centre of pressure from the
//! joint's axis, whatever the rest of the robot does.

use glam::DVec2;
use heapless::Vec as BoundedVec;
use surefoot_shared_types::base::limits::POLYGON_VERTICES_MAX;
use surefoot_shared_types::robot::model::JointKind;
use surefoot_shared_types::world::world::GRAVITY;

use crate::geometry::polygon::area_and_centroid;
use crate::kinematics::Leg;
use crate::robot::gravity_torques::Statics;

/// The last joints of a leg that count as its ankle.
const ANKLE_JOINTS: usize = 2;
/// Each half plane adds a vertex at most.
const CLIPPED_MAX: usize = POLYGON_VERTICES_MAX + 2 * ANKLE_JOINTS;
/// A smaller share of a polygon stands for nothing that an ankle can hold.
const SUPPORT_SHARE_MIN: f64 = 0.02;

/// A polygon on its way through the half planes.
type Clipped = BoundedVec<DVec2, CLIPPED_MAX>;

/// Half planes of a level sole's frame, outside of which a joint of the ankle would need more than
/// its usable effort.
#[derive(Debug, Clone)]
pub struct AnkleLimits {
    half_planes: BoundedVec<HalfPlane, { 2 * ANKLE_JOINTS }>,
}

/// The points `p` with `normal . p <= offset`.
#[derive(Debug, Clone, Copy)]
struct HalfPlane {
    normal: DVec2,
    offset: f64,
}

impl AnkleLimits {
    /// Of a leg in the standing posture. `margin` (m) is what the centre of mass keeps from the
    /// border of a region, so that the region may be that much larger.
    pub fn new(leg: &Leg, standing_q: &[f64], statics: &Statics, margin: f64) -> Self {
        let sole_from_root = leg.root_from_sole(standing_q).inverse();
        let ankle = leg.axes(standing_q).skip(leg.joints().len().saturating_sub(ANKLE_JOINTS));
        let mut half_planes = BoundedVec::new();
        for (joint, root_from_joint) in ankle.filter(|(joint, _)| joint.kind == JointKind::Revolute)
        {
            let motion = sole_from_root * root_from_joint;
            let (axis, point) = (motion.rotation * joint.axis, motion * joint.point);
            // The torque of a vertical force of 1 N at p is `arm . (p - point)`.
            let arm = DVec2::new(-axis.y, axis.x);
            let most = statics.usable_effort(joint.index) / (statics.mass() * GRAVITY)
                + margin * arm.length();
            let middle = arm.dot(point.truncate());
            half_planes.extend(
                [(arm, most + middle), (-arm, most - middle)]
                    .map(|(normal, offset)| HalfPlane { normal, offset }),
            );
        }
        Self { half_planes }
    }

    /// The part of a polygon (sole frame) that the ankle can hold; all of it where that is next to
    /// nothing, which torques tell then.
    pub fn clip(&self, polygon: &[DVec2]) -> Clipped {
        let whole: Clipped = polygon.iter().copied().take(POLYGON_VERTICES_MAX).collect();
        let clipped = self
            .half_planes
            .iter()
            .fold(whole.clone(), |clipped, half_plane| half_plane.clip(&clipped));
        if area_and_centroid(&clipped).0 < SUPPORT_SHARE_MIN * area_and_centroid(&whole).0 {
            whole
        } else {
            clipped
        }
    }
}

impl HalfPlane {
    fn clip(&self, polygon: &Clipped) -> Clipped {
        let excess = |point: &DVec2| self.normal.dot(*point) - self.offset;
        let mut kept = Clipped::new();
        let mut before = polygon.last().copied();
        for point in polygon {
            let (a, b) = (before.as_ref().map_or(0.0, excess), excess(point));
            if let Some(before) = before.filter(|_| (a > 0.0) != (b > 0.0)) {
                let _ = kept.push(before.lerp(*point, a / (a - b)));
            }
            if b <= 0.0 {
                let _ = kept.push(*point);
            }
            before = Some(*point);
        }
        kept
    }
}
