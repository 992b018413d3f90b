//! The constants of foot placement that change which placements are found, or how fast. The bounds
//! that a caller may set are in
//! [`FootPlacementConfig`](crate::foot_placement::FootPlacementConfig). Constants without another
//! source were chosen with `surefoot bench footholds`.

use glam::{DVec2, DVec3};

// Support that a small sole needs.

/// Least supported share of a small sole's area: the share that the default area is of the
/// reference robot's sole.
pub(crate) const AREA_SHARE_MIN: f64 = 0.26;
/// Least distance from a small sole's support centroid to the nearest edge of the support, as a
/// share of the same distance of the whole sole; from the reference robot, as above.
pub(crate) const EDGE_DISTANCE_SHARE_MIN: f64 = 0.29;
/// Every sole needs at least this multiple of the area that the checker requires.
pub(crate) const CHECKED_AREA_FACTOR: f64 = 1.2;
/// The centroid of a support is at least this multiple of the smallest margin of the centre of mass
/// from its edge.
pub(crate) const CHECKED_DISTANCE_FACTOR: f64 = 1.25;

/// Largest distance (m) of the highest ground under a sole from the sole's plane. The checker
/// allows 0.5 mm where a smooth motion lands, and as much between the heights of two soles over
/// their ground; it measures at other places, and bars are up to 0.2 mm thicker than their sides.
pub(crate) const GROUND_HEIGHT_MAX: f64 = 1e-4;
/// The largest `foot_shift`, m: checkers that allow more are met with smaller supports than theirs.
pub(crate) const FOOT_SHIFT_MAX: f64 = 0.02;
/// Spacing of the samples by which a checker may measure the ground under a sole, m: it finds an
/// edge up to as far inside.
pub(crate) const SAMPLE_SPACING: f64 = 1e-3;

// Compiling a world.

/// Largest depth of a cylinder's flat sides inside the cylinder, m.
pub(crate) const CYLINDER_SAGITTA: f64 = 2e-4;
/// Most flat sides of a cylinder.
pub(crate) const CYLINDER_SIDES_MAX: usize = 256;

// Gathering features near the ideal.

/// The reach is searched in this many boxes, each twice as wide as the one before, until enough
/// features are found.
pub(crate) const GATHERING_STEPS: i32 = 4;
/// Features held while the nearest are selected, as a multiple of `features_max`.
pub(crate) const GATHERING_FACTOR: usize = 4;
/// Most curved features whose common tangent planes are tried.
pub(crate) const TANGENT_SURFACES_MAX: usize = 8;

// Candidates read off the geometry.

/// Most features of one plane that get placements of their own.
pub(crate) const SINGLES_MAX: usize = 12;
/// Most features of one plane that are paired.
pub(crate) const PAIRED_MAX: usize = 8;
/// Distances that a sole keeps from a face's edges, m: the comfortable one is tried first.
pub(crate) const EDGE_MARGINS: [f64; 2] = [0.01, 1e-3];
/// Distances that a pair of faces keeps from the ends of a sole across them, m, in the order in
/// which they are tried. A pair with a line, as the top of a bar, keeps the first of
/// `EDGE_MARGINS`, or the sole stands in the middle: a foot lands some millimetres beside its
/// place, and on a line nothing is left of the support then.
pub(crate) const FACE_MARGINS: [f64; 3] = [EDGE_MARGINS[0], EDGE_MARGINS[1], 0.0];
/// Width below which a feature counts as a line, m.
pub(crate) const LINE_WIDTH: f64 = 2e-3;
/// Shares of the shift onto a face after which a sole is tried partly on it.
pub(crate) const PARTIAL_SHIFT_SHARES: [f64; 2] = [0.5, 0.75];
/// Outer spans of a pair that a sole may bridge, as shares of the sole's extent across the pair.
pub(crate) const SPAN_SHARES: [f64; 2] = [0.4, 1.3];
/// Cosine between the narrow directions of two features from which they count as parallel.
pub(crate) const PARALLEL_COS: f64 = 0.985;
/// Shifts along a pair from the position nearest to the ideal, m.
pub(crate) const PAIR_SHIFTS: [f64; 7] = [0.0, 0.07, -0.07, 0.14, -0.14, 0.25, -0.25];
/// Turns away from straight across a pair, rad. A skewed sole reaches further.
pub(crate) const TURNS_ACROSS: [f64; 5] = [0.0, 0.2, -0.2, 0.35, -0.35];
/// Cost of a radian of turn in the order of candidates, m.
pub(crate) const TURN_COST: f64 = 0.2;
/// Cost of a partial support in the order of candidates, m.
pub(crate) const PARTIAL_COST: f64 = 0.05;
/// Candidates closer to each other than this (m, and sine of half the turn) are examined once.
pub(crate) const REPEATED_DISTANCE: f64 = 1e-3;

