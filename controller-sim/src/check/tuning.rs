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
/// The same of a sole as the motion has it, with its distance from its declared place, m.
pub(crate) const MOVED_HEIGHT_MAX: f64 = 1e-3;
/// How much deeper than the other one a sole of a smooth motion may be as it moves, m. Plans need
/// 0.6 mm.
pub(crate) const MOVED_LEVEL_MAX: f64 = 8e-4;
/// The same of straight lines, m: with 2 mm G1's root strays by 38 mm, with 3.6 mm it falls.
pub(crate) const STRAIGHT_LEVEL_MAX: f64 = 2e-3;

/// The largest share of its effort limit by which a feed-forward torque of a robot on one foot may
/// differ from what the contact forces explain: hubo stands in a replay with as much on all joints.
pub(crate) const FEED_FORWARD_OFF_MAX: f64 = 0.05;
/// The same on two feet, where the checker's contact forces lie on the ground that its rays find.
/// Plans on rough ground need 0.12.
pub(crate) const SHARED_OFF_MAX: f64 = 0.15;
/// The same on one foot where the rate of plan time changes by [`STOP_CHANGE`]. Plans need 0.09.
pub(crate) const STOP_OFF_MAX: f64 = 0.15;
/// The same on two feet in a walk as it was executed, where the torques of a stop are not those of
/// one way to share the load. Walks need 0.41.
pub(crate) const SHARED_STOP_OFF_MAX: f64 = 0.6;
/// The change of the rate of plan time at which its torques are compared, 1/s: that of a stop
/// within half a second.
pub(crate) const STOP_CHANGE: f64 = 4.0;
/// The largest feed-forward torque in a stop, as a share of the effort limit. Plans for small
/// ankles state 1.65 on two feet, where the motor gives no more than its limit.
pub(crate) const STOP_USE_MAX: f64 = 2.0;

// Collision.

/// How deep a link that is no foot may be in the world, m: rounding. Under a ceiling that its head
/// entered by 1.9 mm H1-2 fell, although nothing else was wrong.
pub(crate) const TOUCH_DEPTH_MAX: f64 = 1e-6;
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
