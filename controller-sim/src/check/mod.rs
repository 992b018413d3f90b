//! The physical checks of a motion in one mode on given contacts, one file per check.

pub(crate) mod acceleration;
pub(crate) mod allowed_pairs;
pub(crate) mod balance;
pub(crate) mod centre_track;
pub mod checker;
pub(crate) mod checks;
pub(crate) mod collision;
pub(crate) mod contact;
pub(crate) mod continuous_collision;
pub(crate) mod course;
pub(crate) mod dynamic_torque;
pub(crate) mod feed_forward;
pub(crate) mod limits;
pub(crate) mod motion;
pub(crate) mod motion_bounds;
pub(crate) mod segment;
pub(crate) mod sole_speed;
pub(crate) mod stance_foot;
pub(crate) mod swing_clearance;
pub(crate) mod torque;
pub(crate) mod tuning;
pub(crate) mod zero_moment;

pub use course::{Course, Stop};
pub use segment::{MotionSegment, Reserves, SegmentReport, Violation};
