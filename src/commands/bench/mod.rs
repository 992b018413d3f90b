//! `surefoot bench`: measures on this machine. Each bench has a file of its own.

pub mod arguments;
pub mod footholds;
pub mod ipc;

use crate::failure::{Ending, Failure};
use arguments::{BenchArguments, BenchCommand};

/// Runs the command.
///
/// # Errors
/// When something needed for it cannot be used, or a signal comes.
pub fn run(arguments: &BenchArguments) -> Result<Ending, Failure> {
    crate::signals::install();
    match &arguments.bench {
        BenchCommand::Ipc(arguments) => ipc::run(arguments),
        BenchCommand::Footholds(arguments) => footholds::run(arguments),
    }
}
