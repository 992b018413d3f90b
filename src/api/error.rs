//! Errors, one enum an operation. Each message names the problem and its correction.

use surefoot_controller_sim::CheckerError;
use surefoot_planner::pipeline::PlannerError;
use surefoot_planner::preparation::{BuildError as PreparationBuildError, PreparationError};
use surefoot_shared_types::InputError;
use surefoot_shared_types::config::builder::ScenarioError;
use surefoot_shared_types::instance::ChannelError;
use surefoot_shared_types::instance::error::InstanceError;
use surefoot_shared_types::world::correction::CorrectionError;

pub use surefoot_shared_types::world::builder::WorldError;

/// Why a file cannot be used: file, line, element and problem.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct LoadError(#[from] InputError);

impl LoadError {
    /// The file, the line and the error.
    pub fn input_error(&self) -> &InputError {
        &self.0
    }
}

/// Why a plan cannot be saved.
#[derive(Debug, thiserror::Error)]
#[error(transparent)]
pub struct SaveError(#[from] InputError);

impl SaveError {
    /// The file and the error.
    pub fn input_error(&self) -> &InputError {
        &self.0
    }
}

/// Why a robot cannot be prepared.
#[derive(Debug, thiserror::Error)]
pub enum PrepareError {
    /// The planner cannot move this robot.
    #[error(transparent)]
    Robot(#[from] PreparationBuildError),
    /// The bytes are damaged, or those of another robot or of other margins.
    #[error("the preparation {0}; make it anew with Prepared::new")]
    Bytes(#[from] PreparationError),
    /// The bytes cannot be read.
    #[error("the preparation cannot be read: {0}")]
    Read(#[from] std::io::Error),
    /// The file cannot be written.
    #[error("the preparation cannot be saved: {0}; use Prepared::new, or another folder")]
    Save(std::io::Error),
}

/// Why a planner cannot be built.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// A parameter is out of range, or at odds with another one.
    #[error(transparent)]
    Parameter(#[from] ScenarioError),
    /// A planner needs a thread.
    #[error("a planner needs at least one thread")]
    NoThread,
    /// The planner cannot use the robot or the world, the preparation was made with other margins,
    /// or the threads cannot be started.
    #[error(transparent)]
    Planner(#[from] PlannerError),
}

/// Why a search cannot begin.
#[derive(Debug, thiserror::Error)]
pub enum StartError {
    /// A number of the start or the goal is out of range.
    #[error(transparent)]
    Stance(#[from] ScenarioError),
    /// As for building a planner.
    #[error(transparent)]
    Planner(#[from] PlannerError),
}

/// Why there is no plan.
#[derive(Debug, thiserror::Error)]
pub enum PlanError {
    /// The search could not begin.
    #[error(transparent)]
    Start(#[from] StartError),
    /// The limit of work was reached.
    #[error("no plan within {work} work units; raise PlannerBuilder::work_max")]
    BudgetExhausted {
        /// The work units spent.
        work: u64,
    },
    /// An arena is full.
    #[error("no plan: an arena is full; raise {parameter} in Parameters::planner")]
    ArenaFull {
        /// The parameter that sizes it.
        parameter: &'static str,
    },
    /// No plan is possible: the obstruction, and where it is.
    #[error("{0}")]
    Impossible(String),
    /// The robot cannot stand at the start.
    #[error("{0}")]
    StartInvalid(String),
    /// The robot cannot stand at the goal.
    #[error("{0}")]
    GoalInvalid(String),
}

/// Why a plan cannot be made anew.
#[derive(Debug, thiserror::Error)]
pub enum ReplanError {
    /// Nothing was planned before.
    #[error("there is no plan to make anew; call plan or begin first")]
    NothingPlanned,
    /// A correction names no shape of the world, or is malformed.
    #[error(transparent)]
    Correction(#[from] CorrectionError),
    /// There is no plan from the state.
    #[error(transparent)]
    Plan(#[from] PlanError),
}

/// Why a plan cannot be checked as an answer to a task.
#[derive(Debug, thiserror::Error)]
pub enum AnswerError {
    /// A number of the start, the goal or the parameters is out of range.
    #[error(transparent)]
    Stance(#[from] ScenarioError),
    /// The plan moves other joints than the robot has, or the checker cannot compute with the
    /// robot or the world.
    #[error(transparent)]
    Plan(#[from] InputError),
}

/// Why a checker or a plan file cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum CheckError {
    /// The checker cannot compute with the robot or the world.
    #[error(transparent)]
    Checker(#[from] CheckerError),
    /// The plan file, its robot or its world cannot be used.
    #[error(transparent)]
    File(#[from] InputError),
}

/// Why shared memory cannot be used.
#[derive(Debug, thiserror::Error)]
pub enum TransportError {
    /// The instance cannot be entered.
    #[error(transparent)]
    Instance(#[from] InstanceError),
    /// The transport fails, or the other processes lay their messages out differently.
    #[error(transparent)]
    Channel(#[from] ChannelError),
}
