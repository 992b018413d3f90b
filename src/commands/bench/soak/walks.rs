//! Walks whose roles are killed and stopped, and whose messages are forged and repeated.

use std::fs;
use std::os::unix::process::ExitStatusExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, ExitStatus, Stdio};
use std::time::Duration;

use serde_json::Value;
use surefoot_shared_types::config::MotionKind;

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
/// Longest time that the roles of a walk that was cut short take to end, s.
const ROLES_SECONDS_MAX: f64 = 10.0;

/// Exit code of a walk that was interrupted.
const INTERRUPTED_CODE: i32 = 128 + libc::SIGINT;
/// The signal that ends a walk that is interrupted twice.
const INTERRUPT: Option<i32> = Some(libc::SIGINT);

/// The result of a walk without faults.
#[derive(Debug, Clone)]
pub(crate) struct Undisturbed {
    digest: Value,
    chunks: u64,
}

/// The walks of a soak.
pub(crate) struct WalkSettings<'a> {
    pub(crate) scenario: &'a Path,
    pub(crate) motion: Option<MotionKind>,
    pub(crate) rate: Option<f64>,
    /// Where the report and the errors of each walk go.
    pub(crate) folder: &'a Path,
}

/// Seeds of what a walk suffers from the beginning on.
#[derive(Debug, Clone, Copy, Default)]
struct Disturbances {
    /// Of misplaced feet, and of lost and late feedback.
    disturb: Option<u64>,
    /// Of late chunks.
    late: Option<u64>,
}

impl WalkSettings<'_> {
    /// Walks the scenario without faults.
    pub(crate) fn undisturbed(&self) -> Result<Undisturbed, CommandError> {
        let mut child = self.start(&Disturbances::default())?;
        let code = wait(&mut child, &mut FaultLog::new()).and_then(|status| status.code());
        let report = self.read_report();
        match (code, report["chunks"]["accepted"].as_u64()) {
            (Some(0), Some(chunks)) => Ok(Undisturbed { digest: report["digest"].clone(), chunks }),
            _ => Err(CommandError::Usage(format!(
                "{}: the walk without faults ends with {code:?}: {}",
                self.scenario.display(),
                self.error_text().trim_end()
            ))),
        }
    }

    /// One walk with faults.
    pub(crate) fn walk(
        &self,
        expected: &Undisturbed,
        random: &mut Random,
        (faults, harm): (&mut Faults, &mut Harm),
    ) -> Result<(), CommandError> {
        // One walk of four has misplaced feet, another one late chunks.
        let kind = random.below(4);
        let seed = random.below(1000);
        let disturbances = Disturbances {
            disturb: (kind == 0).then_some(seed),
            late: (kind == 1).then_some(seed),
        };
        let mut child = self.start(&disturbances)?;
        let name = format!("walk-{}", child.id());
        let before = *faults;
        let mut log = FaultLog::new();
        let walked = inject(&mut child, &name, random, (faults, &mut log));
        let status = wait(&mut child, &mut log);
        let known = *harm;
        let is_interrupted = faults.interrupts > before.interrupts;
        let code = status.and_then(|status| status.code());
        // A second interrupt ends a process at once.
        let is_cut_short = is_interrupted && status.and_then(|status| status.signal()) == INTERRUPT;
        if is_cut_short {
            wait_for_roles(&name);
        }
        harm.left_over += traces::left_over(&name).len() as u64;
        match code {
            None if status.is_none() => harm.hung += 1,
            None if is_cut_short => {}
            Some(0) => {
                let may_differ = disturbances.disturb.is_some();
                compare(&self.read_report(), expected, (walked, may_differ), harm);
            }
            // Misplaced feet may leave no plan.
            Some(3 | 4) if disturbances.disturb.is_some() => {}
            Some(INTERRUPTED_CODE) if is_interrupted => {}
            _ => harm.wrong_ends += 1,
        }
        // A process that panics is started anew, so that the walk may end well.
        harm.wrong_ends += u64::from(self.error_text().contains("panicked at"));
        if *harm != known {
            let Disturbances { disturb, late } = disturbances;
            let (events, errors) = (log.events.join(", "), self.error_text());
            terminal::print_note(&format!(
                "{name} (disturb {disturb:?}, late {late:?}) ends with {status:?}\n  {events}\n{errors}"
            ));
        }
        Ok(())
    }

    fn start(&self, disturbances: &Disturbances) -> Result<Child, CommandError> {
        let failed = |source| CommandError::Start { role: Role::Planner, source };
        let program = std::env::current_exe().map_err(failed)?;
        let errors = fs::File::create(self.folder.join("errors")).map_err(failed)?;
        // A report of the walk before must not be read.
        let _ = fs::remove_file(self.report());
        let mut command = Command::new(program);
        command.arg("walk").arg(self.scenario).args(["--quiet", "--threads", "1"]);
        command.args(["--restarts-max", "1000", "--json"]).arg(self.report());
        let number = |number: u64| number.to_string();
        let options = [
            ("--motion", self.motion.map(|motion| motion.name().to_owned())),
            ("--rate", self.rate.map(|rate| rate.to_string())),
            ("--disturb", disturbances.disturb.map(number)),
            ("--late", disturbances.late.map(number)),
        ];
        for (option, value) in options {
            command.args(value.iter().flat_map(|value| [option, value]));
        }
        command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(errors).spawn().map_err(failed)
    }

    fn report(&self) -> PathBuf {
        self.folder.join("report.json")
    }

    fn read_report(&self) -> Value {
        let bytes = fs::read(self.report()).ok();
        bytes.and_then(|bytes| serde_json::from_slice(&bytes).ok()).unwrap_or_default()
    }

    fn error_text(&self) -> String {
        fs::read_to_string(self.folder.join("errors")).unwrap_or_default()
    }
}

