//! Requests to a pair that serves, whose processes and clients are killed and interrupted.

use std::io::Read;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::time::Duration;

use serde::Serialize;
use surefoot_shared_types::instance::instance::Instance;

use crate::commands::bench::soak::faults::{Faults, Harm};
use crate::commands::bench::soak::random::Random;
use crate::commands::bench::soak::traces;
use crate::report::command_error::CommandError;
use crate::report::role::Role;
use crate::system::clock::Stopwatch;
use crate::system::terminal;

/// Longest time of a request, s.
const REQUEST_SECONDS_MAX: f64 = 120.0;
/// Longest time until a client is interrupted, ms.
const INTERRUPT_MILLIS_MAX: u64 = 60;

/// How requests ended, and the growth of the planner since its first request.
#[derive(Debug, Clone, Copy, Default, PartialEq, Serialize)]
pub(crate) struct RequestCounts {
    pub(crate) accepted: u64,
    pub(crate) cancelled: u64,
    pub(crate) no_plan: u64,
    /// Ended because a process had been killed.
    pub(crate) after_kill: u64,
    /// Time of the slowest one that was accepted, s.
    pub(crate) slowest_seconds: f64,
    /// Growth of the planner's memory, KiB.
    pub(crate) memory_growth_kib: i64,
    /// Growth of the planner's descriptors.
    pub(crate) descriptor_growth: i64,
}

/// A planner and a controller that serve.
pub(crate) struct ServingProcesses {
    scenario: PathBuf,
    name: String,
    control: Child,
    plan: Child,
    /// Memory and descriptors of the planner after its first request.
    resources: Option<(u64, u64)>,
    counts: RequestCounts,
}

impl ServingProcesses {
    /// Starts both roles.
    pub(crate) fn start(scenario: &Path) -> Result<Self, CommandError> {
        let name = format!("soak-{}", std::process::id());
        let control = start(Role::Controller, scenario, &name)?;
        let plan = start(Role::Planner, scenario, &name)?;
        wait_for_instance(&name);
        let scenario = scenario.to_owned();
        let (resources, counts) = (None, RequestCounts::default());
        Ok(Self { scenario, name, control, plan, resources, counts })
    }

    /// Sends one request, with a fault beside it now and then.
    pub(crate) fn request(
        &mut self,
        random: &mut Random,
        (faults, harm): (&mut Faults, &mut Harm),
    ) -> Result<(), CommandError> {
        let is_cancel = random.below(10) == 0;
        let goal =
            format!("{:.2},{:.2},0,0", 0.5 + centimetres(random, 250), centimetres(random, 50));
        let watch = Stopwatch::start();
        let mut client = self.client(&if is_cancel {
            vec!["--cancel".into()]
        } else {
            vec!["--goal".into(), goal.clone()]
        })?;
        let has_fault = self.fault(random, faults, &mut client)?;
        let Some(code) = wait(&mut client) else {
            harm.hung += 1;
            let fault = if has_fault { "with" } else { "without" };
            terminal::print_note(&format!("the request of {goal} {fault} a fault does not end"));
            return Ok(());
        };
        match code {
            0 if is_cancel => self.counts.cancelled += 1,
            0 => {
                self.counts.accepted += 1;
                self.counts.slowest_seconds = self.counts.slowest_seconds.max(watch.seconds());
            }
            3 => self.counts.no_plan += 1,
            _ if has_fault => self.counts.after_kill += 1,
            _ => {
                harm.wrong_ends += 1;
                let error = error_text(&mut client);
                terminal::print_note(&format!("the request of {goal} ends with {code}: {error}"));
            }
        }
        self.measure();
        Ok(())
    }

