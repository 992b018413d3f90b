//! The commands and their options, except those of `surefoot bench`.

use std::path::PathBuf;

use clap::{Args, CommandFactory, FromArgMatches, Parser, Subcommand};
use surefoot_planner::methods::method::Method;
use surefoot_shared_types::NUMBER_MAX;
use surefoot_shared_types::base::limits::CORRECTIONS_MAX;
use surefoot_shared_types::base::text_file::check_angles;
use surefoot_shared_types::config::MotionKind;

use crate::cli::bench_arguments::BenchArguments;
use crate::cli::method_arguments::{MethodArguments, method};
use crate::cli::robot_arguments::RobotCommand;
use crate::cli::simulation_arguments::{SimulationArguments, motion};
use crate::cli::values::{positive, whole_number, whole_number_between};
use crate::export::format::ExportFormat;
use crate::export::joint_selection::Selection;
use crate::export::quaternion::QuaternionOrder;
use crate::system::cores::{THREADS_MAX, planner_threads};

/// Smallest and largest rate of sampling.
const SAMPLE_RATE_MIN: f64 = 0.01;
/// See [`SAMPLE_RATE_MIN`].
const SAMPLE_RATE_MAX: f64 = 10_000.0;
/// Default of the number of replans: the most differences that a controller can report.
const REPLANS_MAX: u32 = CORRECTIONS_MAX as u32;
/// Default of the number of restarts.
const RESTARTS_MAX: u32 = 8;
/// The package's version and the commit that it is built from (`build.rs`).
const VERSION: &str = concat!(env!("CARGO_PKG_VERSION"), " (", env!("SUREFOOT_COMMIT"), ")");

/// Plans whole-body walks of legged robots and has them checked by a second process over shared
/// memory.
#[derive(Debug, Parser)]
#[command(
    name = "surefoot",
    version = VERSION,
    after_help = "Exit codes: 0 done; 2 bad input or environment; 3 no plan within the budget; 4 refused by the controller's checks; 128 and the signal's number when interrupted (0 where a signal ends the improvement of a plan)."
)]
pub struct Arguments {
    /// The command.
    #[command(subcommand)]
    pub command: Command,
}

impl Arguments {
    /// Reads the command line.
    ///
    /// # Errors
    /// It asks for help or for the version, or is none of this program: the text to print.
    pub fn read() -> Result<Self, clap::Error> {
        let matches = Self::complete_command().try_get_matches()?;
        Self::from_arg_matches(&matches)
    }

    /// All commands. A negative number is a value, so that the message about it names the numbers
    /// that the option takes.
    pub fn complete_command() -> clap::Command {
        with_negative_numbers(Self::command())
    }
}

fn with_negative_numbers(command: clap::Command) -> clap::Command {
    let takes_values = |arg: &clap::Arg| arg.get_action().takes_values();
    command
        .mut_args(|arg| if takes_values(&arg) { arg.allow_negative_numbers(true) } else { arg })
        .mut_subcommands(with_negative_numbers)
}

/// The commands.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Plan a walk in one process; check it and execute it in another
    Walk(WalkArguments),
    /// Plan a walk; with --instance, also deliver it to that instance's controller
    Plan(PlanArguments),
    /// Receive a plan in an instance, check it and execute it
    Control(ControlArguments),
    /// Request a walk from a planner that serves, or cancel one
    Request(RequestArguments),
    /// Print the messages of a planner and its controller
    Monitor(MonitorArguments),
    /// Play an instance's walk in real time: set-points for a joint controller, and ROS 2 messages
    Sample(SampleArguments),
    /// Prepare a robot once, so that no walk has to wait for it
    Prepare(PrepareArguments),
    /// Describe a robot of your own, or show one
    #[command(subcommand)]
    Robot(RobotCommand),
    /// Run the controller's checks on an exported plan
    Check(CheckArguments),
    /// Print the parameters of the planner and the checker
    #[command(subcommand)]
    Config(ConfigCommand),
    /// Measure on this machine
    Bench(BenchArguments),
    /// Report whether this machine can run a walk
    Doctor(DoctorArguments),
    /// List the scenarios, robots and worlds that the program carries
    List(ListArguments),
    /// Write a first scenario, with a world and a robot, to a folder
    New(NewArguments),
    /// Draw an exported plan
    Picture(PictureArguments),
    /// Say what an exported plan does, or why a run found none
    Explain(ExplainArguments),
    /// Write an exported plan in the format of another program
    Export(ExportArguments),
    /// Show an exported plan in Rerun (needs the Python package)
    View(ViewArguments),
    /// Print a shell's completions of these commands
    Completions(CompletionsArguments),
    /// Write the manual pages of all commands to a folder
    Man(ManArguments),
}

