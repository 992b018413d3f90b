//! foot_placement.

pub(crate) mod algorithm_1;
pub(crate) mod candidates;
pub mod config;
pub(crate) mod foothold_query;
pub(crate) mod nests;
pub(crate) mod planes;
pub mod propose;
pub(crate) mod rough_ground;
pub mod scratch;
pub(crate) mod sole_fit;
pub mod sole_support;
pub(crate) mod support;
pub mod surfaces;
pub(crate) mod world_elements;

pub use config::FootPlacementConfig;
pub use propose::{PlacementQuery, PlacementStats, SampleLimits, Source, SupportedSole};
pub use scratch::Scratch;
pub use surfaces::Surfaces;
