//! `surefoot bench threads`: searches on one and on two threads by turns, while busy loops run on
//! some cores.

use std::num::NonZeroUsize;

use serde::Serialize;

use crate::cli::bench_arguments::ThreadsArguments;
use crate::commands::bench::machine::Machine;
use crate::commands::bench::print_report::print_report;
use crate::commands::bench::scenarios;
use crate::commands::bench::statistics::Summary;
use crate::commands::bench::table::{aligned, seconds};
use crate::commands::bench::threads::busy_loops;
use crate::commands::bench::trial::{Trial, TrialSetup};
use crate::input::inputs::Inputs;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::cores;

/// The default scenarios: searches of about 10, 50 and 300 ms.
const SCENARIOS: [&str; 3] = ["flat_walk", "rough_ground", "gauntlet_2"];
/// The numbers of threads that are compared.
const THREADS: [NonZeroUsize; 2] = [NonZeroUsize::MIN, NonZeroUsize::MIN.saturating_add(1)];

/// Everything that is reported.
#[derive(Debug, Serialize)]
struct ThreadsReport {
    schema: &'static str,
    machine: Machine,
    rows: Vec<ThreadsRow>,
}

/// One scenario beside some busy loops.
#[derive(Debug, Serialize)]
struct ThreadsRow {
    scenario: String,
    /// The cores of the busy loops.
    busy_loops: Vec<usize>,
    /// Searches on each number of threads.
    trials: usize,
    found: usize,
    /// Times of the searches on one and on two threads, s.
    mean_seconds: [f64; 2],
    p50_seconds: [f64; 2],
    max_seconds: [f64; 2],
    /// Time on two threads divided by time on one.
    mean_ratio: f64,
    p50_ratio: f64,
    /// The plan's digest, or the outcome; each that occurred.
    digests: Vec<String>,
}

/// The searches of a row so far.
struct Searches<'a> {
    inputs: &'a Inputs,
    busy_loops: Vec<usize>,
    /// On one thread, and on two.
    trials: [Vec<Trial>; 2],
}

/// Runs the command.
///
/// # Errors
/// When a scenario cannot be used, there is only one core, or a signal comes.
pub fn run(arguments: &ThreadsArguments) -> Result<CommandOutcome, CommandError> {
    let loads = loads()?;
    let scenarios = scenarios::load(&arguments.scenarios, &SCENARIOS)?;
    let machine = Machine::this()?;
    let mut searches: Vec<Searches<'_>> = loads
        .iter()
        .flat_map(|load| scenarios.iter().map(|inputs| Searches::new(inputs, load)))
        .collect();
    for turn in 0..arguments.trials {
        for searches in &mut searches {
            searches.measure(turn, &machine.program)?;
        }
    }
    let rows = searches.iter().map(Searches::row).collect();
    let report = ThreadsReport { schema: "surefoot-bench-threads/1", machine, rows };
    print_report(&report, arguments.json, || text(&report))?;
    Ok(outcome(&report))
}

/// The busy loops: none, one on either of the first two cores, and two on either.
fn loads() -> Result<[Vec<usize>; 5], CommandError> {
    let cores = cores::usable();
    let [first, second, ..] = cores[..] else {
        return Err(CommandError::Usage("bench threads needs two cores".into()));
    };
    Ok([vec![], vec![first], vec![second], vec![first; 2], vec![second; 2]])
}

fn outcome(report: &ThreadsReport) -> CommandOutcome {
    let is_any = |is: fn(&ThreadsRow) -> bool| report.rows.iter().any(is);
    if is_any(|row| row.digests.len() > 1) {
        CommandOutcome::Refused
    } else if is_any(|row| row.found < 2 * row.trials) {
        CommandOutcome::NoPlan
    } else {
        CommandOutcome::Done
    }
}

impl<'a> Searches<'a> {
    fn new(inputs: &'a Inputs, busy_loops: &[usize]) -> Self {
        Self { inputs, busy_loops: busy_loops.into(), trials: [vec![], vec![]] }
    }

    /// Searches once on each number of threads, in an order that alternates.
    fn measure(&mut self, turn: u64, program: &str) -> Result<(), CommandError> {
        let Self { inputs, busy_loops, trials } = self;
        busy_loops::run_beside(busy_loops, || {
            let order = if turn.is_multiple_of(2) { [0, 1] } else { [1, 0] };
            for index in order {
                let threads = THREADS[index];
                let seed = inputs.scenario.seed;
                let setup = TrialSetup { inputs, seed, threads, check: false };
                trials[index].push(setup.search(program)?.0);
            }
            Ok(())
        })
    }

    fn row(&self) -> ThreadsRow {
        let all = || self.trials.iter().flatten();
        let digest = |trial: &Trial| trial.digest.clone().unwrap_or(trial.outcome.clone());
        let mut digests: Vec<String> = all().map(digest).collect();
        digests.sort();
        digests.dedup();
        let of = |value: fn(&Summary) -> f64| {
            self.trials.each_ref().map(|trials| {
                let times: Vec<f64> = trials.iter().map(|trial| trial.seconds).collect();
                Summary::of(&times).as_ref().map_or(0.0, value)
            })
        };
        let (mean_seconds, p50_seconds) = (of(|all| all.mean), of(|all| all.p50));
        ThreadsRow {
            scenario: self.inputs.scenario.name.clone(),
            busy_loops: self.busy_loops.clone(),
            trials: self.trials[0].len(),
            found: all().filter(|trial| trial.is_found()).count(),
            mean_seconds,
            p50_seconds,
            max_seconds: of(|all| all.max),
            mean_ratio: mean_seconds[1] / mean_seconds[0],
            p50_ratio: p50_seconds[1] / p50_seconds[0],
            digests,
        }
    }
}

fn text(report: &ThreadsReport) -> String {
    let head = ["scenario", "busy loops", "one", "two", "ratio", "p50 one", "p50 two", "p50 ratio"];
    let mut cells = vec![head.map(str::to_owned).to_vec()];
    cells.extend(report.rows.iter().map(|row| {
        vec![
            row.scenario.clone(),
            described(&row.busy_loops),
            seconds(Some(row.mean_seconds[0])),
            seconds(Some(row.mean_seconds[1])),
            format!("{:.3}", row.mean_ratio),
            seconds(Some(row.p50_seconds[0])),
            seconds(Some(row.p50_seconds[1])),
            format!("{:.3}", row.p50_ratio),
        ]
    }));
    let plans = report.rows.iter().map(|row| {
        let cores = described(&row.busy_loops);
        format!("{} ({cores}): {}", row.scenario, row.digests.join(", "))
    });
    let mut parts =
        vec![format!("machine: {}", report.machine.describe()), String::new(), aligned(&cells)];
    parts.extend([String::new(), "Digests of all plans".to_owned()]);
    parts.extend(plans);
    parts.join("\n")
}

fn described(busy_loops: &[usize]) -> String {
    match busy_loops {
        [] => "none".to_owned(),
        [core] => format!("core {core}"),
        [core, ..] => format!("{} on core {core}", busy_loops.len()),
    }
}
