//! The controller's side of Surefoot: it executes plan chunks quasi-statically and refuses those
//! that violate a check.
//!
//! Read [`walk`] first: a received chunk, from its bytes to its execution. [`check`] contains the
//! physical checks, [`plan`] applies them to an exported plan. Everything here is written from the
//! definitions (plain kinematics, statics, ray casts and separating directions) and shares no
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

pub use check::{Checker, CheckerError, MotionSegment, SegmentReport, Violation};
pub use disturbance::Disturbance;
pub use plan::{PlanReport, check_plan};
pub use truth::{GroundTruth, missing_contact};
pub use walk::{ChunkExecutor, Identity};
