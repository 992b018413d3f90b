//! `surefoot walk`: a planner process, a controller process, and the summary.

use std::ffi::OsString;
use std::path::{Path, PathBuf};
use std::process::Command;

use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::plan_file::read::load_plan;
use surefoot_shared_types::world::load::load_world;

use crate::cli::arguments::{SearchArguments, WalkArguments};
use crate::commands::session::write_report;
use crate::input::inputs::Inputs;
use crate::input::output_files;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::report::event::{DeliveryResult, PlanResult, RoleEvent};
use crate::report::progress::Progress;
use crate::report::run_report::Report;
use crate::report::summary;
use crate::supervisor::supervisor::{Role, Supervisor, SupervisorEvent};
use crate::system::cores::cores_of_roles;
use crate::system::{signals, terminal};

/// Runs the command.
///
/// # Errors
/// When an input cannot be used, an output cannot be written, a process fails, or a signal comes.
pub fn run(arguments: &WalkArguments) -> Result<CommandOutcome, CommandError> {
    let inputs = Inputs::load(&arguments.search.scenario, arguments.search.seed)?;
    output_files::check(&arguments.outputs)?;
    if let Some(ground_truth) = &arguments.ground_truth {
        load_world(ground_truth)?;
    }
    inputs.preparation(arguments.outputs.quiet)?;
    signals::install();
    let export = Export::new(arguments)?;
    let mut report = Report::new(&inputs, arguments.search.threads());
    let json = arguments.outputs.json.as_deref();
    if let Err(error) = walk(arguments, &inputs, export.path.as_deref(), &mut report) {
        report.record_error(&error);
        if let (Some(path), Some(_)) = (json, error.name()) {
            output_files::write_json(&report, path)?;
        }
        return Err(error);
    }
    if let (Some(picture), Some(plan), true) =
        (&arguments.outputs.picture, &export.path, report.has_plan())
    {
        output_files::draw(&inputs, &load_plan(plan)?, picture)?;
    }
    let outcome = write_report(&report, json)?;
    terminal::print_result(&summary::text(&report));
    Ok(outcome)
}

/// Where the planner process leaves the plan: where the user wants it, or where only the picture
/// needs it.
struct Export {
    path: Option<PathBuf>,
    _folder: Option<tempfile::TempDir>,
}

impl Export {
    fn new(arguments: &WalkArguments) -> Result<Self, CommandError> {
        let outputs = &arguments.outputs;
        if outputs.export.is_some() || outputs.picture.is_none() {
            return Ok(Self { path: outputs.export.clone(), _folder: None });
        }
        let folder = tempfile::Builder::new().prefix("surefoot-picture-").tempdir();
        let folder = folder.map_err(|error| CommandError::Output {
            path: std::env::temp_dir(),
            reason: error.to_string(),
        })?;
        Ok(Self { path: Some(folder.path().join("plan.json")), _folder: Some(folder) })
    }
}

/// Runs both processes in an instance of their own until both have reported their results.
fn walk(
    arguments: &WalkArguments,
    inputs: &Inputs,
    export: Option<&Path>,
    report: &mut Report,
) -> Result<(), CommandError> {
    Instance::clean_dead()?;
    let instance = Instance::create(&format!("walk-{}", std::process::id()))?;
    let roles = Roles {
        inputs,
        instance: instance.name(),
        search: &arguments.search,
        export,
        ground_truth: arguments.ground_truth.as_deref(),
        rate: arguments.rate,
        disturb: arguments.disturb,
    };
    let mut supervisor = Supervisor::default();
    supervisor.start(Role::Controller, roles.command_of(Role::Controller)?)?;
    supervisor.start(Role::Planner, roles.command_of(Role::Planner)?)?;
    let mut progress = Progress::new(arguments.outputs.quiet);
    let followed = follow(&mut supervisor, &roles, arguments.restarts_max, &mut |event| {
        report.record(event);
        progress.show(event);
    });
    progress.clear();
    followed
}

/// Receives the events of both processes until both have reported their results. One that ends too
/// early is started again, `restarts_max` times in all.
fn follow(
    supervisor: &mut Supervisor,
    roles: &Roles<'_>,
    restarts_max: u32,
    on_event: &mut dyn FnMut(&RoleEvent),
) -> Result<(), CommandError> {
    let mut state = WalkState::default();
    let mut restarts = 0;
    while !state.is_over() {
        match supervisor.next_event()? {
            SupervisorEvent::Reported(event) => {
                state.record(&event);
                on_event(&event);
            }
            SupervisorEvent::Ended { role, .. } if !state.needs(role) => {}
            SupervisorEvent::Ended { role, how } if restarts == restarts_max => {
                return Err(CommandError::EndedEarly { role, how });
            }
            SupervisorEvent::Ended { role, how } => {
                restarts += 1;
                on_event(&RoleEvent::Restarted { role: role.to_string(), how });
                supervisor.start(role, roles.command_of(role)?)?;
            }
        }
    }
    Ok(())
}

/// How far a walk is.
#[derive(Debug, Default)]
struct WalkState {
    planned: Option<PlanResult>,
    delivered: Option<DeliveryResult>,
    checked: Option<StreamDecision>,
}

/// The controller's decision on the stream that it has executed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum StreamDecision {
    Accepted,
    Refused,
}

impl WalkState {
    fn record(&mut self, event: &RoleEvent) {
        match event {
            RoleEvent::Planned(planned) => self.planned = Some(planned.result),
            RoleEvent::Delivered(delivered) => self.delivered = Some(delivered.result),
            RoleEvent::Checked(checked) => {
                self.checked = Some(if checked.refusal.is_some() {
                    StreamDecision::Refused
                } else {
                    StreamDecision::Accepted
                })
            }
            _ => {}
        }
    }

    /// Whether both have reported their results, in either order.
    fn is_over(&self) -> bool {
        match (self.planned, self.delivered) {
            (None, _) | (Some(PlanResult::Found), None) => false,
            (Some(PlanResult::Found), Some(DeliveryResult::Accepted)) => {
                self.checked == Some(StreamDecision::Accepted)
            }
            (Some(PlanResult::Found), Some(DeliveryResult::Refused)) => {
                self.checked == Some(StreamDecision::Refused)
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
    ground_truth: Option<&'a Path>,
    rate: Option<f64>,
    disturb: Option<u64>,
}

impl Roles<'_> {
    fn command_of(&self, role: Role) -> Result<Command, CommandError> {
        let threads = self.search.threads();
        let cores = cores_of_roles(threads);
        match role {
            Role::Controller => {
                let mut command = self.command("control", role, cores.1)?;
                if let Some(ground_truth) = self.ground_truth {
                    let ground_truth = std::path::absolute(ground_truth)
                        .map_err(|source| CommandError::Start { role, source })?;
                    command.arg(option_with_path("--ground_truth", &ground_truth));
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

    fn command(
        &self,
        subcommand: &str,
        role: Role,
        core: Option<usize>,
    ) -> Result<Command, CommandError> {
        let program =
            std::env::current_exe().map_err(|source| CommandError::Start { role, source })?;
        let scenario = std::path::absolute(&self.inputs.scenario.path)
            .map_err(|source| CommandError::Start { role, source })?;
        let mut command = Command::new(program);
        command.arg(subcommand).arg(scenario).arg("--report-lines");
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
