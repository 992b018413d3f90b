//! The size of the simulated disturbances, and the distance at which a difference of the world is
//! encountered.

// Misplaced feet.

/// Largest distance of a landed foot from its planned position, m.
pub(crate) const OFFSET_MAX: f64 = 0.005;
/// Largest yaw of a landed foot from its planned orientation, rad.
pub(crate) const YAW_MAX: f64 = 1.0 / 180.0 * std::f64::consts::PI;
/// Landings that are tried where the support is insufficient.
pub(crate) const LANDING_ATTEMPTS_MAX: u64 = 4;

// A world that differs.

/// A difference is encountered within this distance of the robot's path, m.
pub(crate) const ENCOUNTER_DISTANCE_MAX: f64 = 0.05;
