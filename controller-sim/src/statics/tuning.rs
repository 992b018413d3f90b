//! The resolution of the support samples and of the equilibrium regions, and the sizes of the
//! caches.

// Support of a sole.

/// Spacing of the samples over the sole, m.
pub(crate) const SAMPLE_SPACING: f64 = 5e-3;
/// Spacing of the samples around partial contact, m.
pub(crate) const FINE_SAMPLE_SPACING: f64 = 1e-3;
/// Samples no farther apart are neighbours, m: at least five of a sample inside the sole.
pub(crate) const NEIGHBOUR_DISTANCE: f64 = 7.5e-3;
/// Neighbours that differ by less from the plane of a sample lie in it, m.
pub(crate) const PLANE_DISTANCE_MAX: f64 = 1e-7;
/// Ground is no deeper beside a sample than below it where it rises by more, m per m: a wall, of
/// which the samples beside it show the foot.
pub(crate) const STEEP_GROUND_MIN: f64 = 1.0;
/// Rays begin this far below the sole or above the underside of the foot, m.
pub(crate) const RAY_START: f64 = 0.02;
/// A foot counts as flat where its underside is this near to its sole plane, m: meshes of feet are
/// simplified by as much, and soles yield.
pub(crate) const SOLE_FLATNESS: f64 = 1e-3;
/// The same where it is the round side of a cylinder, capsule or ball, m: the samples of the fine
/// grid nearest to the line in which a cylinder of 20 mm diameter touches lie as near to it.
pub(crate) const ROUND_FLATNESS: f64 = 2e-5;
/// Sine of the tilt up to which the surface of such a shape is its flat end.
pub(crate) const END_TILT_MAX: f64 = 1e-3;
/// Differences of the air under a sole below this one are even ground, m.
pub(crate) const EVEN_AIR_MAX: f64 = 1e-6;
/// Samples with this much more air than the least are looked at more closely, m.
pub(crate) const NEAR_AIR_MAX: f64 = 3e-3;
/// Points with this much more air than the least may touch, m.
pub(crate) const TOUCH_GAP_MAX: f64 = 1.5e-3;
/// Tilt of a foot that is level but for rounding, rad.
pub(crate) const REST_TILT_MIN: f64 = 1e-5;
/// Difference between the tilts of a foot of which the best counts, rad.
pub(crate) const REST_TILT_STEP: f64 = 5e-4;
/// Number of these tilts after the least; the last one, 22 mrad, is the most of a resting foot.
pub(crate) const REST_TILTS: u32 = 44;
/// Tilts of a foot to the side of the direction in which it tilts, rad: as the lengths of soles, a
/// third point may lie 0.2 mm lower than the plane in which the foot is declared.
pub(crate) const REST_SIDE_TILTS: [f64; 5] = [0.0, 3e-4, -3e-4, 1e-3, -1e-3];
/// Directions in which a foot may tilt that are examined first, in addition to those of the sides
/// of its contact.
pub(crate) const REST_DIRECTIONS: usize = 32;
/// Times that two directions are bisected at most in which the foot stands on different points.
pub(crate) const REST_BISECTIONS: usize = 6;
/// A side of a support between two such points lies at most as far off, m.
pub(crate) const REST_SIDE_OFF_MAX: f64 = 4e-4;
/// Heights of the centre of mass over a sole are rounded up to a multiple of this one, m.
pub(crate) const HEIGHT_STEP: f64 = 0.05;
/// Edge samples are moved towards the middle by this share of their distance from it.
pub(crate) const EDGE_PULL: f64 = 1e-4;
/// Samples of the grids are at least this far inside the sole, m: within the edge samples, so that
/// a sole that stands evenly has no more contact points than corners.
pub(crate) const EDGE_INSET: f64 = 1e-4;
/// Most contact points kept of a sole.
pub(crate) const CONTACT_POINTS_MAX: usize = 16;
/// Most soles in the cache.
pub(crate) const SOLES_CACHED_MAX: usize = 256;

// Equilibrium.

/// Sides of a friction pyramid.
pub(crate) const PYRAMID_SIDES: usize = 8;
/// Directions in which the region of equilibrium is measured first.
pub(crate) const INITIAL_DIRECTIONS: usize = 8;
/// Most directions in which it is refined after that.
pub(crate) const REFINEMENTS_MAX: usize = 256;
/// Most regions in the cache.
pub(crate) const REGIONS_CACHED_MAX: usize = 256;
