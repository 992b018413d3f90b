//! The controller's side of Surefoot: it walks plan chunks quasi-statically and refuses what does
//! not hold.
//!
//! Read [`walk`] first: one received chunk, from its bytes to the verdict. [`check`] judges the
//! physics, [`plan`] applies the same checks to an exported plan. Everything here is written from
//! the definitions (plain kinematics, statics, ray casts and separating directions) and shares no
//! algorithm with the planner: only data, file loading and rigid motions.

pub mod admission;
mod bound;
pub mod channel;
pub mod check;
pub mod continuity;
pub mod disturbance;
mod draw;
pub mod geometry;
pub mod kinematics;
mod leg;
pub mod plan;
pub mod simulation;
pub mod truth;
pub mod walk;

pub use check::{Checker, CheckerError, Segment, SegmentReport, Violation};
pub use disturbance::Disturbance;
pub use plan::{PlanReport, check_plan};
pub use truth::{Truth, nothing_carries};
pub use walk::{Identity, Walker};
