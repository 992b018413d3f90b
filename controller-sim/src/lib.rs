//! The controller's side of Surefoot: it executes plan chunks quasi-statically and refuses those
//! that violate a check.
//!
//! Read [`walk`] first: a received chunk, from its bytes to its execution. [`check`] contains the
//! physical checks, [`plan`] applies them to an exported plan. Everything here is written from the
//! definitions (plain kinematics, statics, ray casts and separating directions) and shares no
//! algorithm with the planner: only data, file loading and rigid motions.

pub mod base;
pub mod channel;
pub mod check;
pub mod chunk;
pub mod execution;
pub mod geometry;
pub mod kinematics;
pub mod plan;
pub mod statics;

pub use check::checker::Checker;
pub use check::checker::CheckerError;
pub use check::checker::MotionSegment;
pub use check::checker::SegmentReport;
pub use check::checker::Violation;
pub use chunk::message_check::Identity;
pub use execution::disturbance::Disturbance;
pub use execution::executor::ChunkExecutor;
pub use execution::ground_truth::GroundTruth;
pub use execution::ground_truth::missing_contact;
pub use plan::plan_check::PlanReport;
pub use plan::plan_check::check_plan;
