//! `surefoot walk`: a planner process, a controller process, and the verdict.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use surefoot_shared_types::instance::Instance;
use surefoot_shared_types::plan_file::load::load_plan;
use surefoot_shared_types::scene::load::load_world;

use super::conclude;
use crate::affinity::cores_of_roles;
use crate::arguments::{SearchArguments, WalkArguments};
use crate::failure::{Ending, Failure};
use crate::inputs::Inputs;
use crate::line::{DeliveryEnd, Line, PlanEnd};
use crate::progress::Progress;
use crate::report::Report;
use crate::supervisor::{Event, Role, Supervisor};
use crate::{outputs, signals, terminal, verdict};

/// Runs the command.
///
/// # Errors
/// When an input cannot be used, an output cannot be written, a process fails, or a signal comes.
pub fn run(arguments: &WalkArguments) -> Result<Ending, Failure> {
    let inputs = Inputs::load(&arguments.search.scenario, arguments.search.seed)?;
    outputs::check(&arguments.outputs)?;
    if let Some(truth) = &arguments.truth {
        load_world(truth)?;
    }
    inputs.preparation(arguments.outputs.quiet)?;
    signals::install();
    let export = Export::new(arguments)?;
    let mut report = Report::new(&inputs, arguments.search.threads());
    let json = arguments.outputs.json.as_deref();
    if let Err(failure) = walk(arguments, &inputs, export.path.as_deref(), &mut report) {
        report.note_failure(&failure);
        if let (Some(path), Some(_)) = (json, failure.word()) {
            outputs::write_json(&report, path)?;
        }
        return Err(failure);
    }
    if let (Some(picture), Some(plan), true) =
        (&arguments.outputs.picture, &export.path, report.has_plan())
    {
        outputs::draw(&inputs, &load_plan(plan)?, picture)?;
    }
    let ending = conclude(&report, json)?;
    terminal::say(&verdict::text(&report));
    Ok(ending)
}

/// Where the planner process leaves the plan: where the user wants it, or where only the picture
/// needs it.
struct Export {
    path: Option<PathBuf>,
    _folder: Option<tempfile::TempDir>,
}

impl Export {
    fn new(arguments: &WalkArguments) -> Result<Self, Failure> {
        let outputs = &arguments.outputs;
        if outputs.export.is_some() || outputs.picture.is_none() {
            return Ok(Self { path: outputs.export.clone(), _folder: None });
        }
        let folder = tempfile::Builder::new().prefix("surefoot-picture-").tempdir();
        let folder = folder.map_err(|error| Failure::Output {
            path: std::env::temp_dir(),
            reason: error.to_string(),
        })?;
        Ok(Self { path: Some(folder.path().join("plan.json")), _folder: Some(folder) })
    }
}

/// Runs both processes in an instance of their own until all is said.
fn walk(
    arguments: &WalkArguments,
    inputs: &Inputs,
    export: Option<&Path>,
    report: &mut Report,
) -> Result<(), Failure> {
    Instance::clean_dead()?;
    let instance = Instance::create(&format!("walk-{}", std::process::id()))?;
    let roles = Roles {
        inputs,
        instance: instance.name(),
        search: &arguments.search,
        export,
        truth: arguments.truth.as_deref(),
        rate: arguments.rate,
        disturb: arguments.disturb,
    };
    let mut supervisor = Supervisor::default();
    supervisor.start(Role::Controller, roles.command_of(Role::Controller)?)?;
    supervisor.start(Role::Planner, roles.command_of(Role::Planner)?)?;
    let mut progress = Progress::new(arguments.outputs.quiet);
    let followed = follow(&mut supervisor, &roles, arguments.restarts_max, &mut |line| {
        report.note(line);
        progress.show(line);
    });
    progress.clear();
    followed
}

/// Hears both processes until all is said. One that ends too early is started again, `restarts_max`
/// times in all.
fn follow(
    supervisor: &mut Supervisor,
    roles: &Roles<'_>,
    restarts_max: u32,
    hear: &mut dyn FnMut(&Line),
) -> Result<(), Failure> {
    let mut course = Course::default();
    let mut restarts = 0;
    while !course.is_over() {
        match supervisor.next_event()? {
            Event::Told(line) => {
                course.note(&line);
                hear(&line);
            }
            Event::Ended { role, .. } if !course.needs(role) => {}
            Event::Ended { role, how } if restarts == restarts_max => {
                return Err(Failure::Died { role, how });
            }
            Event::Ended { role, how } => {
                restarts += 1;
                hear(&Line::Restarted { role: role.to_string(), how });
                supervisor.start(role, roles.command_of(role)?)?;
            }
        }
    }
    Ok(())
}

