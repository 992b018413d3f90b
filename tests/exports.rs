//! Exports of a plan: what they hold, that they agree with the plan, and that the formats' own
//! libraries read them. `SUREFOOT_PYTHON` names a Python interpreter with these libraries.

#![allow(clippy::print_stdout, reason = "a test prints why it is skipped")]
#![allow(clippy::unwrap_used, reason = "an export that cannot be read fails the test")]

#[path = "common/absent.rs"]
mod absent;
#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;
#[path = "exports/json.rs"]
mod json;
#[path = "exports/libraries.rs"]
mod libraries;
#[path = "exports/mcap_reader.rs"]
mod mcap_reader;
#[path = "exports/options.rs"]
mod options;
#[path = "exports/plan.rs"]
mod plan;
#[path = "exports/recording.rs"]
mod recording;
#[path = "exports/ros_reader.rs"]
mod ros_reader;
#[path = "exports/schemas.rs"]
mod schemas;
#[path = "exports/tables.rs"]
mod tables;
