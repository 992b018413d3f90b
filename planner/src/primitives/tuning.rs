//! The constants of primitives and transition configurations that change which motions are found,
//! or how fast. Constants without another source were chosen with `surefoot bench`.

// Gaits.

/// The largest share of a leg's reach that a gait uses.
pub(crate) const GAIT_LEG_EXTENSION_MAX: f64 = 0.99;
/// Height of a lift beyond its least height, m.
pub(crate) const GAIT_LIFT_MARGIN: f64 = 0.004;

// Sampling of a primitive trajectory.

/// The first step along a section that is tried, as a share of it.
pub(crate) const SECTION_STEP_FIRST: f64 = 0.25;
/// The largest distance that root or sole moves between two waypoints, m.
pub(crate) const WAYPOINT_DISTANCE_MAX: f64 = 0.04;
/// The share of the step limits that the next step aims at.
pub(crate) const STEP_AIM: f64 = 0.95;

// Transition configurations [Grey 4.4.2, 4.4.5].

/// A primitive posture.
pub(crate) struct PrimitivePosture {
    /// Leg extension, as a multiple of the standing posture's.
    pub extension: f64,
    /// Pitch of the root, rad.
    pub pitch: f64,
    /// Roll of the root toward the stance foot, rad.
    pub roll: f64,
    /// Position of the centre of mass from the support's centroid toward the other foot, as a share
    /// of the distance that the margin leaves.
    pub lean: f64,
}

const fn posture(extension: f64, pitch: f64, roll: f64, lean: f64) -> PrimitivePosture {
    PrimitivePosture { extension, pitch, roll, lean }
}

/// The primitive postures, in the order in which they are tried.
pub(crate) const PRIMITIVE_POSTURES: [PrimitivePosture; 12] = [
    posture(1.0, 0.0, 0.0, 0.5),
    posture(1.0, 0.0, 0.0, 0.0),
    posture(0.96, 0.0, 0.0, 0.7),
    posture(1.03, 0.0, 0.0, 0.6),
    posture(0.92, 0.12, 0.0, 0.5),
    posture(1.02, 0.0, 0.08, 0.8),
    posture(0.96, 0.15, 0.08, 0.8),
    posture(0.88, 0.25, 0.0, 0.6),
    posture(1.02, 0.2, 0.0, 0.9),
    posture(0.98, -0.08, -0.08, 0.6),
    posture(0.84, 0.35, 0.1, 0.8),
    posture(1.03, 0.0, -0.1, 0.9),
];
/// The primitive postures that reach farthest, by attempt. They reach 95 % of the pairs that any
/// primitive posture reaches. The first one needs the largest clearance around the robot: where it
/// holds, swings are likely to be found.
pub const FAR_REACHING_POSTURES: [u64; 4] = [10, 8, 11, 5];
/// Attempts in the neighbourhood of the primitive postures, before uniform ones.
pub(crate) const NEIGHBOURHOOD_ATTEMPTS: u64 = 24;
/// From this attempt on, every other one draws from all postures.
pub(crate) const UNBOUNDED_FROM: u64 = 108;
/// Of these attempts, those whose number is a multiple of this one begin with random leg joints.
pub(crate) const ANY_BRANCH_EVERY: u64 = 4;
/// Smallest and largest leg extension of such an attempt, as a share of the leg's reach.
pub(crate) const UNBOUNDED_LEG_EXTENSIONS: [f64; 2] = [0.2, 1.0];
/// Attempts from this one on are projections, where the legs have no closed form.
pub(crate) const PROJECTED_FROM: u64 = 24;
/// Attempts that one projection counts for.
pub(crate) const PROJECTION_WEIGHT: u32 = 5;
/// Range of random deviations in the neighbourhood, as a share of the uniform range.
pub(crate) const NEIGHBOURHOOD_SPREAD: f64 = 0.4;
/// Half ranges of the uniform deviations: yaw, roll and pitch of the root, rad.
pub(crate) const ROTATION_SPREADS: [f64; 3] = [0.6, 0.25, 0.3];
/// Half range of the uniform deviation of the leg extension, as a multiple of the standing one.
pub(crate) const EXTENSION_SPREAD: f64 = 0.15;
/// Half range of the uniform deviation of the lean, and the bounds of the lean.
pub(crate) const LEAN_SPREAD: f64 = 0.6;
/// The bounds of the lean.
pub(crate) const LEAN_BOUNDS: [f64; 2] = [-0.5, 1.0];
/// Half range of the uniform deviation of a free joint, rad.
pub(crate) const FREE_JOINT_SPREAD: f64 = 0.5;
/// Half range of the uniform deviation of the centre of mass along x and y, m.
pub(crate) const COM_SPREAD: f64 = 0.02;
