//! The sizes of the relaxed problem.

/// Most columns of the grid.
pub(crate) const COLUMNS_MAX: usize = 1 << 15;
/// Smallest side of a voxel, m. Smaller ones show no more: the root's ball is about twice as large.
pub(crate) const CELL_MIN: f64 = 0.06;
/// Largest side of a voxel, m. Larger ones hide every gap and every wall.
pub(crate) const CELL_MAX: f64 = 0.16;
/// Ground beyond start and goal that a grid of a part of the world contains, m.
pub(crate) const PART_MARGIN: f64 = 5.0;
/// Most voxels within a reach, seen from above.
pub(crate) const DISC_MAX: usize = 4_096;
/// Added to every distance that is possible, m: rounding, and contacts within the contact gap.
pub(crate) const TOLERANCE: f64 = 0.01;
/// Most voxels through which the root's ball passes from one end.
pub(crate) const PASSED_MAX: usize = 25_000;
/// Smallest radius of the ball that is tested between two voxels, m.
pub(crate) const TESTED_RADIUS_MIN: f64 = 1e-3;

// Pieces of work of about ten microseconds.

/// Surface elements that are measured or rasterized.
pub(crate) const ELEMENTS_PER_UNIT: u32 = 64;
/// Columns of one surface element that count as another element.
pub(crate) const COLUMNS_PER_ELEMENT: usize = 8;
/// Columns from which steps or legs reach others.
pub(crate) const COLUMNS_PER_UNIT: usize = 4;
/// Voxels from which the root's ball moves on.
pub(crate) const VOXELS_PER_UNIT: usize = 6;
