//! The command under the conditions that machines impose: signals at any time, limits, namespaces,
//! pipes, files that cannot be written. No test depends on the time that anything takes.

#![allow(clippy::print_stdout, reason = "a test prints why it is skipped")]
#![allow(clippy::unwrap_used, reason = "a test ends where the command does not do its part")]

#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/absent.rs"]
mod absent;
#[allow(dead_code, reason = "each test binary uses its own part")]
#[path = "common/command.rs"]
mod command;

#[path = "surroundings/kinds.rs"]
mod kinds;
#[path = "surroundings/limits.rs"]
mod limits;
#[path = "surroundings/namespaces.rs"]
mod namespaces;
#[path = "surroundings/outputs.rs"]
mod outputs;
#[path = "surroundings/pipes.rs"]
mod pipes;
#[path = "surroundings/shell.rs"]
mod shell;
#[path = "surroundings/signals.rs"]
mod signals;