    /// Interrupts the client, or kills a role and starts it again, in one request of ten.
    fn fault(
        &mut self,
        random: &mut Random,
        faults: &mut Faults,
        client: &mut Child,
    ) -> Result<bool, CommandError> {
        let kind = random.below(20);
        std::thread::sleep(Duration::from_millis(random.below(INTERRUPT_MILLIS_MAX)));
        match kind {
            0 | 1 => {
                let number = if kind == 0 { libc::SIGINT } else { libc::SIGKILL };
                let process = libc::pid_t::try_from(client.id()).unwrap_or(libc::pid_t::MAX);
                faults.interrupts += u64::from(traces::signal(process, number));
            }
            2 => {
                end(&mut self.plan);
                self.plan = start(Role::Planner, &self.scenario, &self.name)?;
                self.resources = None;
                faults.kills += 1;
            }
            3 => {
                end(&mut self.control);
                self.control = start(Role::Controller, &self.scenario, &self.name)?;
                faults.kills += 1;
            }
            _ => return Ok(false),
        }
        Ok(true)
    }

    fn measure(&mut self) {
        let now = traces::resources(self.plan.id());
        let first = *self.resources.get_or_insert(now);
        let growth = |now: u64, first: u64| now.cast_signed() - first.cast_signed();
        let counts = &mut self.counts;
        counts.memory_growth_kib = counts.memory_growth_kib.max(growth(now.0, first.0));
        counts.descriptor_growth = counts.descriptor_growth.max(growth(now.1, first.1));
    }

    /// Ends both roles politely; returns the counts.
    pub(crate) fn end(mut self, harm: &mut Harm) -> RequestCounts {
        for child in [&mut self.plan, &mut self.control] {
            let process = libc::pid_t::try_from(child.id()).unwrap_or(libc::pid_t::MAX);
            traces::signal(process, libc::SIGTERM);
            harm.hung += u64::from(wait(child).is_none());
        }
        harm.left_over += traces::left_over(&self.name).len() as u64;
        self.counts
    }

    fn client(&self, arguments: &[String]) -> Result<Child, CommandError> {
        let failed = |source| CommandError::Start { role: Role::Planner, source };
        let mut command = Command::new(std::env::current_exe().map_err(failed)?);
        command.args(["request", "--instance", &self.name]).args(arguments);
        quiet(&mut command).stderr(Stdio::piped()).spawn().map_err(failed)
    }
}

/// Waits until the roles have made their instance, at most [`REQUEST_SECONDS_MAX`]. Without one,
/// the first request says so.
fn wait_for_instance(name: &str) {
    let watch = Stopwatch::start();
    while Instance::attach(name).is_err() && watch.seconds() < REQUEST_SECONDS_MAX {
        std::thread::sleep(Duration::from_millis(20));
    }
}

/// What an ended process wrote to its standard error.
fn error_text(child: &mut Child) -> String {
    let mut text = String::new();
    // Without it, the exit code alone is shown.
    let _ = child.stderr.take().map(|mut errors| errors.read_to_string(&mut text));
    text.trim().to_owned()
}

/// A random length below `bound` centimetres, m.
fn centimetres(random: &mut Random, bound: u64) -> f64 {
    random.below(bound) as f64 / 100.0
}

fn start(role: Role, scenario: &Path, name: &str) -> Result<Child, CommandError> {
    let failed = |source| CommandError::Start { role, source };
    let subcommand = if role == Role::Planner { "plan" } else { "control" };
    let mut command = Command::new(std::env::current_exe().map_err(failed)?);
    command.arg(subcommand).arg(scenario).args(["--instance", name, "--serve"]);
    quiet(&mut command).spawn().map_err(failed)
}

fn quiet(command: &mut Command) -> &mut Command {
    command.stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null())
}

fn end(child: &mut Child) {
    // Both fail only if the process has ended.
    let _ = child.kill();
    let _ = child.wait();
}

/// Waits for an end; returns the exit code (-1 after a signal), or kills it after
/// [`REQUEST_SECONDS_MAX`].
fn wait(child: &mut Child) -> Option<i32> {
    let watch = Stopwatch::start();
    loop {
        match child.try_wait() {
            Ok(Some(status)) => return Some(status.code().unwrap_or(-1)),
            Ok(None) if watch.seconds() < REQUEST_SECONDS_MAX => {
                std::thread::sleep(Duration::from_millis(2));
            }
            _ => {
                end(child);
                return None;
            }
        }
    }
}
