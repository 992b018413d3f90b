//! The checker of Surefoot: it refuses plan chunks that violate a check and executes the others on
//! a simulated robot.
//!
//! [`execution::executor`] follows a received chunk from its bytes to its execution. [`check`]
//! holds the physical checks, [`plan`] applies them to an exported plan, [`channel`] receives
//! chunks from a planner in another process. The kinematics, statics and collision code is written
//! from the definitions and shares no algorithm with the planner: only data, file loading and rigid
//! motions.

pub(crate) mod base;
pub mod channel;
pub mod check;
pub mod chunk;
pub mod execution;
pub mod geometry;
pub mod kinematics;
pub mod plan;
pub mod statics;

#[cfg(test)]
#[path = "../tests/check_robot/mod.rs"]
mod check_robot;

pub use check::checker::Checker;
pub use check::{Course, MotionSegment, Reserves, SegmentReport, Stop, Violation};
pub use chunk::{Identity, check_content};
pub use execution::chunk_walk::ChunkWalk;
pub use execution::disturbance::Disturbance;
pub use execution::executor::ChunkExecutor;
pub use execution::ground_truth::{GroundTruth, missing_contact};
pub use execution::late_chunks::{LATE_SHARE, LateChunks};
pub use execution::late_walk::{LateWalk, walk_late};
pub use execution::plan_clock::{Pace, PlanClock, PlanInstant, StopCounts};
pub use execution::plan_ends::Goal;
pub use plan::plan_check::{PlanReport, check_plan, check_plan_in};
pub use plan::problem::Problem;
pub use statics::{CheckerError, HollowSole};
