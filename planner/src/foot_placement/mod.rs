//! Where a sole can stand on any geometry [Grey 4.1.2, 4.2].
//!
//! [`Surfaces`] is compiled once from a world: every planar face (coplanar triangles merged), every
//! line and cap of a curved shape, and a bounding volume hierarchy over them. [`Surfaces::support`]
//! computes the support of a sole at a pose. [`propose()`] finds poses with support: set down where
//! the ground is rough, read off the geometry elsewhere, then by the thesis's Algorithm 1.
//! [`propose_nests`] finds those that only a second face holds. All work in a [`Scratch`] of the
//! caller and do not allocate.
//!
//! Limits: curved surfaces support along a line or at a point only, not on a strip; steep walls
//! do not support; a solid that encloses the whole foot has no surface near the sole, so the
//! caller's collision test (`is_free`) must reject that pose.

mod algorithm_1;
mod bearing;
mod bounded;
mod candidates;
mod config;
mod elements;
mod features;
pub(crate) mod foothold_query;
mod geometric;
mod nests;
mod plane_features;
mod planes;
mod posed_sole;
mod proposal;
mod propose;
mod request;
pub(crate) mod resting_sole;
mod rough_ground;
mod scratch;
mod sole_fit;
pub mod sole_support;
mod support;
mod surfaces;
mod tuning;
mod world_elements;

pub(crate) use bearing::{Bearing, find_bearing};
pub use config::FootPlacementConfig;
pub(crate) use config::{LeastSupport, SoleNeeds};
pub use nests::propose_nests;
pub use posed_sole::SoleShape;
pub use propose::propose;
pub use request::{PlacementQuery, PlacementStats, SampleLimits, Source, SupportedSole};
pub use scratch::Scratch;
pub use surfaces::Surfaces;
pub use tuning::YAW_SPREAD_MAX;
