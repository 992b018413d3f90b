//! Constants of the smooth path that change which configurations it passes.

// The curve.

/// Keys of each stance: entry, two in the middle, exit.
pub(crate) const STANCE_KEYS: usize = 4;
/// Expected time from one key to the next, s: the unit of the path's parameter.
pub(crate) const KEY_SECONDS: f64 = 0.2;
/// Distance (m) that the two middle keys of a stance lie deeper inside its region than the line
/// from its entry to its exit.
pub(crate) const BULGE: f64 = 0.012;
/// Additional margin of the centre of mass's keys against rounding, m.
pub(crate) const KEY_MARGIN: f64 = 1e-6;

// Swings.

/// Step in which the ends of a swing are searched along the curve, in keys.
pub(crate) const SWING_SCAN_STEP: f64 = 1.0 / 32.0;
/// Part of the way between two stances' keys that a swing leaves to double support, in keys.
pub(crate) const DOUBLE_SUPPORT_HALF: f64 = 0.3;
/// Share of a swing at each end in which the foot moves along its sole's normal alone.
pub(crate) const NORMAL_LIFT: f64 = 0.02;
/// Horizontal distance (m) from its foothold up to which a swing foot needs no clearance below its
/// sole.
pub(crate) const LIFT_OFF_DISTANCE_MAX: f64 = 2e-3;

// Heights.

/// Step in which the reach of the legs is sampled along the curve, in keys.
pub(crate) const REACH_STEP: f64 = 0.25;

// Points.

/// Longest distance of two points, in keys.
pub(crate) const POINT_STEP: f64 = 0.1;
/// Longest distance (m) of two points along the swing of a foot.
pub(crate) const SWING_POINT_STEP: f64 = 0.025;
/// Fewest intervals of a phase.
pub(crate) const INTERVALS_MIN: usize = 12;
/// Most intervals of a phase.
pub(crate) const INTERVALS_MAX: usize = 96 << REFINEMENTS_MAX;
/// Times that the intervals of a phase are halved, at most.
pub(crate) const REFINEMENTS_MAX: u8 = 2;
/// Largest motion of a joint between two points, rad or m.
pub(crate) const JOINT_STEP_MAX: f64 = 0.3;
/// Parts into which the curve between two points is divided to check it.
pub(crate) const CURVE_PARTS: usize = 4;

// Final phases.

/// Phases before the first one that is not checked yet that may still change. One that keeps its
/// searched motion changes four before it; where these fail in turn, others before them. In walks
/// of the shipped scenarios up to nine have changed.
pub(crate) const OPEN_PHASES: usize = 9;

// Followed motions.

/// Fewest intervals between keys of a spline along a searched motion.
pub(crate) const FOLLOWED_KEYS_MIN: usize = 4;
/// Most intervals between keys of a spline along a searched motion that is not refined.
pub(crate) const FOLLOWED_KEYS_MAX: usize = 48;
/// Intervals between points for each interval between keys of a followed motion before keys are
/// left out.
pub(crate) const FOLLOWED_DENSITY: usize = 2;
/// Distance (m) of a swing foot from its foothold up to which no keys are left out.
pub(crate) const FOLLOWED_NEAR_DISTANCE: f64 = 0.03;

// The solution for a point.

/// Shift of the root for a shift of the centre of mass before the ratio is known.
pub(crate) const ROOT_SHIFT_FIRST: f64 = 1.15;
/// Steps that bring the centre of mass onto its curve.
pub(crate) const COM_STEPS_MAX: usize = 16;
/// Largest distance of the centre of mass from its curve, m. Derivatives are differences of points.
pub(crate) const COM_ERROR_MAX: f64 = 1e-10;
/// The same where the steps do not come closer, because the legs have no closed form, m.
pub(crate) const COM_ERROR_ACCEPTED: f64 = 1e-8;
/// Largest difference (rad or m) of a joint from the plan's configuration at which the path rests.
pub(crate) const REST_DIFFERENCE_MAX: f64 = 1e-5;
/// Largest difference (rad or m) of a joint where one phase follows another.
pub(crate) const JOIN_DIFFERENCE_MAX: f64 = 1e-6;
