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

pub(crate) mod blocked_regions;
pub mod crouch_profile;
pub mod edge_labels;
pub(crate) mod guide_route;
pub mod mid_feet_pose;
pub(crate) mod route_run;
pub mod route_search;
pub(crate) mod route_shortcuts;
pub mod upper_body;
pub mod vertex_candidates;
pub(crate) mod vertex_sampling;

pub use crouch_profile::{CrouchContext, CrouchProfile};
pub use edge_labels::Label;
pub use forest::LabelStats;
pub use guide_route::GuideRoute;
pub use mid_feet_pose::MidFeetPose;
pub use route_run::Progress;
pub use route_search::RouteSearch;
pub use upper_body::UpperBody;
pub use vertex_candidates::StageContext;

mod branch;
mod extension;
mod forest;
mod tree;
