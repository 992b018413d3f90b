//! `surefoot walk`: a planner process, a controller process, and the verdict.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use surefoot_shared_types::instance::Instance;
use surefoot_shared_types::plan_file::load::load_plan;

use super::conclude;
use crate::affinity::cores_of_roles;
use crate::arguments::WalkArguments;
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
    if let (Some(picture), Some(plan), true) = (&arguments.outputs.picture, &export.path, report.has_plan()) {
        outputs::draw(&inputs, &load_plan(plan)?, picture)?;
    }
    let ending = conclude(&report, json)?;
    terminal::say(&verdict::text(&report));
    Ok(ending)
}

/// Where the planner process leaves the plan: where the user wants it, or where only the picture needs it.
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
        let folder = folder.map_err(|error| Failure::Output { path: std::env::temp_dir(), reason: error.to_string() })?;
        Ok(Self { path: Some(folder.path().join("plan.json")), _folder: Some(folder) })
    }
}

/// Runs both processes in an instance of their own until all is said.
fn walk(arguments: &WalkArguments, inputs: &Inputs, export: Option<&Path>, report: &mut Report) -> Result<(), Failure> {
    Instance::clean_dead()?;
    let instance = Instance::create(&format!("walk-{}", std::process::id()))?;
    let roles = Roles { inputs, instance: instance.name(), threads: arguments.search.threads() };
    let mut supervisor = Supervisor::default();
    supervisor.start(Role::Controller, roles.controller()?)?;
    supervisor.start(Role::Planner, roles.planner(export)?)?;
    let mut progress = Progress::new(arguments.outputs.quiet);
    let followed = follow(&mut supervisor, &mut |line| {
        report.note(line);
        progress.show(line);
    });
    progress.clear();
    followed
}

/// Hears both processes until all is said.
fn follow(supervisor: &mut Supervisor, hear: &mut dyn FnMut(&Line)) -> Result<(), Failure> {
    let mut course = Course::default();
    while !course.is_over() {
        match supervisor.next_event()? {
            Event::Told(line) => {
                course.note(&line);
                hear(&line);
            }
            Event::Ended { role, how } if !course.has_done_its_work(role) => return Err(Failure::Died { role, how }),
            Event::Ended { .. } => {}
        }
    }
    Ok(())
}

/// How far a walk is.
#[derive(Debug, Default)]
struct Course {
    planned: Option<PlanEnd>,
    delivered: Option<DeliveryEnd>,
    judged: bool,
}

impl Course {
    fn note(&mut self, line: &Line) {
        match line {
            Line::Planned(planned) => self.planned = Some(planned.end),
            Line::Delivered(delivered) => self.delivered = Some(delivered.end),
            Line::Judged(_) => self.judged = true,
            _ => {}
        }
    }

    fn is_over(&self) -> bool {
        match (self.planned, self.delivered) {
            (None, _) | (Some(PlanEnd::Found), None) => false,
            (Some(PlanEnd::Found), Some(DeliveryEnd::Accepted | DeliveryEnd::Refused)) => self.judged,
            _ => true,
        }
    }

    fn has_done_its_work(&self, role: Role) -> bool {
        match role {
            Role::Planner => self.delivered.is_some(),
            Role::Controller => self.judged,
        }
    }
}

/// The command lines of the two processes.
struct Roles<'a> {
    inputs: &'a Inputs,
    instance: &'a str,
    threads: usize,
}

impl Roles<'_> {
    fn planner(&self, export: Option<&Path>) -> Result<Command, Failure> {
        let mut command = self.command("plan", Role::Planner, cores_of_roles(self.threads).0)?;
        command.arg("--threads").arg(self.threads.to_string());
        if let Some(export) = export {
            command.arg(option_with_path("--export", export));
        }
        Ok(command)
    }

    fn controller(&self) -> Result<Command, Failure> {
        self.command("control", Role::Controller, cores_of_roles(self.threads).1)
    }

    fn command(&self, word: &str, role: Role, core: Option<usize>) -> Result<Command, Failure> {
        let program = std::env::current_exe().map_err(|source| Failure::Start { role, source })?;
        let scenario = std::path::absolute(&self.inputs.scenario.path).map_err(|source| Failure::Start { role, source })?;
        let mut command = Command::new(program);
        command.arg(word).arg(scenario).arg("--report-lines");
        command.arg("--instance").arg(self.instance).arg("--seed").arg(self.inputs.scenario.seed.to_string());
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
