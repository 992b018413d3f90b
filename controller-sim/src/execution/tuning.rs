//! The size of the simulated disturbances, the distance at which a difference of the world is
//! encountered, and the instants of a motion that is written as executed.

// Misplaced feet.

/// Largest distance of a landed foot from its planned position, m.
pub(crate) const OFFSET_MAX: f64 = 0.005;
/// Largest yaw of a landed foot from its planned orientation, rad.
pub(crate) const YAW_MAX: f64 = 1.0 / 180.0 * std::f64::consts::PI;
/// The velocity and acceleration of a leg are differences over this time before and after, s.
pub(crate) const DIFFERENCE_SECONDS: f64 = 2e-4;
/// Landings that are tried where the support is insufficient.
pub(crate) const LANDING_ATTEMPTS_MAX: u64 = 4;

// A world that differs.

/// A difference is encountered within this distance of the robot's path, m.
pub(crate) const ENCOUNTER_DISTANCE_MAX: f64 = 0.05;

// Chunks that come late.

/// The longest delay of a late chunk, s.
pub(crate) const DELAY_MAX: f64 = 3.0;
/// Time between two instants of a walk with late chunks at which the robot is compared with where
/// its speed leads, s. The trapezoidal rule errs by the change of acceleration times a twelfth of
/// its square: 0.04 mrad where the acceleration changes by 500 rad/s2.
pub(crate) const SAMPLE_TICK: f64 = 1e-3;
/// Every so many of these instants the dynamic checks run.
pub(crate) const SAMPLES_PER_CHECK: u32 = 10;
/// How far a number may be from where its speed leads within such a time, rad or m.
pub(crate) const JUMP_MAX: f64 = 1e-4;

// A motion as executed.

/// The longest time between two waypoints where the robot brakes or goes on, s.
pub(crate) const RAMP_INTERVAL: f64 = 0.01;
/// The longest time between two waypoints where it stands, s.
pub(crate) const STANDING_INTERVAL_MAX: f64 = 10.0;
