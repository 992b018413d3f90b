//! A smooth whole-body path, as `timing` takes it: points with two derivatives, and spans of one
//! mode.
//!
//! Between two points of a span every coordinate is the quintic Hermite polynomial in the parameter
//! with the positions and derivatives of both points; the root's rotation is that of the rotation
//! vector from the point before: `R(s) = R_i exp(phi(s))`. The same rule holds in time between two
//! waypoints.

use glam::DVec3;
use heapless::Vec as BoundedVec;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::limits::JOINTS_MAX;
use surefoot_shared_types::message::{Contact, SupportMode};

use crate::constraints::foothold::Ground;
use crate::timing::tuning::{INCLINED_COSINE, LEVEL_HEIGHT_MAX};

/// Number of coordinates of a derivative: root position, root rotation, joints.
pub const VELOCITY_MAX: usize = crate::robot::inverse_dynamics::VELOCITY_MAX;

/// A configuration on a path with its derivatives by the path's parameter.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PathPoint {
    /// The path's parameter, strictly increasing within a span: about the time that the motion
    /// takes, s. Timing goes up to `RATE_MAX` times as fast.
    pub parameter: f64,
    /// Pose of the root in the world.
    pub world_from_root: Pose,
    /// Joint positions in the order of `RobotModel::joints`, rad or m; unused entries are 0.
    pub q: [f64; JOINTS_MAX],
    /// First derivatives: root position and rotation along world axes, then the joints.
    pub first: [f64; VELOCITY_MAX],
    /// Second derivatives, in the same order.
    pub second: [f64; VELOCITY_MAX],
}

impl Default for PathPoint {
    /// The point at the origin, which fills unused memory.
    fn default() -> Self {
        Self {
            parameter: 0.0,
            world_from_root: Pose::IDENTITY,
            q: [0.0; JOINTS_MAX],
            first: [0.0; VELOCITY_MAX],
            second: [0.0; VELOCITY_MAX],
        }
    }
}

/// A part of a path within one mode: from touch-down to lift-off, from lift-off to touch-down, or
/// a part of those.
///
/// The spans of a path follow each other without a gap: a span's first point is the last one of the
/// span before, with the same derivatives. Only where the path has a kink the robot rests
/// (`starts_at_rest`), and the span has a first point of its own: the same configuration with the
/// derivatives that follow.
#[derive(Debug, Clone, PartialEq)]
pub struct PathSpan {
    /// Index of its first point.
    pub first: usize,
    /// Index of its last point; greater than `first`.
    pub last: usize,
    /// Whether the robot rests at its first point: at the beginning of a path and at kinks.
    pub starts_at_rest: bool,
    /// The supporting feet.
    pub support: SupportMode,
    /// The stance feet with their poses and supported polygons, the left one first.
    pub contacts: BoundedVec<Contact, 2>,
    /// The ground under each foot, by limb: where it stands, or where it lands.
    pub grounds: [Ground; 2],
}

impl PathSpan {
    /// Whether a stance sole stands on uneven ground.
    pub fn is_uneven(&self) -> bool {
        self.contacts.iter().any(|contact| self.grounds[contact.limb as usize] != Ground::Even)
    }

    /// Whether a stance sole is inclined.
    pub fn is_inclined(&self) -> bool {
        let rise = |contact: &Contact| (contact.world_from_sole().rotation * DVec3::Z).z;
        self.contacts.iter().any(|contact| rise(contact) < INCLINED_COSINE)
    }

    /// Whether the stance soles lie in one level plane, on which pressure in their hull always has
    /// forces.
    pub fn is_level(&self) -> bool {
        let heights = || self.contacts.iter().map(|contact| contact.position[2]);
        let [low, high] =
            [heights().fold(f64::INFINITY, f64::min), heights().fold(f64::NEG_INFINITY, f64::max)];
        !self.is_inclined() && high - low <= LEVEL_HEIGHT_MAX
    }
}

/// A path: its points, and its spans in order.
#[derive(Debug, Clone, Copy)]
pub struct Path<'a> {
    /// The points.
    pub points: &'a [PathPoint],
    /// The spans known so far.
    pub spans: &'a [PathSpan],
}
