//! The first actions of the command, before it reads its arguments.

use crate::system::{allocations, limits, signals};

/// The option by which a supervisor marks the process of a role.
const ROLE_OPTION: &str = "--report-lines";

/// Takes signals, and fits the system's limits and the mask of new files.
pub fn run() {
    let is_role = std::env::args_os().any(|argument| argument == ROLE_OPTION);
    signals::install(is_role);
    if is_role {
        allocations::report_to_supervisor();
    }
    limits::raise_open_files();
    limits::raise_stack();
    limits::permit_owner();
}