// Random perturbations.

/// Candidates that are perturbed at random.
pub(crate) const PERTURBED_CANDIDATES_MAX: usize = 8;
/// The largest shift of a perturbed candidate in its plane, m.
pub(crate) const PERTURBATION_SHIFT: f64 = 0.04;
/// The largest turn of a perturbed candidate, rad.
pub(crate) const PERTURBATION_TURN: f64 = 0.2;

// Algorithm 1 [Grey 4.2.2].

/// The largest `sample_attempts_near_ideal`.
pub(crate) const NEAR_TARGETS_MAX: usize = 5;
/// The largest `neighbors`: they are kept on the stack.
pub(crate) const NEIGHBORS_MAX: usize = 64;
/// The first targets: the ideal, then half a foot ahead of it, behind it and to both sides, m.
pub(crate) const NEAR_TARGETS: [DVec3; NEAR_TARGETS_MAX] = [
    DVec3::ZERO,
    DVec3::new(0.1, 0.0, 0.0),
    DVec3::new(-0.1, 0.0, 0.0),
    DVec3::new(0.0, 0.1, 0.0),
    DVec3::new(0.0, -0.1, 0.0),
];
/// Range of near placements, from the triplet's centroid and from the ideal heading, as a share of
/// the range of the others.
pub(crate) const NEAR_FRACTION: f64 = 0.25;
/// Share of the attempts over which the bound of the support area relaxes.
pub(crate) const RELAXATION_SHARE: f64 = 0.25;
/// Random points taken inside each face.
pub(crate) const INNER_POINTS: usize = 4;
/// Most points along one edge or line.
pub(crate) const EDGE_POINTS_MAX: usize = 64;

// Rough ground.

/// Positions at which a sole is set down: offsets from the ideal, x along its heading, m.
pub(crate) const REST_OFFSETS: [DVec2; 13] = [
    DVec2::ZERO,
    DVec2::new(0.05, 0.0),
    DVec2::new(-0.05, 0.0),
    DVec2::new(0.0, 0.05),
    DVec2::new(0.0, -0.05),
    DVec2::new(0.08, 0.08),
    DVec2::new(0.08, -0.08),
    DVec2::new(-0.08, 0.08),
    DVec2::new(-0.08, -0.08),
    DVec2::new(0.15, 0.0),
    DVec2::new(-0.15, 0.0),
    DVec2::new(0.0, 0.15),
    DVec2::new(0.0, -0.15),
];
/// Number of nearest faces whose planes are tested for a fit of the sole.
pub(crate) const PLANES_TRIED_MAX: usize = 6;
/// Share of the sole's area that a wide support has.
pub(crate) const WIDE_SUPPORT_SHARE: f64 = 0.6;
/// Times that a sole is set down at an offset: as it tilts, its outline moves over other ground.
pub(crate) const REST_ITERATIONS: usize = 3;

// Nested placements [Grey 4.2.3].

/// The steepest face that a sole is nested on or against, as its normal's z: 70 degrees.
pub(crate) const NEST_NORMAL_Z_MIN: f64 = 0.342;
/// The largest rise of a valley along its length, as a sine: the foot must not slide along it.
pub(crate) const VALLEY_RISE_MAX: f64 = 0.05;
/// The largest gap between a face's end and the valley that it still reaches, m.
pub(crate) const VALLEY_GAP: f64 = 1e-3;
/// Distance of the nested edge from the valley, m. A real foot yields by as much and touches.
pub(crate) const NEST_EDGE_GAP: f64 = 5e-4;
/// Shifts along the valley from the position nearest to the ideal, m.
pub(crate) const VALLEY_SHIFTS: [f64; 5] = [0.0, 0.07, -0.07, 0.14, -0.14];

// Footholds of both stages.

/// The largest horizontal distance of a placement from the ideal, m.
pub(crate) const FOOTHOLD_REACH_XY: f64 = 0.35;
/// The largest turn of a placement away from the ideal heading, rad.
pub const YAW_SPREAD_MAX: f64 = 0.8;
/// A query ends with a placement within this distance of the ideal, m: further ones are no better.
pub(crate) const IDEAL_DISTANCE: f64 = 1e-3;
