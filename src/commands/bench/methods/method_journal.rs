//! The journal of a bench of methods.

use crate::cli::method_bench_arguments::{MethodBenchArguments, MethodSeriesArguments};
use crate::commands::bench::journal::Journal;
use crate::commands::bench::machine::Machine;
use crate::commands::bench::methods::method_trial::MethodTrial;
use crate::report::command_error::CommandError;

/// Opens the journal `name.jsonl` of this program and work limit.
///
/// # Errors
/// When it cannot be used, or holds results of another program or limit.
pub fn open(
    name: &str,
    common: &MethodBenchArguments,
    series: &MethodSeriesArguments,
    machine: &Machine,
) -> Result<Journal<MethodTrial>, CommandError> {
    let setup = format!("{} with at most {} work units", machine.build(), common.work);
    let folder = series.out.as_deref();
    Journal::open(folder, &format!("{name}.jsonl"), series.fresh, Some(&setup))
}
