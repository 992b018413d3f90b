//! The sizes of the relaxed problem.

/// Most columns of the grid.
pub(crate) const COLUMNS_MAX: usize = 1 << 15;
/// Smallest side of a voxel, m. Smaller ones show no more: the root's ball is about twice as large.
pub(crate) const CELL_MIN: f64 = 0.06;
/// Largest side of a voxel, m. Larger ones hide every gap and every wall.
pub(crate) const CELL_MAX: f64 = 0.16;
/// Ground beyond start and goal that a grid of a part of the world contains, m.
pub(crate) const PART_MARGIN: f64 = 5.0;
/// Most surface elements of a world in which steps are searched from one to the other.
pub(crate) const SEARCHED_ELEMENTS_MAX: usize = 1_024;
/// Most voxels within a reach, seen from above.
pub(crate) const DISC_MAX: usize = 4_096;
/// Added to every distance that is possible, m: rounding, and contacts within the contact gap.
pub(crate) const TOLERANCE: f64 = 0.01;
/// Most voxels through which the root's ball passes from one end.
pub(crate) const PASSED_MAX: usize = 25_000;
/// Smallest radius of the ball that is tested between two voxels, m.
pub(crate) const TESTED_RADIUS_MIN: f64 = 1e-3;

// Legs as curves.

/// Most columns of a grid on which legs cost little more than the rest.
pub(crate) const QUICK_COLUMNS_MAX: usize = 12_000;
/// Distance from the world that covered points of a leg keep, m.
pub(crate) const CURVE_RADIUS: f64 = 0.044;
/// How deep in the robot's shapes they lie, m.
pub(crate) const COVER_DEPTH: f64 = 0.0445;
/// Greatest depth of points in the box of a foot, m.
pub(crate) const FOOT_DEPTH_MAX: f64 = 0.03;
/// How deep a stance foot may sink into the world, m.
pub(crate) const FOOT_SINK: f64 = 2e-3;
/// Tangent of the tilt of a sole against the ground, with a reserve.
pub(crate) const SOLE_TILT_TAN: f64 = 0.1;
/// Distance within which voxels touch, m: rounding.
pub(crate) const TOUCHING: f64 = 1e-6;
/// Distance of the points of a leg whose depth is measured, m.
pub(crate) const CURVE_SPACING: f64 = 1e-3;
/// Joints at most this far apart turn about the same point, m.
pub(crate) const SAME_POINT: f64 = 1e-6;

// The coarse path.

/// Most places that its search tests.
pub(crate) const PLACES_MAX: usize = 1 << 15;
/// Longest stride across a gap, m.
pub(crate) const STRIDE_MAX: f64 = 0.5;
/// Greatest difference in height between places beside each other, m.
pub(crate) const CLIMB_MAX: f64 = 0.3;
/// Cost of a metre up or down, relative to that of a metre ahead: stairs cost more than floors.
pub(crate) const CLIMB_COST: f64 = 2.0;
/// Cost of a metre across a gap, relative to that of a metre over ground.
pub(crate) const GAP_COST: f64 = 2.0;
/// Horizontal distance from the goal within which the path reaches it, m.
pub(crate) const GOAL_DISTANCE: f64 = 0.25;
/// Longest straight leg, m.
pub(crate) const LEG_LENGTH_MAX: f64 = 4.0;

// Pieces of work of about ten microseconds.

/// Pairs of elements between which steps are tried.
pub(crate) const PAIRS_PER_UNIT: usize = 64;
/// Surface elements that are measured or rasterized.
pub(crate) const ELEMENTS_PER_UNIT: u32 = 64;
/// Columns of one surface element that count as another element.
pub(crate) const COLUMNS_PER_ELEMENT: usize = 8;
/// Columns from which steps or legs reach others.
pub(crate) const COLUMNS_PER_UNIT: usize = 4;
/// Columns from which legs go on, and voxels that are tested for them.
pub(crate) const VISITS_PER_UNIT: u32 = 64;
/// Places of the coarse path.
pub(crate) const PLACES_PER_UNIT: usize = 4;
/// Voxels from which the root's ball moves on.
pub(crate) const VOXELS_PER_UNIT: usize = 6;
