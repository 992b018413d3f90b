//! A bounded, deterministic planner of whole-body walks (Randomized Possibility Graph).
//!
//! [`Planner`] shows the whole search; read `pipeline/planner.rs` first.

pub mod base;
pub mod channel;
pub mod collision;
pub mod constraints;
pub mod foot_placement;
pub mod geometry;
pub mod kinematics;
pub mod methods;
pub mod motion;
pub mod pipeline;
pub mod plan;
pub mod possibility;
pub mod preparation;
pub mod primitives;
pub mod relaxation;
pub mod robot;
pub mod smooth_path;
pub mod theory;
pub mod timing;

pub use pipeline::{Outcome, Planner, PlannerBuilder, PlannerError, Status};
