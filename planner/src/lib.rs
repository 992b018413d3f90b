//! A bounded, deterministic planner of whole-body, quasi-static walks (Randomized Possibility
//! Graph).
//!
//! [`rpg`] shows the whole search; read it first.

mod allowance;
pub mod ankle;
pub mod arena;
pub mod body;
pub mod carriage;
pub mod channel;
pub mod chunking;
pub mod collision;
pub mod constraint;
pub mod ends;
pub mod foot_placement;
mod foot_query;
pub mod kinematics;
pub mod motion;
pub mod outcome;
pub mod possibility;
pub mod posture;
pub mod prepare;
pub mod projection;
pub mod random;
pub mod recheck;
pub mod region;
pub mod rpg;
pub mod seeding;
pub mod shared;
pub mod snapshot;
pub mod stage;
pub mod statics;
pub mod stoop;
pub mod threads;
mod timing;
pub mod trouble;
pub mod way_back;

pub use outcome::{Outcome, Status};
pub use rpg::{Planner, PlannerError};
