//! A bounded, deterministic planner of whole-body, quasi-static walks (Randomized Possibility
//! Graph).
//!
//! [`rpg`] shows the whole search; read it first.

pub mod base;
pub mod channel;
pub mod collision;
pub mod constraints;
pub mod ends;
pub mod foot_placement;
pub mod geometry;
pub mod kinematics;
pub mod motion;
pub mod outcome;
pub mod plan;
pub mod possibility;
pub mod preparation;
pub mod primitives;
pub mod robot;
pub mod rpg;
pub mod seeding;
pub mod stage;
pub mod trouble;
pub mod way_back;

pub use outcome::Outcome;
pub use outcome::Status;
pub use rpg::Planner;
pub use rpg::PlannerError;
