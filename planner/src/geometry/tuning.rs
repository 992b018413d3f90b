//! Constants of geometric queries that change speed but no result.

/// Most vertices of a hull for which a scan is faster than hill climbing.
pub(crate) const SCANNED_VERTICES_MAX: usize = 24;

/// Cells along a side of each face of the direction cube from which hill climbing starts.
pub(crate) const DIRECTION_CELLS: usize = 4;

/// Triangles per leaf of a mesh's bounding volume hierarchy.
pub(crate) const LEAF_TRIANGLES_MAX: usize = 4;
