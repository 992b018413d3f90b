//! The command `surefoot bench soak`.

use serde::Serialize;

use crate::cli::bench_arguments::SoakArguments;
use crate::commands::bench::print_report::print_report;
use crate::commands::bench::soak::faults::{Faults, Harm};
use crate::commands::bench::soak::random::Random;
use crate::commands::bench::soak::requests::{RequestCounts, ServingProcesses};
use crate::commands::bench::soak::walks::WalkSettings;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::clock::Stopwatch;
use crate::system::signals;

/// Everything that is reported.
#[derive(Debug, Default, Serialize)]
struct SoakReport {
    schema: &'static str,
    seed: u64,
    seconds: f64,
    walks: u64,
    requests: u64,
    faults: Faults,
    harm: Harm,
    request_ends: RequestCounts,
}

/// Runs the command.
///
/// # Errors
/// A walk without faults fails, a process cannot be started, or a signal comes.
pub fn run(arguments: &SoakArguments) -> Result<CommandOutcome, CommandError> {
    let watch = Stopwatch::start();
    let mut random = Random::new(arguments.seed);
    let mut report = SoakReport {
        schema: "surefoot-bench-soak/1",
        seed: arguments.seed,
        ..SoakReport::default()
    };
    walk(arguments, &watch, &mut random, &mut report)?;
    request(arguments, &watch, &mut random, &mut report)?;
    report.seconds = watch.seconds();
    print_report(&report, arguments.json, || text(&report))?;
    let is_harmless = report.harm == Harm::default();
    Ok(if is_harmless { CommandOutcome::Done } else { CommandOutcome::Refused })
}

fn walk(
    arguments: &SoakArguments,
    watch: &Stopwatch,
    random: &mut Random,
    report: &mut SoakReport,
) -> Result<(), CommandError> {
    if arguments.walks == 0 {
        return Ok(());
    }
    let folder = tempfile::tempdir().map_err(|error| CommandError::Output {
        path: std::env::temp_dir(),
        reason: error.to_string(),
    })?;
    let settings = WalkSettings {
        scenario: &arguments.scenario,
        motion: arguments.motion,
        rate: arguments.rate,
        folder: folder.path(),
    };
    let expected = settings.undisturbed()?;
    while report.walks < arguments.walks && may_go_on(arguments, watch)? {
        let counts = (&mut report.faults, &mut report.harm);
        settings.walk(&expected, random, counts)?;
        report.walks += 1;
    }
    Ok(())
}

fn request(
    arguments: &SoakArguments,
    watch: &Stopwatch,
    random: &mut Random,
    report: &mut SoakReport,
) -> Result<(), CommandError> {
    if arguments.requests == 0 {
        return Ok(());
    }
    let mut pair = ServingProcesses::start(&arguments.request_scenario)?;
    while report.requests < arguments.requests && may_go_on(arguments, watch)? {
        pair.request(random, (&mut report.faults, &mut report.harm))?;
        report.requests += 1;
    }
    report.request_ends = pair.end(&mut report.harm);
    Ok(())
}

fn may_go_on(arguments: &SoakArguments, watch: &Stopwatch) -> Result<bool, CommandError> {
    match signals::raised() {
        Some(signal) => Err(CommandError::Interrupted(signal)),
        None => Ok(watch.seconds() < arguments.seconds),
    }
}

fn text(report: &SoakReport) -> String {
    let SoakReport { seed, seconds, walks, requests, faults, harm, request_ends: ends, .. } =
        report;
    format!(
        "seed {seed}: {walks} walks and {requests} requests in {seconds:.0} s\n  \
         faults    {} kills, {} stops, {} forged or repeated messages, {} interrupted walks and clients\n  \
         harm      {} lost, {} twice, {} hung, {} left over, {} wrong ends\n  \
         requests  {} accepted, {} cancelled, {} without a plan, {} ended by a fault, slowest {:.1} s\n  \
         planner   {} KiB and {} descriptors more than after its first request",
        faults.kills,
        faults.stops,
        faults.messages,
        faults.interrupts,
        harm.lost,
        harm.twice,
        harm.hung,
        harm.left_over,
        harm.wrong_ends,
        ends.accepted,
        ends.cancelled,
        ends.no_plan,
        ends.after_kill,
        ends.slowest_seconds,
        ends.memory_growth_kib,
        ends.descriptor_growth,
    )
}
