//! The resolution of the support samples and of the equilibrium regions, and the sizes of the
//! caches.

// Support of a sole.

/// Spacing of the samples over the sole, m.
pub(crate) const SAMPLE_SPACING: f64 = 5e-3;
/// Spacing of the samples around partial contact, m.
pub(crate) const FINE_SAMPLE_SPACING: f64 = 1e-3;
/// Rays begin this far above the sole, m.
pub(crate) const RAY_START: f64 = 0.02;
/// Edge samples are moved towards the middle by this share of their distance from it.
pub(crate) const EDGE_PULL: f64 = 1e-4;
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
