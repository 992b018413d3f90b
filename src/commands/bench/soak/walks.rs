//! Walks whose roles are killed and stopped, and whose messages are forged and repeated.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde_json::Value;

use crate::commands::bench::soak::faults::{Faults, Harm};
use crate::commands::bench::soak::forger::Forger;
use crate::commands::bench::soak::random::Random;
use crate::commands::bench::soak::traces;
use crate::report::command_error::CommandError;
use crate::report::role::Role;
use crate::system::clock::Stopwatch;
use crate::system::terminal;

/// Longest time of a walk, s.
const WALK_SECONDS_MAX: f64 = 180.0;
/// Most faults of a walk.
const FAULTS_MAX: u64 = 6;
/// Longest time between two faults, ms.
const GAP_MILLIS_MAX: u64 = 150;
/// Longest stop of a process, ms.
const STOP_MILLIS_MAX: u64 = 120;
/// Exit code of a walk that ended with an error.
const ERROR_CODE: i32 = 2;

/// The result of a walk without faults.
#[derive(Debug, Clone)]
pub(crate) struct Undisturbed {
    digest: Value,
    chunks: u64,
}

/// Walks a scenario without faults.
pub(crate) fn undisturbed(scenario: &Path, folder: &Path) -> Result<Undisturbed, CommandError> {
    let report = folder.join("report.json");
    let mut child = start(scenario, &report, None, folder)?;
    let code = wait(&mut child);
    let report = read_report(&report);
    match (code, report["chunks"]["accepted"].as_u64()) {
        (Some(0), Some(chunks)) => Ok(Undisturbed { digest: report["digest"].clone(), chunks }),
        _ => Err(CommandError::Usage(format!(
            "{}: the walk without faults ends with {code:?}: {}",
            scenario.display(),
            error_text(folder)
        ))),
    }
}

/// One walk with faults.
pub(crate) fn walk(
    scenario: &Path,
    folder: &Path,
    expected: &Undisturbed,
    random: &mut Random,
    (faults, harm): (&mut Faults, &mut Harm),
) -> Result<(), CommandError> {
    let path = folder.join("report.json");
    // A seed of lost and late feedback for one walk of four.
    let disturb = (random.below(4) == 0).then(|| random.below(1000));
    let mut child = start(scenario, &path, disturb, folder)?;
    let name = format!("walk-{}", child.id());
    let messages_before = faults.messages;
    let walked = inject(&mut child, &name, random, faults);
    let code = wait(&mut child);
    harm.left_over += traces::left_over(&name).len() as u64;
    let is_forged = faults.messages > messages_before;
    let report = read_report(&path);
    let is_error = code == Some(ERROR_CODE) && is_forged;
    match code {
        None => harm.hung += 1,
        Some(0) => compare(&report, expected, walked, harm),
        // Misplaced feet may leave no plan.
        Some(3 | 4) if disturb.is_some() => {}
        _ if is_error && error_text(folder).contains("answer as this instance's controller") => {}
        _ => {
            harm.wrong_ends += 1;
            terminal::print_note(&format!("{name} ends with {code:?}: {}", error_text(folder)));
        }
    }
    Ok(())
}

/// Compares an accepted walk with the one without faults.
fn compare(report: &Value, expected: &Undisturbed, walked: Option<(u64, bool)>, harm: &mut Harm) {
    harm.lost += report["chunks"]["lost"].as_u64().unwrap_or(1);
    if report["digest"] != expected.digest || report["replans"] != 0 {
        return;
    }
    let accepted = report["chunks"]["accepted"].as_u64().unwrap_or(0);
    harm.lost += expected.chunks.saturating_sub(accepted);
    harm.twice += accepted.saturating_sub(expected.chunks);
    if let Some((walked, true)) = walked {
        harm.lost += expected.chunks.saturating_sub(walked);
        harm.twice += walked.saturating_sub(expected.chunks);
    }
}

/// Injects faults until the walk ends or has [`FAULTS_MAX`]; returns the robot's last progress.
fn inject(
    child: &mut Child,
    name: &str,
    random: &mut Random,
    faults: &mut Faults,
) -> Option<(u64, bool)> {
    let mut forger = None;
    for _ in 0..FAULTS_MAX {
        let gap = Duration::from_millis(random.below(GAP_MILLIS_MAX));
        match &mut forger {
            Some(forger) => Forger::listen_for(forger, gap),
            None => {
                std::thread::sleep(gap);
                forger = Forger::open(name).ok();
            }
        }
        if !is_running(child) {
            break;
        }
        let role = ["plan", "control"][random.below(2) as usize];
        match random.below(4) {
            0 => faults.kills += u64::from(signal(child, role, libc::SIGKILL)),
            1 => {
                let has_stopped = signal(child, role, libc::SIGSTOP);
                std::thread::sleep(Duration::from_millis(random.below(STOP_MILLIS_MAX)));
                signal(child, role, libc::SIGCONT);
                faults.stops += u64::from(has_stopped);
            }
            _ => {
                let has_sent = forger.as_ref().is_some_and(|forger| forger.disturb(random));
                faults.messages += u64::from(has_sent);
            }
        }
    }
    let mut forger = forger?;
    let watch = Stopwatch::start();
    while is_running(child) && watch.seconds() < WALK_SECONDS_MAX {
        forger.listen_for(Duration::from_millis(5));
    }
    forger.walked()
}

fn signal(walk: &Child, role: &str, number: libc::c_int) -> bool {
    traces::child_of(walk.id(), role).is_some_and(|process| traces::signal(process, number))
}

fn is_running(child: &mut Child) -> bool {
    matches!(child.try_wait(), Ok(None))
}

fn start(
    scenario: &Path,
    report: &Path,
    disturb: Option<u64>,
    folder: &Path,
) -> Result<Child, CommandError> {
    let failed = |source| CommandError::Start { role: Role::Planner, source };
    let program = std::env::current_exe().map_err(failed)?;
    let errors = fs::File::create(folder.join("errors")).map_err(failed)?;
    // A report of the walk before must not be read.
    let _ = fs::remove_file(report);
    let mut command = Command::new(program);
    command.arg("walk").arg(scenario).args(["--quiet", "--threads", "1"]);
    command.args(["--restarts-max", "1000", "--json"]).arg(report);
    if let Some(seed) = disturb {
        command.args(["--disturb", &seed.to_string()]);
    }
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(errors).spawn().map_err(failed)
}

/// Waits for the end of a walk; returns its exit code, or kills it after [`WALK_SECONDS_MAX`].
fn wait(child: &mut Child) -> Option<i32> {
    let watch = Stopwatch::start();
    while is_running(child) {
        if watch.seconds() > WALK_SECONDS_MAX {
            // Fails only if it has just ended.
            let _ = child.kill();
            let _ = child.wait();
            return None;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    child.wait().ok()?.code()
}

fn read_report(path: &Path) -> Value {
    fs::read(path).ok().and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or_default()
}

fn error_text(folder: &Path) -> String {
    let text = fs::read_to_string(folder.join("errors")).unwrap_or_default();
    text.lines().last().unwrap_or_default().to_owned()
}
