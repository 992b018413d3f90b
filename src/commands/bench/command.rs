//! `surefoot bench`: measures on this machine. Each bench has a file of its own; `docs/BENCHES.md`
//! documents their JSON.

use crate::cli::bench_arguments::{BenchArguments, BenchCommand};
use crate::commands::bench::footholds::footholds_bench;
use crate::commands::bench::goals;
use crate::commands::bench::holes;
use crate::commands::bench::impossible;
use crate::commands::bench::ipc;
use crate::commands::bench::late;
use crate::commands::bench::lower_bound;
use crate::commands::bench::methods::{methods_bench, rho_bench, theory_bench};
use crate::commands::bench::mutations::mutations_bench;
use crate::commands::bench::replan::replan_bench;
use crate::commands::bench::scale::scale_bench;
use crate::commands::bench::soak::soak_bench;
use crate::commands::bench::steps;
use crate::commands::bench::thesis::thesis_bench;
use crate::commands::bench::threads::threads_bench;
use crate::report::command_error::{CommandError, CommandOutcome};

/// Runs the command.
///
/// # Errors
/// When an input cannot be used, an output cannot be written, or a signal comes.
pub fn run(arguments: &BenchArguments) -> Result<CommandOutcome, CommandError> {
    let _deferral = crate::system::signals::defer();
    match &arguments.bench {
        BenchCommand::Thesis(arguments) => thesis_bench::run(arguments),
        BenchCommand::LowerBound(arguments) => lower_bound::run(arguments),
        BenchCommand::Replan(arguments) => replan_bench::run(arguments),
        BenchCommand::Steps(arguments) => steps::run(arguments),
        BenchCommand::Scale(arguments) => scale_bench::run(arguments),
        BenchCommand::Threads(arguments) => threads_bench::run(arguments),
        BenchCommand::Ipc(arguments) => ipc::run(arguments),
        BenchCommand::Soak(arguments) => soak_bench::run(arguments),
        BenchCommand::Footholds(arguments) => footholds_bench::run(arguments),
        BenchCommand::Goals(arguments) => goals::run(arguments),
        BenchCommand::Holes(arguments) => holes::run(arguments),
        BenchCommand::Impossible(arguments) => impossible::run(arguments),
        BenchCommand::Late(arguments) => late::run(arguments),
        BenchCommand::Mutations(arguments) => mutations_bench::run(arguments),
        BenchCommand::Methods(arguments) => methods_bench::run(arguments),
        BenchCommand::Rho(arguments) => rho_bench::run(arguments),
        BenchCommand::Theory(arguments) => theory_bench::run(arguments),
    }
}
