//! The options of `surefoot bench`.

use std::path::PathBuf;

use clap::{Args, Subcommand, ValueEnum};
use surefoot_controller_sim::LATE_SHARE;
use surefoot_shared_types::config::MotionKind;

use crate::cli::method_bench_arguments::{MethodsArguments, RhoArguments, TheoryArguments};
use crate::cli::shared_bench_arguments::{ScenarioArguments, ThreadArguments, count};
use crate::cli::simulation_arguments::{late_share, motion, rate};
use crate::cli::values::{not_negative, positive, whole_number, whole_number_between};

/// `surefoot bench`.
#[derive(Debug, Args)]
pub struct BenchArguments {
    /// The bench to run
    #[command(subcommand)]
    pub bench: BenchCommand,
}

/// The benches.
#[derive(Debug, Subcommand)]
pub enum BenchCommand {
    /// Our planning times beside tables 4.1 and 4.2 of the thesis
    Thesis(ThesisArguments),
    /// Planning time against the time of checking the plan once, its lower bound
    LowerBound(LowerBoundArguments),
    /// Time of planning again after the controller refused a chunk
    Replan(ReplanArguments),
    /// Times of the planner's steps inside a control loop, with little work per step
    Steps(StepsArguments),
    /// Growth of the cost with longer scenarios and larger worlds
    Scale(ScaleArguments),
    /// Two planner threads against one, while busy loops run on some cores
    Threads(ThreadsArguments),
    /// Chunks over our transport beside raw memory, a socket and plain iceoryx2
    Ipc(IpcArguments),
    /// Walks and requests with random kills, stops and forged messages: nothing may be lost
    Soak(SoakArguments),
    /// Success rates of foot placement sampling: figure 4.10 of the thesis, and further features
    Footholds(FootholdsArguments),
    /// Random goals near the start on a bare floor: success, steps, work and time
    Goals(GoalsArguments),
    /// Small worlds that need a last resort of the search, with it and without it
    Holes(HolesArguments),
    /// Random worlds: is each that is called impossible one in which no method finds a plan?
    Impossible(ImpossibleArguments),
    /// Smooth walks whose chunks come late at random: each brakes, stands and goes on
    Late(LateArguments),
    /// Plans changed at random: the controller refuses each, or the robot stands when it walks it
    Mutations(MutationsArguments),
    /// The planner beside other methods on the same worlds: success, time, work and steps
    Methods(MethodsArguments),
    /// Figure 5.8 of the thesis: time of w-rpg over the radius of the discs about its route
    Rho(RhoArguments),
    /// The bounds of chapter 5 for real plans, beside the failure rate of w-rpg
    Theory(TheoryArguments),
}

/// `surefoot bench thesis`.
#[derive(Debug, Args)]
pub struct ThesisArguments {
    /// Searches per scenario, with the seeds 1, 2, 3 and so on
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = count())]
    pub trials: u64,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub scenarios: ScenarioArguments,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub threads: ThreadArguments,
    /// The motion of the plans: quasi_static measures the search, smooth adds motion and timing
    #[arg(long, value_name = "MOTION", value_parser = motion, default_value = "quasi_static")]
    pub motion: MotionKind,
    /// Run the controller's checks on every plan, outside the measured time
    #[arg(long)]
    pub check: bool,
    /// Keep the results in this folder, and continue from them after an interruption
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Delete the results in the folder first
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
    #[arg(long, value_name = "N", default_value_t = 10, value_parser = count())]
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
    #[arg(long, value_name = "N", default_value_t = 25, value_parser = count())]
    pub trials: u64,
    /// Refusals of each plan, spread over its length
    #[arg(
        long,
        value_name = "N",
        default_value_t = 4,
        value_parser = whole_number_between::<u64>(1, 1_000)
    )]
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
    #[arg(long, value_name = "N", value_parser = whole_number::<usize>)]
    pub core: Option<usize>,
    /// Intended duration of a step, microseconds
    #[arg(
        long,
        value_name = "US",
        default_value_t = 1000,
        value_parser = whole_number_between::<u32>(1, 1_000_000)
    )]
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
    /// Numbers of copies of the gauntlet
    #[arg(
        long,
        value_name = "N,..",
        value_delimiter = ',',
        default_values_t = [1, 2, 4, 8],
        value_parser = whole_number_between::<u64>(1, 1000)
    )]
    pub gauntlets: Vec<u64>,
    /// Numbers of triangles of the world
    #[arg(
        long,
        value_name = "N,..",
        value_delimiter = ',',
        default_values_t = [10_000, 100_000, 1_000_000],
        value_parser = whole_number_between::<u64>(10_000, 100_000_000)
    )]
    pub triangles: Vec<u64>,
    /// Searches per size, with the seeds 1, 2, 3 and so on
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = count())]
    pub trials: u64,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub threads: ThreadArguments,
    /// The folder of the gauntlets, and of flat_walk, whose robot walks over the meshes
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
    /// Longer scenarios
    Gauntlet,
    /// Larger worlds
    Terrain,
}

