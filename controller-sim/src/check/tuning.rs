//! The resolution of the physical checks. A finer resolution costs time and hides less between two
//! samples.

// Motion.

/// The largest joint (rad, m), root position (m) or root rotation (rad) change between two samples.
pub(crate) const SUBSTEP_MAX: f64 = 0.01;
/// Of the samples between two waypoints one in so many is checked: no joint turns by more than
/// 0.05 rad from one checked sample to the next.
pub(crate) const SAMPLES_APART: usize = 5;

/// The largest speed of a stance sole of a smooth motion, m/s: a foot lands and leaves at rest.
pub(crate) const SOLE_SPEED_MAX: f64 = 0.02;
/// The largest angular speed of a stance sole of a smooth motion, rad/s.
pub(crate) const SOLE_TURN_SPEED_MAX: f64 = 0.1;
/// How far over the ground or in it a sole of a smooth motion may be declared, m: a foot that meets
/// the ground before or after its time meets it at speed, and rocks.
pub(crate) const LANDING_HEIGHT_MAX: f64 = 5e-4;

/// The largest share of its effort limit by which a feed-forward torque of a robot on one foot may
/// differ from what the contact forces explain: hubo stands in a replay with as much on all joints.
pub(crate) const FEED_FORWARD_OFF_MAX: f64 = 0.05;

// Collision.

/// How much deeper a stance foot may be in a part of the world than the rays under its sole have
/// found, m.
pub(crate) const UNSEEN_DEPTH_MAX: f64 = 3e-4;
/// The cosine of the largest angle to the way down of a direction in which something is below a
/// foot, not beside it.
pub(crate) const BELOW_COS_MIN: f64 = 0.7;

/// For motions up to this length (m) only their ends are measured.
pub(crate) const RESOLUTION: f64 = 1e-3;
/// The same as a share of the smallest distance so far, where the tolerance is kept in any case: a
/// margin is printed less by half of this share at most.
pub(crate) const MARGIN_SHARE: f64 = 0.05;
/// A distance is measured up to what an interval needs and the motion of this many more, so that
/// they need not be measured.
pub(crate) const LOOK_AHEAD: f64 = 8.0;
/// Larger distances are reported as this one, m.
pub(crate) const DISTANCE_CAP: f64 = 0.1;

// Reserves.

/// Steps in which the friction reserve is measured.
pub(crate) const FRICTION_STEPS: u32 = 16;
