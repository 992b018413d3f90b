//! The options of the benches that compare methods.

use std::ops::Range;
use std::path::PathBuf;

use clap::Args;
use surefoot_planner::methods::method::Method;

use crate::cli::method_arguments::{MethodArguments, method};
use crate::cli::shared_bench_arguments::{ScenarioArguments, ThreadArguments, count};
use crate::cli::values::whole_number;

/// What the benches of methods have in common.
#[derive(Debug, Args)]
pub struct MethodBenchArguments {
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub scenarios: ScenarioArguments,
    /// Work units of each search at most
    #[arg(long, value_name = "N", default_value_t = 400_000, value_parser = whole_number::<u64>)]
    pub work: u64,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub samples: MethodArguments,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub threads: ThreadArguments,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// The seeds and results of a bench that compares methods.
#[derive(Debug, Args)]
pub struct MethodSeriesArguments {
    /// The first seed; the others follow it
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole_number::<u32>)]
    pub first_seed: u32,
    /// Keep the result of each search and write the report and its tables in this folder; a search
    /// whose result is in it is not repeated
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Delete the results in the folder first
    #[arg(long, requires = "out")]
    pub fresh: bool,
}

impl MethodSeriesArguments {
    /// The seeds of so many searches.
    pub fn seeds(&self, trials: u64) -> Range<u64> {
        let first = u64::from(self.first_seed);
        first..first + trials
    }
}

/// `surefoot bench methods`.
#[derive(Debug, Args)]
pub struct MethodsArguments {
    /// Searches per scenario and method, each with another seed
    #[arg(long, value_name = "N", default_value_t = 40, value_parser = count())]
    pub trials: u64,
    /// Only this method; may be given several times [default: all]
    #[arg(long = "method", value_name = "METHOD", value_parser = method)]
    pub methods: Vec<Method>,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub common: MethodBenchArguments,
    /// Run the controller's checks on every plan, outside the measured time
    #[arg(long)]
    pub check: bool,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub series: MethodSeriesArguments,
}

/// `surefoot bench rho`.
#[derive(Debug, Args)]
pub struct RhoArguments {
    /// Searches per scenario and radius, each with another seed
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = count())]
    pub trials: u64,
    /// Radii relative to the longest level step; inf: without stage P
    #[arg(
        long = "shares",
        value_name = "X,...",
        value_delimiter = ',',
        default_value = "0.25,0.375,0.5,0.75,1,1.5,2,3,4,inf",
        value_parser = share
    )]
    pub shares: Vec<f64>,
    /// The method: w-rpg, which is mmprm for an infinite radius, or rpg-discs
    #[arg(long, value_name = "METHOD", default_value = "w-rpg", value_parser = method_with_discs)]
    pub method: Method,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub common: MethodBenchArguments,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub series: MethodSeriesArguments,
}

/// `surefoot bench theory`.
#[derive(Debug, Args)]
pub struct TheoryArguments {
    /// Searches by w-rpg per scenario, of one round each, with the seeds 1, 2, 3 and so on
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = count())]
    pub trials: u64,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub common: MethodBenchArguments,
    /// Write theory.json into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
}

fn method_with_discs(name: &str) -> Result<Method, String> {
    let method = Method::from_name(name);
    let has_discs = |method: &Method| matches!(method, Method::WRpg | Method::RpgDiscs);
    method.filter(has_discs).ok_or_else(|| "w-rpg or rpg-discs is needed".into())
}

fn share(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| *number > 0.0);
    number.ok_or_else(|| "a positive number or inf is needed".into())
}