/// Waits until the roles of a walk whose supervisor is gone have ended and removed their files.
fn wait_for_roles(name: &str) {
    let watch = Stopwatch::start();
    while watch.seconds() < ROLES_SECONDS_MAX && !traces::left_over(name).is_empty() {
        std::thread::sleep(Duration::from_millis(5));
    }
}

/// Compares an accepted walk with the one without faults. Misplaced feet may have it planned
/// again.
fn compare(
    report: &Value,
    expected: &Undisturbed,
    (walked, may_differ): (Option<(u64, bool)>, bool),
    harm: &mut Harm,
) {
    harm.lost += report["chunks"]["lost"].as_u64().unwrap_or(1);
    if report["digest"] != expected.digest || report["replans"] != 0 {
        harm.wrong_ends += u64::from(!may_differ);
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

/// What a walk suffers, reported if it comes to harm.
struct FaultLog {
    watch: Stopwatch,
    events: Vec<String>,
}

impl FaultLog {
    /// Begins now.
    fn new() -> Self {
        Self { watch: Stopwatch::start(), events: Vec::new() }
    }

    /// Counts an event that has happened.
    fn count(&mut self, has_happened: bool, count: &mut u64, event: &str) {
        if has_happened {
            *count += 1;
            self.events.push(format!("{:.3} s: {event}", self.watch.seconds()));
        }
    }
}

/// Injects faults until the walk ends or has [`FAULTS_MAX`]; returns the robot's last progress.
fn inject(
    child: &mut Child,
    name: &str,
    random: &mut Random,
    (faults, log): (&mut Faults, &mut FaultLog),
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
        match random.below(9) {
            0..=2 => {
                let has_killed = signal(child, role, libc::SIGKILL);
                log.count(has_killed, &mut faults.kills, &format!("{role} killed"));
            }
            3 | 4 => {
                let has_stopped = signal(child, role, libc::SIGSTOP);
                std::thread::sleep(Duration::from_millis(random.below(STOP_MILLIS_MAX)));
                signal(child, role, libc::SIGCONT);
                log.count(has_stopped, &mut faults.stops, &format!("{role} went on after a stop"));
            }
            5 if random.below(4) == 0 => {
                let process = libc::pid_t::try_from(child.id()).unwrap_or(libc::pid_t::MAX);
                let has_interrupted = traces::signal(process, libc::SIGINT);
                log.count(has_interrupted, &mut faults.interrupts, "the walk interrupted");
            }
            _ => {
                let forged = forger.as_ref().and_then(|forger| forger.disturb(random));
                let event = forged.unwrap_or_default();
                log.count(forged.is_some(), &mut faults.messages, event);
            }
        }
    }
    let mut forger = forger?;
    while is_running(child) && log.watch.seconds() < WALK_SECONDS_MAX {
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

/// Waits for the end of a walk; returns how it ended, or kills it [`WALK_SECONDS_MAX`] after its
/// start.
fn wait(child: &mut Child, log: &mut FaultLog) -> Option<ExitStatus> {
    while is_running(child) {
        if log.watch.seconds() > WALK_SECONDS_MAX {
            log.events.push(format!("at the end: {}", traces::family_of(child.id())));
            // Fails only if it has just ended.
            let _ = child.kill();
            let _ = child.wait();
            return None;
        }
        std::thread::sleep(Duration::from_millis(2));
    }
    child.wait().ok()
}
