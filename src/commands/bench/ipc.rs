//! `surefoot bench ipc`: round trips of chunks and feedback over our transport and over others.
//!
//! Every transport copies the same bytes between two pinned threads: a chunk into its memory and
//! out of it, and the feedback back. Ours also writes and checks the CRC of both. In normal use the
//! controller computes the digest of the stream while it checks a chunk; one row measures a
//! controller that does only that, and one does all of it over raw memory. Only ratios within one
//! run are meaningful.

mod drive;
mod integrity;
mod iox;
mod ours;
mod raw;
mod socket;

use serde::Serialize;

use crate::cli::bench_arguments::IpcArguments;
use crate::commands::bench::machine::Machine;
use crate::commands::bench::print_report::print_report;
use crate::commands::bench::statistics::Summary;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::{cores, terminal};

use crate::commands::bench::ipc::drive::Measured;

/// The report.
#[derive(Debug, Serialize)]
struct IpcReport {
    schema: &'static str,
    machine: Machine,
    rows: Vec<Row>,
}

/// The results of one transport.
#[derive(Debug, Clone, PartialEq, Serialize)]
struct Row {
    /// The transport's name.
    transport: &'static str,
    /// Round trips.
    trials: usize,
    /// Times from publication to feedback, s.
    mean_seconds: f64,
    std_seconds: f64,
    p50_seconds: f64,
    p95_seconds: f64,
    p99_seconds: f64,
    max_seconds: f64,
    /// The median over that of raw memory.
    ratio: f64,
    /// Chunks per second with as many in flight as the transport allows.
    chunks_per_second: f64,
    /// Heap allocations of both sides during the round trips.
    allocations: u64,
}

/// Runs the command.
///
/// # Errors
/// Shared memory cannot be used.
pub(crate) fn run(arguments: &IpcArguments) -> Result<CommandOutcome, CommandError> {
    let rounds = arguments.rounds as usize;
    if cores::cores() < 2 {
        terminal::print_note(
            "one core only: both sides share it, so the scheduler determines these figures",
        );
    }
    let machine = Machine::this()?;
    let measured = [
        ("raw memory", raw::measure(rounds, false)?),
        ("raw memory, CRC and digest chain", raw::measure(rounds, true)?),
        ("surefoot", ours::measure(rounds, ours::Digests::Known)?),
        ("surefoot, digests made", ours::measure(rounds, ours::Digests::Made)?),
        ("iceoryx2, its defaults", iox::measure(rounds)?),
        ("unix socket", socket::measure(rounds)?),
    ];
    let base = measured[0].1.round_trip().p50;
    let rows: Vec<Row> =
        measured.iter().map(|(transport, measured)| row(transport, measured, base)).collect();
    let report = IpcReport { schema: "surefoot-bench-ipc/1", machine, rows };
    print_report(&report, arguments.json, || cells(&report.rows).join("\n"))?;
    Ok(CommandOutcome::Done)
}

fn row(transport: &'static str, measured: &Measured, base: f64) -> Row {
    let Summary { mean, std, p50, p95, p99, max } = measured.round_trip();
    Row {
        transport,
        trials: measured.round_trips.len(),
        mean_seconds: mean,
        std_seconds: std,
        p50_seconds: p50,
        p95_seconds: p95,
        p99_seconds: p99,
        max_seconds: max,
        ratio: p50 / base,
        chunks_per_second: measured.chunks_per_second,
        allocations: measured.allocations,
    }
}

fn cells(rows: &[Row]) -> Vec<String> {
    let head = format!(
        "{:<32}{:>9}{:>9}{:>9}{:>10}{:>8}{:>11}{:>13}",
        "transport", "p50 us", "p95 us", "p99 us", "max us", "ratio", "chunks/s", "allocations"
    );
    let micros = |seconds: f64| 1e6 * seconds;
    let line = |row: &Row| {
        let [p50, p95, p99, max] =
            [row.p50_seconds, row.p95_seconds, row.p99_seconds, row.max_seconds];
        format!(
            "{:<32}{:>9.2}{:>9.2}{:>9.2}{:>10.2}{:>8.2}{:>11.0}{:>13}",
            row.transport,
            micros(p50),
            micros(p95),
            micros(p99),
            micros(max),
            row.ratio,
            row.chunks_per_second,
            row.allocations
        )
    };
    std::iter::once(head).chain(rows.iter().map(line)).collect()
}
