//! Options that several benches have.

use std::num::NonZeroUsize;
use std::path::PathBuf;

use clap::Args;

use crate::cli::values::whole_number_between;
use crate::system::cores::{THREADS_MAX, planner_threads};

/// The scenarios to run.
#[derive(Debug, Clone, Args)]
pub struct ScenarioArguments {
    /// Only this scenario, by its name or its file; may be given several times
    /// [default: all that belong to the bench]
    #[arg(long = "scenario", value_name = "NAME")]
    pub scenarios: Vec<String>,
    /// The folder of scenarios given by name
    #[arg(long, value_name = "DIR", default_value = "configs/scenarios")]
    pub configs: PathBuf,
}

/// The number of planner threads.
#[derive(Debug, Clone, Copy, Args)]
pub struct ThreadArguments {
    /// Planner threads, at most one for each core [default: 2, or 1 on one core]
    #[arg(long, value_name = "N", value_parser = whole_number_between::<u16>(1, THREADS_MAX))]
    pub threads: Option<u16>,
}

impl ThreadArguments {
    /// Planner threads.
    pub fn count(self) -> NonZeroUsize {
        NonZeroUsize::new(planner_threads(self.threads)).unwrap_or(NonZeroUsize::MIN)
    }
}

/// Parses how many there are of what a bench repeats.
pub fn count() -> impl Fn(&str) -> Result<u64, String> + Clone + Send + Sync + 'static {
    whole_number_between::<u64>(1, 1_000_000)
}