/// `surefoot list`.
#[derive(Debug, Args)]
pub struct ListArguments {
    /// Print one JSON object a line
    #[arg(long)]
    pub json: bool,
}

/// `surefoot new`.
#[derive(Debug, Args)]
pub struct NewArguments {
    /// The folder; it is made if it does not exist
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
    /// The robot of the scenario, instead of a copy of the shipped one
    #[arg(long, value_name = "ROBOT.toml")]
    pub robot: Option<PathBuf>,
}

/// `surefoot picture`.
#[derive(Debug, Args)]
pub struct PictureArguments {
    /// The exported plan
    #[arg(value_name = "PLAN.json")]
    pub plan: PathBuf,
    /// The picture: still (.png) or animated (.apng)
    #[arg(value_name = "OUT.png|OUT.apng")]
    pub out: PathBuf,
}

/// `surefoot explain`.
#[derive(Debug, Args)]
pub struct ExplainArguments {
    /// The exported plan, or the report of a run
    #[arg(value_name = "PLAN.json|REPORT.json")]
    pub file: PathBuf,
}

/// `surefoot export`.
#[derive(Debug, Args)]
pub struct ExportArguments {
    /// The exported plan
    #[arg(value_name = "PLAN.json")]
    pub plan: PathBuf,
    /// The format: csv, npz, footsteps, contacts, mujoco or mcap (docs/FORMATS.md)
    #[arg(long, value_name = "FORMAT", value_parser = export_format)]
    pub to: ExportFormat,
    /// The file (-: the standard output)
    #[arg(long, value_name = "FILE")]
    pub out: PathBuf,
    /// Samples each second
    #[arg(long, value_name = "N", value_parser = positive)]
    pub hz: Option<f64>,
    /// The joints and their order: urdf (as the file lists them), surefoot (depth first, as in
    /// plans and messages), or names with commas between them
    #[arg(long, value_name = "ORDER", value_parser = selection)]
    pub joint_order: Option<Selection>,
    /// The order of a quaternion's numbers: xyzw or wxyz
    #[arg(long, value_name = "ORDER", value_parser = quaternion_order)]
    pub quat: Option<QuaternionOrder>,
    /// The links whose motion npz holds too: urdf, surefoot, or names
    #[arg(long, value_name = "ORDER", value_parser = selection)]
    pub bodies: Option<Selection>,
}

/// `surefoot view`.
#[derive(Debug, Args)]
pub struct ViewArguments {
    /// The exported plan
    #[arg(value_name = "PLAN.json")]
    pub plan: PathBuf,
    /// Write a recording instead of starting the viewer
    #[arg(long, value_name = "WALK.rrd")]
    pub save: Option<PathBuf>,
}

/// `surefoot completions`.
#[derive(Debug, Args)]
pub struct CompletionsArguments {
    /// The shell
    #[arg(value_enum)]
    pub shell: clap_complete::Shell,
}

/// `surefoot man`.
#[derive(Debug, Args)]
pub struct ManArguments {
    /// The folder; it is made if it does not exist
    #[arg(value_name = "DIR")]
    pub folder: PathBuf,
}

/// `surefoot walk`.
#[derive(Debug, Args)]
pub struct WalkArguments {
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub search: SearchArguments,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub outputs: OutputArguments,
    /// The name of the walk's instance [default: walk-PID]
    #[arg(long, value_name = "NAME")]
    pub instance: Option<String>,
    /// Most restarts of processes that were killed, of both together
    #[arg(
        long,
        value_name = "N",
        default_value_t = RESTARTS_MAX,
        value_parser = whole_number::<u32>
    )]
    pub restarts_max: u32,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub simulation: SimulationArguments,
}

