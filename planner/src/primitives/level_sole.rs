//! Level soles: primitives depend on a placement's ankle and heading, and the foot turns below the
//! ankle.

use bytemuck::{Pod, Zeroable};
use glam::{DQuat, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{rotation_about, wrap_angle, yaw_of};

use crate::kinematics::Leg;

/// The pose of a sole without tilt, with the same ankle position and heading.
#[derive(Debug, Clone, Copy)]
pub struct LevelSole {
    /// The level sole's origin in the world, m.
    pub origin: DVec3,
    /// Its heading in the world, rad.
    pub yaw: f64,
    /// The inclination of the true sole, rad.
    pub tilt: f64,
}

/// The position and turn of one foot's [`LevelSole`] relative to the other's.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct PairOffset {
    /// Distance ahead, m.
    pub ahead: f64,
    /// Distance to the side of the foot, m.
    pub aside: f64,
    /// Height above, m.
    pub above: f64,
    /// Outward turn, rad.
    pub turn: f64,
}

impl LevelSole {
    /// The level sole of a leg's sole.
    pub fn of(leg: &Leg, world_from_sole: &Pose) -> Self {
        let yaw = yaw_of(world_from_sole.rotation);
        let ankle = *world_from_sole * leg.sole_from_ankle();
        let normal = world_from_sole.rotation * DVec3::Z;
        let tilt = libm::atan2(normal.truncate().length(), normal.z);
        Self { origin: ankle - rotation_about(DVec3::Z, yaw) * leg.sole_from_ankle(), yaw, tilt }
    }

    /// The level sole's frame in the world.
    pub fn world_from_level_sole(&self) -> Pose {
        Pose::from_parts(self.origin, rotation_about(DVec3::Z, self.yaw))
    }

    /// The sole turned to `world_from_sole` below the level sole's ankle.
    pub fn sole(&self, leg: &Leg, world_from_sole: DQuat) -> Pose {
        let ankle = self.world_from_level_sole() * leg.sole_from_ankle();
        Pose::from_parts(ankle - world_from_sole * leg.sole_from_ankle(), world_from_sole)
    }

    /// The offset of the other foot, `limb`, from this one.
    pub fn offset_to(&self, other: &Self, limb: usize) -> PairOffset {
        let offset = self.world_from_level_sole().inverse() * other.origin;
        let side = side_of(limb);
        PairOffset {
            ahead: offset.x,
            aside: side * offset.y,
            above: offset.z,
            turn: side * wrap_angle(other.yaw - self.yaw),
        }
    }

    /// The level sole of the foot `limb` at an offset from this one.
    pub fn at_offset(&self, offset: &PairOffset, limb: usize) -> Self {
        let side = side_of(limb);
        let origin = self.world_from_level_sole()
            * DVec3::new(offset.ahead, side * offset.aside, offset.above);
        Self { origin, yaw: self.yaw + side * offset.turn, tilt: 0.0 }
    }
}

/// The lateral side of a foot: 1 for the left one, -1 for the right one.
pub fn side_of(limb: usize) -> f64 {
    if limb == 0 { 1.0 } else { -1.0 }
}
