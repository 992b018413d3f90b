//! `surefoot bench mutations`: plans of the planner, changed at random. The controller refuses
//! each, or the robot stands when it executes it.

mod contact_changes;
mod kinds;
mod motion_changes;
pub mod mutations_bench;
mod mutations_report;
mod rate_changes;
mod subject;
mod torque_changes;
mod world_changes;