/// `surefoot plan`.
#[derive(Debug, Args)]
pub struct PlanArguments {
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub search: SearchArguments,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub outputs: OutputArguments,
    /// Deliver the plan to the controller in this instance
    #[arg(long, value_name = "NAME")]
    pub instance: Option<String>,
    /// Keep running until a signal comes, and plan what `surefoot request` asks for
    #[arg(long, requires = "instance")]
    pub serve: bool,
    /// The method that searches the first plan
    #[arg(
        long,
        value_name = "METHOD",
        value_parser = method,
        default_value = "rpg",
        conflicts_with = "serve"
    )]
    pub method: Method,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub samples: MethodArguments,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub role: RoleArguments,
}

/// `surefoot control`.
#[derive(Debug, Args)]
pub struct ControlArguments {
    /// The scenario of the plan
    pub scenario: PathBuf,
    /// The seed of the plan, instead of the scenario's
    #[arg(long, value_name = "N", value_parser = whole_number::<u64>)]
    pub seed: Option<u64>,
    /// How the plan moves, instead of the scenario's
    #[arg(long, value_name = "quasi_static|smooth", value_parser = motion)]
    pub motion: Option<MotionKind>,
    /// The instance to receive plans in
    #[arg(long, value_name = "NAME")]
    pub instance: String,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub simulation: SimulationArguments,
    /// Keep running for further plans until a signal comes
    #[arg(long)]
    pub serve: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub role: RoleArguments,
}

/// `surefoot request`.
#[derive(Debug, Args)]
#[command(group = clap::ArgGroup::new("request").required(true).args(["goal", "cancel", "replan"]))]
pub struct RequestArguments {
    /// The instance of the planner that serves
    #[arg(long, value_name = "NAME")]
    pub instance: String,
    /// The goal: point midway between both soles (m) and heading (rad)
    #[arg(long, value_name = "X,Y,Z,YAW", allow_hyphen_values = true, value_parser = stance)]
    pub goal: Option<StanceArgument>,
    /// The start, instead of the robot's rest state
    #[arg(
        long,
        value_name = "X,Y,Z,YAW",
        allow_hyphen_values = true,
        value_parser = stance,
        requires = "goal"
    )]
    pub start: Option<StanceArgument>,
    /// Lateral distance between the soles, m [default: that of the goal in the planner's scenario]
    #[arg(long, value_name = "M", allow_hyphen_values = true, value_parser = positive)]
    pub stance_width: Option<f64>,
    /// Cancel the current request
    #[arg(long)]
    pub cancel: bool,
    /// Plan again to the goal of the last request
    #[arg(long)]
    pub replan: bool,
    /// The seed of the search
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole_number::<u64>)]
    pub seed: u64,
    /// Work limit of the search, units; 0: the scenario's
    #[arg(long, value_name = "N", default_value_t = 0, value_parser = whole_number::<u64>)]
    pub work_max: u64,
}

/// A stance on the command line.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct StanceArgument {
    /// Point midway between both soles, m.
    pub position: [f64; 3],
    /// The heading, rad.
    pub yaw: f64,
}

fn stance(text: &str) -> Result<StanceArgument, String> {
    let numbers: Vec<f64> = text
        .split(',')
        .map(|part| part.trim().parse().ok().filter(|number: &f64| number.abs() <= NUMBER_MAX))
        .collect::<Option<_>>()
        .ok_or_else(|| {
            format!("four numbers of at most {NUMBER_MAX:e} with commas between them are needed")
        })?;
    let [x, y, z, yaw] = numbers[..] else {
        return Err(format!("{} numbers, four are needed: x,y,z,yaw", numbers.len()));
    };
    check_angles("the heading", &[yaw])?;
    Ok(StanceArgument { position: [x, y, z], yaw })
}

