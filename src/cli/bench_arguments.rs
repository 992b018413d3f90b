//! What `surefoot bench` offers.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};

use crate::cli::arguments::THREADS_MAX;
use crate::commands::bench::footholds::footholds_bench::FootholdsArguments;
use crate::commands::bench::ipc::IpcArguments;
use crate::system::cores::default_threads;

/// `surefoot bench`.
#[derive(Debug, Args)]
pub struct BenchArguments {
    /// What to measure
    #[command(subcommand)]
    pub bench: BenchCommand,
}

/// What can be measured.
#[derive(Debug, Subcommand)]
pub enum BenchCommand {
    /// Tables 4.1 and 4.2 of the thesis beside our own times
    Thesis(ThesisArguments),
    /// Planning time against the time of checking the plan once
    LowerBound(LowerBoundArguments),
    /// How long planning again takes after the controller refused a chunk
    Replan(ReplanArguments),
    /// How long the planner's steps take when a control loop gives it little work at a time
    Steps(StepsArguments),
    /// How cost grows with longer courses and larger worlds
    Scale(ScaleArguments),
    /// Real chunks over our transport beside raw memory, a socket and plain iceoryx2
    Ipc(IpcArguments),
    /// How often foot placement sampling succeeds: figure 4.10 of the thesis, and further features
    Footholds(FootholdsArguments),
}

/// `surefoot bench thesis`.
#[derive(Debug, Args)]
pub struct ThesisArguments {
    /// Searches per scenario, with the seeds 1, 2, 3 and so on
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub trials: u64,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub scenarios: ScenarioArguments,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub threads: ThreadArguments,
    /// Have every plan verified by the controller's checks, outside the measured time
    #[arg(long)]
    pub check: bool,
    /// Keep the results in this folder, and take up there again after an interruption
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Forget the results that the folder holds
    #[arg(long, requires = "out")]
    pub fresh: bool,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// `surefoot bench lower-bound`.
#[derive(Debug, Args)]
pub struct LowerBoundArguments {
    /// Searches per scenario, with the seeds 1, 2, 3 and so on
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub trials: u64,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub scenarios: ScenarioArguments,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub threads: ThreadArguments,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// `surefoot bench replan`.
#[derive(Debug, Args)]
pub struct ReplanArguments {
    /// Plans per scenario, with the seeds 1, 2, 3 and so on
    #[arg(long, value_name = "N", default_value_t = 25, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub trials: u64,
    /// Refusals of each plan, spread over its length
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u64).range(1..=1_000))]
    pub refusals: u64,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub scenarios: ScenarioArguments,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub threads: ThreadArguments,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// `surefoot bench steps`.
#[derive(Debug, Args)]
pub struct StepsArguments {
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub scenarios: ScenarioArguments,
    /// Run on this core [default: the last]
    #[arg(long, value_name = "N")]
    pub core: Option<usize>,
    /// Microseconds that a step shall take
    #[arg(long, value_name = "US", default_value_t = 1000, value_parser = clap::value_parser!(u32).range(1..=1_000_000))]
    pub step: u32,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// `surefoot bench scale`.
#[derive(Debug, Args)]
pub struct ScaleArguments {
    /// Only this part
    #[arg(long)]
    pub part: Option<ScalePart>,
    /// Copies of the course
    #[arg(long, value_name = "N,..", value_delimiter = ',', default_values_t = [1, 2, 4, 8], value_parser = clap::value_parser!(u64).range(1..=1000))]
    pub gauntlets: Vec<u64>,
    /// Triangles of the world
    #[arg(long, value_name = "N,..", value_delimiter = ',', default_values_t = [10_000, 100_000, 1_000_000], value_parser = clap::value_parser!(u64).range(10_000..=100_000_000))]
    pub triangles: Vec<u64>,
    /// Searches per size, with the seeds 1, 2, 3 and so on
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u64).range(1..=1_000_000))]
    pub trials: u64,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub threads: ThreadArguments,
    /// Where the gauntlets are, and flat_walk, whose robot walks over the meshes
    #[arg(long, value_name = "DIR", default_value = "configs/scenarios")]
    pub configs: PathBuf,
    /// Write scale.json and a plot of each part into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// A part of `surefoot bench scale`.
#[derive(Debug, Clone, Copy, PartialEq, Eq, ValueEnum)]
pub enum ScalePart {
    /// Longer courses
    Gauntlet,
    /// Larger worlds
    Terrain,
}

/// Which scenarios to run.
#[derive(Debug, Clone, Args)]
pub struct ScenarioArguments {
    /// Only this scenario, by its name or its file; may be given several times
    /// [default: all that belong to the bench]
    #[arg(long = "scenario", value_name = "NAME")]
    pub scenarios: Vec<String>,
    /// Where scenarios given by name are
    #[arg(long, value_name = "DIR", default_value = "configs/scenarios")]
    pub configs: PathBuf,
}

/// How many threads plan.
#[derive(Debug, Clone, Copy, Args)]
pub struct ThreadArguments {
    /// Planner threads [default: 2, or the cores there are]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u16).range(1..=THREADS_MAX))]
    pub threads: Option<u16>,
}

impl ThreadArguments {
    /// Planner threads.
    pub fn count(self) -> NonZeroUsize {
        NonZeroUsize::new(self.threads.map_or_else(default_threads, usize::from))
            .unwrap_or(NonZeroUsize::MIN)
    }
}