/// `surefoot bench footholds`.
#[derive(Debug, Args)]
pub struct FootholdsArguments {
    /// Queries per world
    #[arg(
        long,
        value_name = "N",
        default_value_t = 1000,
        value_parser = whole_number_between::<u32>(1, 1_000_000)
    )]
    pub queries: u32,
    /// The seed of all queries
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole_number::<u64>)]
    pub seed: u64,
    /// The robot whose sole is placed
    #[arg(long, value_name = "ROBOT.toml", default_value = "configs/robots/hubo/robot.toml")]
    pub robot: PathBuf,
    /// The folder of the worlds
    #[arg(long, value_name = "DIR", default_value = "configs/worlds")]
    pub worlds: PathBuf,
    /// Write footholds.csv and footholds.svg into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// `surefoot bench threads`.
#[derive(Debug, Args)]
pub struct ThreadsArguments {
    /// Searches on one and on two threads, per scenario and load
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = count())]
    pub trials: u64,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub scenarios: ScenarioArguments,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// `surefoot bench late`.
#[derive(Debug, Args)]
pub struct LateArguments {
    /// The scenario
    #[arg(value_name = "SCENARIO", default_value = "configs/scenarios/flat_walk.toml")]
    pub scenario: PathBuf,
    /// Walks, with the seeds 1, 2, 3 and so on
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = count())]
    pub walks: u64,
    /// The share of chunks that come late
    #[arg(long, value_name = "X", default_value_t = LATE_SHARE, value_parser = late_share)]
    pub share: f64,
    /// Write every walk as executed, with its stops, into this folder: plans that
    /// tools/replay_mujoco.py replays
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// `surefoot bench mutations`.
#[derive(Debug, Args)]
pub struct MutationsArguments {
    /// Changed plans
    #[arg(long, value_name = "N", default_value_t = 2000, value_parser = count())]
    pub plans: u64,
    /// The seed of the changes
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole_number::<u64>)]
    pub seed: u64,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub scenarios: ScenarioArguments,
    /// Change only plans of this motion: quasi_static or smooth [default: both]
    #[arg(long, value_name = "MOTION", value_parser = motion)]
    pub motion: Option<MotionKind>,
    /// Write the changed plans that are accepted into this folder: plans that
    /// tools/replay_mujoco.py replays
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// `surefoot bench goals`.
#[derive(Debug, Args)]
pub struct GoalsArguments {
    /// The robot
    #[arg(long, value_name = "ROBOT.toml", default_value = "configs/robots/hubo/robot.toml")]
    pub robot: PathBuf,
    /// Number of goals
    #[arg(long, value_name = "N", default_value_t = 1000, value_parser = count())]
    pub trials: u64,
    /// Largest distance of a goal from the start, m
    #[arg(long, value_name = "M", default_value_t = 1.5, value_parser = positive)]
    pub radius: f64,
    /// Largest turn of a goal against the start, rad
    #[arg(
        long,
        value_name = "RAD",
        default_value_t = std::f64::consts::PI,
        value_parser = not_negative
    )]
    pub turn: f64,
    /// Distance between the feet at the start and at every goal, m
    #[arg(long, value_name = "M", default_value_t = 0.2, value_parser = positive)]
    pub stance_width: f64,
    /// Tolerance of the goals' positions, m
    #[arg(long, value_name = "M", default_value_t = 0.01, value_parser = positive)]
    pub position_tolerance: f64,
    /// Tolerance of the goals' headings, rad
    #[arg(long, value_name = "RAD", default_value_t = 0.01, value_parser = positive)]
    pub yaw_tolerance: f64,
    /// Work units of each search at most
    #[arg(long, value_name = "N", default_value_t = 60_000, value_parser = whole_number::<u64>)]
    pub work: u64,
    /// The motion of the plans
    #[arg(long, value_name = "MOTION", value_parser = motion, default_value = "smooth")]
    pub motion: MotionKind,
    /// The seed of the searches
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole_number::<u64>)]
    pub seed: u64,
    /// The seed of the goals
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole_number::<u64>)]
    pub goals_seed: u64,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub threads: ThreadArguments,
    /// Write goals.csv into this folder
    #[arg(long, value_name = "DIR")]
    pub out: Option<PathBuf>,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// `surefoot bench holes`.