fn export_format(name: &str) -> Result<ExportFormat, String> {
    ExportFormat::from_name(name)
        .ok_or_else(|| format!("one of {} is needed", ExportFormat::NAMES.join(", ")))
}

fn selection(text: &str) -> Result<Selection, String> {
    Ok(Selection::from_text(text))
}

fn quaternion_order(name: &str) -> Result<QuaternionOrder, String> {
    QuaternionOrder::from_name(name)
        .ok_or_else(|| format!("one of {} is needed", QuaternionOrder::NAMES.join(", ")))
}

/// `surefoot monitor`.
#[derive(Debug, Args)]
pub struct MonitorArguments {
    /// The instance to monitor [default: the only one that runs]
    #[arg(long, value_name = "NAME")]
    pub instance: Option<String>,
    /// Create the instance: a tunnel brings its messages from another host
    #[arg(long, requires = "instance")]
    pub create: bool,
    /// Print one JSON object a line
    #[arg(long)]
    pub json: bool,
    /// Stop after this many seconds
    #[arg(long, value_name = "S", value_parser = positive)]
    pub seconds: Option<f64>,
}

/// `surefoot sample`.
#[derive(Debug, Args)]
pub struct SampleArguments {
    /// The instance whose plan is played
    #[arg(long, value_name = "NAME")]
    pub instance: String,
    /// Wait this many seconds for the instance to appear
    #[arg(long, value_name = "S", value_parser = positive, default_value_t = 10.0)]
    pub wait: f64,
    /// Set-points each second of the plan
    #[arg(long, value_name = "N", value_parser = sample_rate, default_value_t = 1000.0)]
    pub hz: f64,
    /// Seconds of the plan each second of real time
    #[arg(long, value_name = "R", value_parser = sample_rate, default_value_t = 1.0)]
    pub rate: f64,
    /// State contact wrenches, and torques where the plan states none: those of this scenario's
    /// robot in its world
    #[arg(long, value_name = "SCENARIO")]
    pub loads: Option<PathBuf>,
    /// Also publish /joint_states, /tf, /joint_trajectory and /root_trajectory for iceoryx2's ROS 2
    /// gateway (docs/ATTACH.md)
    #[arg(long)]
    pub ros: bool,
    /// Stop after this many seconds
    #[arg(long, value_name = "S", value_parser = positive)]
    pub seconds: Option<f64>,
}

/// `surefoot prepare`.
#[derive(Debug, Args)]
pub struct PrepareArguments {
    /// The robot file, its folder, or the name of a robot that the program carries
    #[arg(value_name = "ROBOT.toml|DIR|NAME")]
    pub robot: PathBuf,
    /// Show no progress, only the summary
    #[arg(long)]
    pub quiet: bool,
}

/// `surefoot check`.
#[derive(Debug, Args)]
pub struct CheckArguments {
    /// The exported plan
    #[arg(value_name = "PLAN.json")]
    pub plan: PathBuf,
    /// Check against this scenario's robot, world, tolerances, start and goal
    #[arg(long, value_name = "SCENARIO.toml")]
    pub scenario: Option<PathBuf>,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
}

/// `surefoot config`.
#[derive(Debug, Subcommand)]
pub enum ConfigCommand {
    /// Print every parameter with value, unit, default, range and the origin of the value
    Show(ConfigShowArguments),
    /// Print iceoryx2's configuration of a running instance, for a tunnel to another host
    Iceoryx2(ConfigIceoryxArguments),
}

