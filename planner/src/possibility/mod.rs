//! Stage P: where the robot could perhaps go [Grey 3, 4.1 to 4.3].
//!
//! Gamma_P, a pair of trees over the root's pose, grows from the start and from the goal. Only the
//! low-dimensional distance between root poses steers it; whole-body configurations are stage M's
//! business. A pose becomes a vertex where the necessary conditions C_N hold: both feet find
//! placements within reach, and the upper body collides with nothing. The
//! sufficient conditions C_S are soft: routes that keep the upright robot free are sought first and
//! the demand relaxed only when there are none. Out comes a guide route whose placements stage M
//! reuses.
//!
//! The root's pose is described by the ground under it: a point midway between both soles, and the
//! heading. Crouch and lean are found by trying a list of them.

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

pub use crate::prepare::FootPlacement;
pub use forest::LabelStats;
pub use growth::{Progress, RouteSearch};
pub use label::Label;
pub use route::GuideRoute;
pub use stance::{FootPair, StageContext};
pub use station::MidFeetPose;
pub use stooping::{CrouchContext, CrouchProfile};
pub use torso::UpperBody;
