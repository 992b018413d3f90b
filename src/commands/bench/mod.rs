//! `surefoot bench`: measures on this machine. Each bench has a file of its own; `docs/BENCHES.md`
//! documents their JSON.

pub mod arguments;
mod courses;
pub mod footholds;
pub mod ipc;
mod journal;
mod limit;
mod machine;
mod pieces;
mod replan;
mod row;
mod scale;
pub mod statistics;
mod steps;
mod table;
mod thesis;
mod trial;

use crate::failure::{CommandError, CommandOutcome};
use arguments::{BenchArguments, BenchCommand};

/// Runs the command.
///
/// # Errors
/// When an input cannot be used, an output cannot be written, or a signal comes.
pub fn run(arguments: &BenchArguments) -> Result<CommandOutcome, CommandError> {
    crate::signals::install();
    match &arguments.bench {
        BenchCommand::Thesis(arguments) => thesis::run(arguments),
        BenchCommand::Limit(arguments) => limit::run(arguments),
        BenchCommand::Replan(arguments) => replan::run(arguments),
        BenchCommand::Steps(arguments) => steps::run(arguments),
        BenchCommand::Scale(arguments) => scale::run(arguments),
        BenchCommand::Ipc(arguments) => ipc::run(arguments),
        BenchCommand::Footholds(arguments) => footholds::run(arguments),
    }
}