/// `surefoot config show`.
#[derive(Debug, Args)]
pub struct ConfigShowArguments {
    /// The scenario; without it, the defaults are printed
    pub scenario: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// `surefoot config iceoryx2`.
#[derive(Debug, Args)]
pub struct ConfigIceoryxArguments {
    /// The instance
    #[arg(long, value_name = "NAME")]
    pub instance: String,
}

/// `surefoot doctor`.
#[derive(Debug, Args)]
pub struct DoctorArguments {
    /// Also load this scenario and report how much memory its planner needs
    pub scenario: Option<PathBuf>,
}

/// The inputs of a search.
#[derive(Debug, Args)]
pub struct SearchArguments {
    /// The file that names robot, world, start, goal and work limit, or a name that `surefoot list`
    /// shows
    pub scenario: PathBuf,
    /// The seed of the search, instead of the scenario's
    #[arg(long, value_name = "N", value_parser = whole_number::<u64>)]
    pub seed: Option<u64>,
    /// How the plan moves, instead of the scenario's
    #[arg(long, value_name = "quasi_static|smooth", value_parser = motion)]
    pub motion: Option<MotionKind>,
    /// Work units that make other walks from each plan and keep the one that takes the least time;
    /// INT or TERM ends that with the best plan so far
    #[arg(long, value_name = "WORK", value_parser = whole_number::<u64>, default_value_t = 0)]
    pub improve: u64,
    /// Planner threads, at most one for each core; the plan does not depend on them
    /// [default: 2, or 1 on one core]
    #[arg(long, value_name = "N", value_parser = whole_number_between::<u16>(1, THREADS_MAX))]
    pub threads: Option<u16>,
    /// Most replans after the controller encountered a world that differs
    #[arg(
        long,
        value_name = "N",
        default_value_t = REPLANS_MAX,
        value_parser = whole_number::<u32>
    )]
    pub replans_max: u32,
    /// Lock the planner's memory, so that it is not paged out; warns if the system refuses
    #[arg(long)]
    pub lock_memory: bool,
}

impl SearchArguments {
    /// Planner threads.
    pub fn threads(&self) -> usize {
        planner_threads(self.threads)
    }
}

/// The files that a command writes.
#[derive(Debug, Clone, Default, Args)]
pub struct OutputArguments {
    /// Write the plan as a biped-plan/1 file (-: to the standard output)
    #[arg(long, value_name = "PLAN.json")]
    pub export: Option<PathBuf>,
    /// Draw the walk, or without a plan the search: still (.png) or animated (.apng)
    #[arg(long, value_name = "OUT.png|OUT.apng")]
    pub picture: Option<PathBuf>,
    /// Record the plan for Foxglove, Rerun and ROS 2, with its state at 50 Hz
    #[arg(long, value_name = "OUT.mcap")]
    pub record: Option<PathBuf>,
    /// Write a report (-: to the standard output)
    #[arg(long, value_name = "REPORT.json")]
    pub json: Option<PathBuf>,
    /// Show no progress, only the summary
    #[arg(long)]
    pub quiet: bool,
}

impl OutputArguments {
    /// Whether any file is to be written.
    pub fn names_files(&self) -> bool {
        self.paths().next().is_some()
    }

    /// The paths of all files.
    pub fn paths(&self) -> impl Iterator<Item = &PathBuf> {
        [&self.export, &self.picture, &self.record, &self.json].into_iter().flatten()
    }

    /// Whether a file that shows the plan is to be written.
    pub fn shows_plan(&self) -> bool {
        self.picture.is_some() || self.record.is_some()
    }
}

/// Options that a supervisor passes to a role's process.
#[derive(Debug, Clone, Args)]
pub struct RoleArguments {
    /// Run on this core
    #[arg(long, hide = true, value_name = "N", value_parser = whole_number::<usize>)]
    pub core: Option<usize>,
    /// Report events as JSON lines on stdout, and end with the parent process
    #[arg(long, hide = true)]
    pub report_lines: bool,
    /// Write the plan to this descriptor, a file in memory, instead of --export
    #[arg(long, hide = true, value_name = "N", value_parser = whole_number::<u32>)]
    pub plan_descriptor: Option<u32>,
}

impl Arguments {
    /// Whether a supervisor reads this process's stdout.
    pub fn reports_lines(&self) -> bool {
        match &self.command {
            Command::Plan(arguments) => arguments.role.report_lines,
            Command::Control(arguments) => arguments.role.report_lines,
            _ => false,
        }
    }
}

/// A rate of sampling.
fn sample_rate(text: &str) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(rate) if (SAMPLE_RATE_MIN..=SAMPLE_RATE_MAX).contains(&rate) => Ok(rate),
        _ => Err(format!("a number between {SAMPLE_RATE_MIN} and {SAMPLE_RATE_MAX} is needed")),
    }
}
