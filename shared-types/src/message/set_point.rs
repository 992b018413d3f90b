//! Set-points for a joint controller: the accepted plan in real time, at a fixed rate.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::base::limits::CONTACTS_MAX;
use crate::message::chunk::{SupportMode, Waypoint, is_rotation};
use crate::message::layout::layout;

/// The layout version in [`SetPoint::schema`].
pub const SET_POINT_SCHEMA: u64 = 2;
/// Flag: no chunk follows in time. The robot brakes, or stands where it has braked.
pub const FLAG_STARVED: u32 = 1;
/// Flag: the robot stands at the end of its plan.
pub const FLAG_FINISHED: u32 = 2;
/// Flag: the sampler has missed chunks. The robot brakes and stands until a plan begins there.
pub const FLAG_MISSED: u32 = 4;
/// Flag: the contact wrenches are stated, and torques where the plan states none. Without it the
/// wrenches are 0.
pub const FLAG_LOADS: u32 = 8;

/// Where a foot is, and when that changes.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.FootSchedule.v2")]
pub struct FootSchedule {
    /// 1 while the foot carries the robot, 0 while it swings.
    pub in_contact: u64,
    /// Plan time at which the foot lifts off or is set down next, s; -1 if that is not
    /// planned yet.
    pub changes_at: f64,
    /// 1 if position and rotation are known: where the sole stands or will be set down.
    pub has_pose: u64,
    /// Position of the sole in the world, m.
    pub position: [f64; 3],
    /// Rotation of the sole in the world, unit quaternion x, y, z, w.
    pub rotation: [f64; 4],
    /// Force of the ground on the foot in the world, N.
    pub force: [f64; 3],
    /// Moment of the ground on the foot about `position`, in the world, N m.
    pub moment: [f64; 3],
}

/// What the joints are to do at an instant. While no chunk follows in time the robot brakes along
/// its path as the last chunk says, and stands: the same point at zero velocity is published at
/// every tick, with [`FLAG_STARVED`].
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.SetPoint.v2")]
pub struct SetPoint {
    /// [`SET_POINT_SCHEMA`].
    pub schema: u64,
    /// The sampler's id.
    pub sampler_id: u64,
    /// The session of the planner.
    pub session: u64,
    /// The plan.
    pub plan_id: u64,
    /// Its epoch.
    pub epoch: u64,
    /// Sequence number of its chunk.
    pub sequence: u64,
    /// Number of this sampler's tick, from 1; a gap shows a missed message.
    pub tick: u64,
    /// [`FLAG_STARVED`], [`FLAG_FINISHED`], [`FLAG_MISSED`], [`FLAG_LOADS`].
    pub flags: u32,
    /// A [`SupportMode`] as its wire value.
    pub mode: u32,
    /// Seconds of the plan a second, 0 to 1.
    pub rate: f64,
    /// The robot. Its time is that of the plan; velocities and accelerations are those at `rate`.
    /// The torque is the plan's, 0 where neither the plan nor [`FLAG_LOADS`] states one.
    pub waypoint: Waypoint,
    /// Left and right foot; the other entries are zero.
    pub feet: [FootSchedule; CONTACTS_MAX],
}

const _: () = assert!(size_of::<FootSchedule>() == 128);
const _: () = assert!(
    size_of::<SetPoint>() == 72 + size_of::<Waypoint>() + CONTACTS_MAX * size_of::<FootSchedule>()
);

layout!(FootSchedule {
    in_contact: u64,
    changes_at: f64,
    has_pose: u64,
    position: [f64; 3],
    rotation: [f64; 4],
    force: [f64; 3],
    moment: [f64; 3],
} with []);
layout!(SetPoint {
    schema: u64,
    sampler_id: u64,
    session: u64,
    plan_id: u64,
    epoch: u64,
    sequence: u64,
    tick: u64,
    flags: u32,
    mode: u32,
    rate: f64,
    waypoint: Waypoint,
    feet: [FootSchedule; CONTACTS_MAX],
} with [Waypoint, FootSchedule]);

impl FootSchedule {
    /// Whether all numbers are finite, and the rotation is one if it is known.
    fn is_well_formed(&self) -> bool {
        let pose = self.position.into_iter().chain(self.rotation).chain([self.changes_at]);
        let numbers = pose.chain(self.force).chain(self.moment);
        self.in_contact <= 1
            && self.has_pose <= 1
            && numbers.into_iter().all(f64::is_finite)
            && (self.has_pose == 0 || is_rotation(self.rotation))
    }
}

impl SetPoint {
    /// Whether the schema and the mode are valid, all numbers are finite and all rotations are.
    pub fn is_well_formed(&self) -> bool {
        let Self { waypoint, .. } = self;
        let pose = [waypoint.time, self.rate].into_iter().chain(waypoint.root_position);
        self.schema == SET_POINT_SCHEMA
            && self.sampler_id != 0
            && SupportMode::from_wire(self.mode).is_some()
            && pose.chain(waypoint.q).chain(waypoint.rates()).all(f64::is_finite)
            && is_rotation(waypoint.root_rotation)
            && self.feet.iter().all(FootSchedule::is_well_formed)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_set_point_with_a_foreign_number_is_refused() {
        let mut point = SetPoint { schema: SET_POINT_SCHEMA, sampler_id: 4, ..SetPoint::zeroed() };
        point.waypoint.root_rotation = [0.0, 0.0, 0.0, 1.0];
        assert!(point.is_well_formed());
        let refused = |change: &dyn Fn(&mut SetPoint)| {
            let mut other = point;
            change(&mut other);
            assert!(!other.is_well_formed());
        };
        refused(&|other| other.schema += 1);
        refused(&|other| other.mode = 3);
        refused(&|other| other.waypoint.joint_velocity[3] = f64::INFINITY);
        refused(&|other| other.waypoint.root_rotation = [0.0; 4]);
        refused(&|other| other.feet[1].has_pose = 1);
        refused(&|other| other.feet[0].in_contact = 2);
        refused(&|other| other.feet[0].force[2] = f64::NAN);
    }
}
