//! Stage P: where the robot could perhaps go [Grey 3, 4.1 to 4.3].
//!
//! Gamma_P, a pair of trees over the root's pose, grows from the start and from the goal. Only the
//! low-dimensional distance between root poses steers it; whole-body configurations are stage M's
//! business. A pose becomes a vertex where the necessary conditions C_N hold: both feet find
//! placements within reach, and the part of the robot that the root carries meets nothing. The
//! sufficient conditions C_S are soft: routes that keep the upright robot free are sought first and
//! the demand relaxed only when there are none. Out comes a guide route whose placements stage M
//! reuses.
//!
//! The root's pose is described by the ground under it: a point midway between both soles, and the
//! heading. How far the robot crouches and leans there is found out by trying.

mod branch;
mod extension;
mod forest;
mod growth;
mod label;
mod route;
mod sampling;
mod stance;
mod station;
mod stooping;
mod torso;
mod tree;

pub use forest::Labelled;
pub use growth::{Growth, Progress};
pub use label::Label;
pub use route::Route;
pub use stance::{Context, Pair, Placed};
pub use station::Station;
pub use stooping::{Site, Stooping};
pub use torso::Torso;
