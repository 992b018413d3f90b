//! Constants of this folder that change which postures are found, or how fast. They have no source
//! in the literature unless one is named: the defaults passed the benches on all sample robots.

// The mechanism.

/// Largest carried mass of a finger or gripper joint, as a share of the robot's mass. Samples leave
/// such joints alone. Wrists of the sample humanoids carry 0.18 % and more.
pub(crate) const FINGER_MASS_SHARE_MAX: f64 = 1.6e-3;
/// Smallest carried mass of a trunk joint, as a share of the robot's mass.
pub(crate) const TRUNK_MASS_SHARE_MIN: f64 = 0.2;

// Ankle limits.

/// Number of joints at the end of a leg that form its ankle.
pub(crate) const ANKLE_JOINTS: usize = 2;
/// Smallest area of an ankle support region, as a share of the support polygon's area. Below it the
/// whole polygon is used, and the torque check decides.
pub(crate) const ANKLE_REGION_SHARE_MIN: f64 = 0.02;

// Whole-body inverse kinematics (`posture_ik`).

/// Fixed-point iterations that bring the centre of mass over its target.
pub(crate) const POSTURE_ITERATIONS_MAX: usize = 8;
/// Ratio of a root shift to the shift of the centre of mass that it causes. It exceeds 1 because
/// the legs move by half as much as the root.
pub(crate) const ROOT_SHIFT_RATIO: f64 = 1.15;
/// Largest leg extension of a sampled posture, 0 to 1. Beyond it the knee is almost straight.
pub(crate) const POSTURE_LEG_EXTENSION_MAX: f64 = 0.995;

// Constrained projection.

/// Newton steps of one projection. From near the solution four to eight suffice.
pub(crate) const PROJECTION_STEPS_MAX: usize = 12;
/// Largest ratio of the error after a step to the error before it that counts as progress.
pub(crate) const PROJECTION_PROGRESS_RATIO_MAX: f64 = 0.97;
/// Consecutive steps without progress that end a projection.
pub(crate) const PROJECTION_STALLS_MAX: usize = 4;
/// Largest error (m and rad) that the closed-form legs remove at the end.
pub(crate) const PROJECTION_ERROR_NEAR: f64 = 1e-4;
/// Largest error (m and rad) that one step removes.
pub(crate) const PROJECTION_STEP_ERROR_MAX: f64 = 0.5;
/// Weight of the root's rotation compared with a joint. It is small, so that the root keeps the
/// desired rotation where possible.
pub(crate) const PROJECTION_ROTATION_WEIGHT: f64 = 0.05;
/// Depth of the centre of mass beyond its margin (m): below the first value the projection moves it
/// inward, and aims at the second.
pub(crate) const PROJECTION_COM_DEPTHS: [f64; 2] = [1e-3, 3e-3];

/// Cosine of the lean of the root from which on configurations are projected: 0.8 rad.
pub(crate) const PROJECTED_LEAN_COSINE: f64 = 0.7;

// Single-support postures.

/// Share of the usable effort below which a posture needs no improvement.
pub(crate) const EFFORT_USE_LOW: f64 = 0.9;
/// Margin (rad or m) to the limits that each joint of the stance leg should keep, if it has that
/// much in double support.
pub(crate) const LIMIT_MARGIN_DESIRED: f64 = 0.15;
/// Step sizes of the descent (rad), in order.
pub(crate) const DESCENT_STEPS: [f64; 4] = [0.08, 0.04, 0.02, 0.01];
/// Most changes with each step size.
pub(crate) const DESCENT_CHANGES_MAX: usize = 6;
/// Largest deviation of an angle from the standing posture, rad.
pub(crate) const DEVIATION_MAX: f64 = 0.3;
/// Cost of a deviation of 1 rad, in shares of effort: the straighter of two easy postures is taken.
pub(crate) const DEVIATION_COST: f64 = 0.1;
/// Cost of a joint that keeps none of the desired margin, in shares of effort.
pub(crate) const MARGIN_DEFICIT_COST: f64 = 0.2;

// Crouches.

/// Leg extension that equals a forward lean of 1 rad when crouches are compared, 1/rad.
pub(crate) const LEG_EXTENSION_PER_RADIAN: f64 = 0.5;
