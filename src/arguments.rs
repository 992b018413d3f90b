//! What the command line offers.

use std::path::PathBuf;

use clap::{Args, Parser, Subcommand};

use crate::affinity::default_threads;

/// Most planner threads.
const THREADS_MAX: i64 = 256;
/// How often a killed process is started again, unless told otherwise.
const RESTARTS_MAX: u32 = 8;

/// Plans whole-body, quasi-static walks and has them checked by a second process over shared memory.
#[derive(Debug, Parser)]
#[command(
    name = "surefoot",
    version,
    after_help = "Exit codes: 0 done; 2 bad input or environment; 3 no plan within the budget; 4 refused by the controller's checks; 128 and the signal's number when interrupted."
)]
pub struct Arguments {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Plan a walk in one process and have it checked and walked by another
    Walk(WalkArguments),
    /// Plan a walk; with an instance, also deliver it to the controller that listens there
    Plan(PlanArguments),
    /// Listen for a plan in an instance, check it and walk it
    Control(ControlArguments),
    /// Make the controller's checks on an exported plan
    Check(CheckArguments),
    /// Say whether this machine can run a walk
    Doctor(DoctorArguments),
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
    /// How often a process that was killed is started again, both counted together
    #[arg(long, value_name = "N", default_value_t = RESTARTS_MAX)]
    pub restarts_max: u32,
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
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub role: RoleArguments,
}

/// `surefoot control`.
#[derive(Debug, Args)]
pub struct ControlArguments {
    /// The scenario that the plan must be made for
    pub scenario: PathBuf,
    /// The seed that the plan must be made with, in place of the scenario's
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Where to listen
    #[arg(long, value_name = "NAME")]
    pub instance: String,
    /// Stay up for further plans until a signal comes
    #[arg(long)]
    pub serve: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub role: RoleArguments,
}

/// `surefoot check`.
#[derive(Debug, Args)]
pub struct CheckArguments {
    /// The exported plan
    #[arg(value_name = "PLAN.json")]
    pub plan: PathBuf,
    /// Print the report as JSON
    #[arg(long)]
    pub json: bool,
}

/// `surefoot doctor`.
#[derive(Debug, Args)]
pub struct DoctorArguments {
    /// Also load this scenario and say how much memory its planner needs
    pub scenario: Option<PathBuf>,
}

/// What to search for, and how.
#[derive(Debug, Args)]
pub struct SearchArguments {
    /// Robot, world, start, goal and budget
    pub scenario: PathBuf,
    /// The seed, in place of the scenario's
    #[arg(long, value_name = "N")]
    pub seed: Option<u64>,
    /// Planner threads, without influence on the plan [default: 2, or the cores there are]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=THREADS_MAX))]
    pub threads: Option<u16>,
}

impl SearchArguments {
    /// Planner threads.
    pub fn threads(&self) -> usize {
        self.threads.map_or_else(default_threads, usize::from)
    }
}

/// What to leave behind.
#[derive(Debug, Clone, Default, Args)]
pub struct OutputArguments {
    /// Write the plan as a biped-plan/1 file
    #[arg(long, value_name = "PLAN.json")]
    pub export: Option<PathBuf>,
    /// Draw the walk: still (.png) or moving (.apng)
    #[arg(long, value_name = "OUT.png|OUT.apng")]
    pub picture: Option<PathBuf>,
    /// Write a report
    #[arg(long, value_name = "REPORT.json")]
    pub json: Option<PathBuf>,
    /// Show no progress, only the verdict
    #[arg(long)]
    pub quiet: bool,
}

/// How a supervisor runs a role.
#[derive(Debug, Clone, Args)]
pub struct RoleArguments {
    /// Run on this core
    #[arg(long, hide = true, value_name = "N")]
    pub core: Option<usize>,
    /// Report in JSON lines on stdout, and end with the process that reads them
    #[arg(long, hide = true)]
    pub report_lines: bool,
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