/// How far a walk is.
#[derive(Debug, Default)]
struct Course {
    planned: Option<PlanEnd>,
    delivered: Option<DeliveryEnd>,
    judged: Option<Verdict>,
}

/// What the controller thinks of the stream it stands at the end of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Verdict {
    Accepted,
    Refused,
}

impl Course {
    fn note(&mut self, line: &Line) {
        match line {
            Line::Planned(planned) => self.planned = Some(planned.end),
            Line::Delivered(delivered) => self.delivered = Some(delivered.end),
            Line::Judged(judged) => {
                self.judged = Some(if judged.refusal.is_some() {
                    Verdict::Refused
                } else {
                    Verdict::Accepted
                })
            }
            _ => {}
        }
    }

    /// Whether both have said all; they may say it in any order.
    fn is_over(&self) -> bool {
        match (self.planned, self.delivered) {
            (None, _) | (Some(PlanEnd::Found), None) => false,
            (Some(PlanEnd::Found), Some(DeliveryEnd::Accepted)) => {
                self.judged == Some(Verdict::Accepted)
            }
            (Some(PlanEnd::Found), Some(DeliveryEnd::Refused)) => {
                self.judged == Some(Verdict::Refused)
            }
            _ => true,
        }
    }

    /// Whether the walk cannot end without this role.
    fn needs(&self, role: Role) -> bool {
        match role {
            Role::Planner => self.delivered.is_none() && !self.is_over(),
            Role::Controller => !self.is_over(),
        }
    }
}

/// The command lines of the two processes.
struct Roles<'a> {
    inputs: &'a Inputs,
    instance: &'a str,
    search: &'a SearchArguments,
    export: Option<&'a Path>,
    truth: Option<&'a Path>,
    rate: Option<f64>,
    disturb: Option<u64>,
}

impl Roles<'_> {
    fn command_of(&self, role: Role) -> Result<Command, Failure> {
        let threads = self.search.threads();
        let cores = cores_of_roles(threads);
        match role {
            Role::Controller => {
                let mut command = self.command("control", role, cores.1)?;
                if let Some(truth) = self.truth {
                    let truth = std::path::absolute(truth)
                        .map_err(|source| Failure::Start { role, source })?;
                    command.arg(option_with_path("--truth", &truth));
                }
                if let Some(rate) = self.rate {
                    command.arg("--rate").arg(rate.to_string());
                }
                if let Some(seed) = self.disturb {
                    command.arg("--disturb").arg(seed.to_string());
                }
                Ok(command)
            }
            Role::Planner => {
                let mut command = self.command("plan", role, cores.0)?;
                command.arg("--threads").arg(threads.to_string());
                command.arg("--replans-max").arg(self.search.replans_max.to_string());
                if self.search.lock_memory {
                    command.arg("--lock-memory");
                }
                if let Some(export) = self.export {
                    command.arg(option_with_path("--export", export));
                }
                Ok(command)
            }
        }
    }

    fn command(&self, word: &str, role: Role, core: Option<usize>) -> Result<Command, Failure> {
        let program = std::env::current_exe().map_err(|source| Failure::Start { role, source })?;
        let scenario = std::path::absolute(&self.inputs.scenario.path)
            .map_err(|source| Failure::Start { role, source })?;
        let mut command = Command::new(program);
        command.arg(word).arg(scenario).arg("--report-lines");
        command
            .arg("--instance")
            .arg(self.instance)
            .arg("--seed")
            .arg(self.inputs.scenario.seed.to_string());
        if let Some(core) = core {
            command.arg("--core").arg(core.to_string());
        }
        Ok(command)
    }
}

/// `--option=path` in one argument, so that no path can be taken for an option.
fn option_with_path(option: &str, path: &Path) -> OsString {
    let mut argument = OsString::from(option);
    argument.push("=");
    argument.push(path);
    argument
}
