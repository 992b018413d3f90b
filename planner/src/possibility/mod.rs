//! Stage P: guide routes over mid-feet poses [Grey 3, 4.1 to 4.3].
//!
//! Gamma_P is a pair of trees over the mid-feet pose, which grow from the start and from the goal.
//! Only the distance between poses directs them; stage M plans whole-body configurations. A pose
//! becomes a vertex if both feet find placements within reach, and the upper body is free in one of
//! some crouches. The sufficient conditions C_S are soft: routes on which the upright robot is free
//! come first, and C_S is dropped only if there are none. Where these conditions give no route, the
//! necessary conditions C_N alone are asked for, because a walk may exist where the others fail.
//! The result is a guide route, whose placements stage M uses.
//!
//! The trees leave height and pitch of the root open where the upright robot or one in some crouch
//! fits; the crouch profile chooses them. Where it does not, vertices and edges have a root pose in
//! SE(3).

pub(crate) mod blocked_regions;
pub(crate) mod coarse_path;
pub mod crouch_profile;
pub mod crouch_trial;
pub mod edge_labels;
pub(crate) mod guide_route;
pub mod mid_feet_pose;
pub(crate) mod path_following;
pub(crate) mod root_poses;
pub mod route_condition;
pub(crate) mod route_run;
pub mod route_search;
pub(crate) mod route_shortcuts;
pub mod upper_body;
pub mod vertex_candidates;
pub(crate) mod vertex_sampling;

pub use crouch_profile::CrouchProfile;
pub use crouch_trial::CrouchContext;
pub use edge_labels::Label;
pub use forest::LabelStats;
pub use guide_route::{GuideRoute, IdealWidth};
pub use mid_feet_pose::MidFeetPose;
pub use route_condition::RouteCondition;
pub use route_run::Progress;
pub use route_search::RouteSearch;
pub(crate) use tuning::SPACING_PER_REACH;
pub use upper_body::{UpperBody, UpperBodyFit};
pub use vertex_candidates::StageContext;

mod branch;
mod extension;
mod forest;
mod joining;
mod lean_reduction;
mod leaning;
pub(crate) mod root_postures;
pub mod root_vertex;
mod tree;
mod tuning;