#[derive(Debug, Args)]
pub struct HolesArguments {
    /// The folder with scenarios, robots and worlds
    #[arg(long, value_name = "DIR", default_value = "configs")]
    pub folder: PathBuf,
    /// Only the worlds whose names contain this
    #[arg(long, value_name = "NAME", default_value = "")]
    pub world: String,
    /// Number of seeds of each world
    #[arg(long, value_name = "N", default_value_t = 20, value_parser = count())]
    pub trials: u64,
    /// Work units of each search at most
    #[arg(long, value_name = "N", default_value_t = 400_000, value_parser = whole_number::<u64>)]
    pub work: u64,
    #[command(flatten)]
    #[allow(missing_docs, reason = "the field's type says it")]
    pub threads: ThreadArguments,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// `surefoot bench impossible`.
#[derive(Debug, Args)]
pub struct ImpossibleArguments {
    /// The robot
    #[arg(long, value_name = "ROBOT.toml", default_value = "configs/robots/hubo/robot.toml")]
    pub robot: PathBuf,
    /// Number of worlds
    #[arg(long, value_name = "N", default_value_t = 200, value_parser = count())]
    pub worlds: u64,
    /// The seed of the first world; each further one has the next
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole_number::<u64>)]
    pub worlds_seed: u64,
    /// Work units of each search at most
    #[arg(long, value_name = "N", default_value_t = 20_000, value_parser = whole_number::<u64>)]
    pub work: u64,
    /// Work units of each search by each method in a world that is called impossible
    #[arg(long, value_name = "N", default_value_t = 60_000, value_parser = whole_number::<u64>)]
    pub search_on: u64,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// `surefoot bench ipc`.
#[derive(Debug, Args)]
pub struct IpcArguments {
    /// Round trips of each transport
    #[arg(
        long,
        value_name = "N",
        default_value_t = 20_000,
        value_parser = whole_number_between::<u32>(100, 10_000_000)
    )]
    pub rounds: u32,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

/// `surefoot bench soak`.
#[derive(Debug, Args)]
pub struct SoakArguments {
    /// The scenario of the walks
    #[arg(long, value_name = "SCENARIO", default_value = "stepping_stones")]
    pub scenario: PathBuf,
    /// The motion of the walks, if it is not the scenario's
    #[arg(long, value_name = "quasi_static|smooth", value_parser = motion)]
    pub motion: Option<MotionKind>,
    /// The rate of the walks' simulated time, in multiples of real time: the robot moves when a
    /// process is killed
    #[arg(long, value_name = "RATE", value_parser = rate)]
    pub rate: Option<f64>,
    /// The scenario of the pair that serves requests
    #[arg(long, value_name = "SCENARIO", default_value = "flat_walk")]
    pub request_scenario: PathBuf,
    /// Walks
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = whole_number::<u64>)]
    pub walks: u64,
    /// Requests
    #[arg(long, value_name = "N", default_value_t = 100, value_parser = whole_number::<u64>)]
    pub requests: u64,
    /// Begin no further walk or request after this time, s
    #[arg(long, value_name = "S", default_value_t = 600.0, value_parser = seconds)]
    pub seconds: f64,
    /// The seed of the faults
    #[arg(long, value_name = "N", default_value_t = 1, value_parser = whole_number::<u64>)]
    pub seed: u64,
    /// Print JSON
    #[arg(long)]
    pub json: bool,
}

fn seconds(text: &str) -> Result<f64, String> {
    let number = text.parse().ok().filter(|number: &f64| *number > 0.0 && *number <= 1e9);
    number.ok_or_else(|| "a positive number of at most 1e9 is needed".into())
}
