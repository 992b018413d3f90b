//! Constants of inverse kinematics that change which solutions are found, or how fast. They come
//! from measurements on the sample robots.

// Newton iteration.

/// Newton steps from one start; from near the solution three or four suffice.
pub(crate) const ITERATIONS_MAX: usize = 16;
/// Newton steps after which a start must be near the solution.
pub(crate) const APPROACH_ITERATIONS: usize = 8;
/// Error (m and rad) below which every step squares the error.
pub(crate) const ERROR_NEAR: f64 = 0.2;
/// Largest ratio of the error after a step to the least error before it that counts as progress.
pub(crate) const PROGRESS_RATIO_MAX: f64 = 0.98;
/// Consecutive steps without progress that end a start.
pub(crate) const STALLS_MAX: usize = 3;
/// Consecutive steps with a joint at its limit that end a start. This stops one in a thousand of
/// the starts that would succeed, and most of the others.
pub(crate) const LIMIT_STEPS_MAX: usize = 3;
/// Longest joint motion of one step, rad or m. Prevents jumps between branches of solutions.
pub(crate) const JOINT_STEP_MAX: f64 = 0.5;
/// Smallest pivot (m or 1) of an undamped step; a smaller one is near a singularity.
pub(crate) const UNDAMPED_PIVOT_MIN: f64 = 1e-3;

// Stored start postures of the Newton iteration.

/// Number of stored postures: half near the standing one, half anywhere within the limits.
pub(crate) const POSTURES: usize = 512;
/// Largest deviation of the first half from the standing posture, rad or m.
pub(crate) const STANDING_DEVIATION_MAX: f64 = 0.7;
/// Stored postures that one query starts from.
pub(crate) const POSTURE_STARTS: usize = 4;
/// Distance (m) that equals a rotation by two radians when postures are compared.
pub(crate) const LENGTH_PER_DOUBLE_RADIAN: f64 = 0.4;

// Least-norm step.

/// Solutions of the normal equations in one step, with more unknowns fixed at their limits in each.
pub(crate) const LIMIT_ROUNDS_MAX: usize = 4;
