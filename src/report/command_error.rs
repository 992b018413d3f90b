//! The outcomes and errors of commands, with their exit codes.

use std::path::PathBuf;

use surefoot_controller_sim::CheckerError;
use surefoot_planner::PlannerError;
use surefoot_planner::preparation::BuildError;
use surefoot_shared_types::InputError;
use surefoot_shared_types::instance::error::ChannelError;
use surefoot_shared_types::instance::error::InstanceError;
use surefoot_shared_types::world::correction::CorrectionError;

use crate::export::ExportError;
use crate::picture::PictureError;
use crate::report::role::Role;
use crate::system::limits::{self, FILE_KIB_MIN, OPEN_FILES_MIN, STACK_KIB_MIN};
use crate::system::signals;

/// The outcome of a completed command.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum CommandOutcome {
    /// Everything asked for was done: 0.
    Done,
    /// No plan within the budget: 3.
    NoPlan,
    /// The controller, or a check, refused: 4.
    Refused,
}

impl CommandOutcome {
    /// The exit code.
    pub fn code(self) -> u8 {
        match self {
            Self::Done => 0,
            Self::NoPlan => 3,
            Self::Refused => 4,
        }
    }
}

/// The error of a command that did not complete: bad input or environment.
#[derive(Debug, thiserror::Error)]
pub enum CommandError {
    /// A file cannot be used.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The robot cannot be prepared.
    #[error("{}: {source}", urdf.display())]
    Robot {
        /// Its URDF.
        urdf: PathBuf,
        /// Why.
        source: BuildError,
    },
    /// A preparation that was just built is inconsistent.
    #[error("the preparation {0}; please report this with the robot's files")]
    Preparation(String),
    /// The planner cannot use the robot or the world.
    #[error(transparent)]
    Planner(#[from] PlannerError),
    /// The checker cannot use the robot or the world.
    #[error(transparent)]
    Checker(#[from] CheckerError),
    /// No instance.
    #[error(transparent)]
    Instance(#[from] InstanceError),
    /// No transport.
    #[error(transparent)]
    Channel(#[from] ChannelError),
    /// The controller's corrections do not belong to this world.
    #[error("{0}; use the same scenario for the planner and the controller")]
    Correction(#[from] CorrectionError),
    /// Standard output takes no more.
    #[error("the result cannot be printed: standard output cannot be written to")]
    ResultNotPrinted,
    /// The controller walks the last plan or epoch that can be numbered.
    #[error(
        "the controller executes plan {plan_id}, epoch {epoch}, and no larger number exists; restart the \
         controller"
    )]
    IdsExhausted {
        /// Its plan.
        plan_id: u64,
        /// Its epoch.
        epoch: u64,
    },
    /// The arguments or the request are invalid.
    #[error("{0}")]
    Usage(String),
    /// No planner serves requests.
    #[error(
        "no planner answers; start 'surefoot plan SCENARIO --serve' with the same instance name"
    )]
    NoPlanner,
    /// The start or the goal stance is invalid.
    #[error("{0}; change the scenario's stance, its world or the robot's posture")]
    Endpoint(String),
    /// No picture.
    #[error(transparent)]
    Picture(#[from] PictureError),
    /// No export.
    #[error(transparent)]
    Export(#[from] ExportError),
    /// A file cannot be written.
    #[error("{}: cannot be written: {reason}", path.display())]
    Output {
        /// The file.
        path: PathBuf,
        /// The reason and what to do.
        reason: String,
    },
    /// A process cannot be started.
    #[error("the {role} process cannot be started: {source}")]
    Start {
        /// Which.
        role: Role,
        /// The system's reason.
        source: std::io::Error,
    },
    /// A process reported why it cannot go on.
    #[error("{role}: {message}")]
    Role {
        /// Which.
        role: Role,
        /// Its message.
        message: String,
    },
    /// A process ended before its work was done.
    #[error(
        "the {role} process ended unexpectedly ({how}); run 'surefoot doctor', then walk again"
    )]
    EndedEarly {
        /// Which.
        role: Role,
        /// Its exit status.
        how: String,
    },
    /// No controller answers.
    #[error("no controller answers; start 'surefoot control' with the same instance name")]
    ControllerLost,
    /// A sampler has not received all chunks.
    #[error(
        "{missed} accepted chunks were not received, so the walk was not sampled to its end; start \
         'surefoot sample' before the planner, on a core of its own"
    )]
    MissedChunks {
        /// How many.
        missed: u64,
    },
    /// Two processes publish feedback as the controller.
    #[error(
        "two processes answer as this instance's controller; end the one that does not belong to \
         it, then walk again"
    )]
    Contradicted,
    /// The planner received an answer that the controller has not given.
    #[error(
        "the planner reports '{result}', and the controller has not within {seconds} s; \
         another process writes into this instance: end it, then walk again"
    )]
    Disagreement {
        /// The result that the planner reports.
        result: &'static str,
        /// Time waited, s.
        seconds: f64,
    },
    /// The planner that had a request has ended.
    #[error(
        "the planner that had this request has ended; start 'surefoot plan SCENARIO --serve' with \
         the same instance name, then send it again"
    )]
    PlannerEnded,
    /// The planner that had a request was replaced.
    #[error("another planner has replaced the one that had this request; send it again")]
    PlannerReplaced,
    /// The planner answers other clients only.
    #[error(
        "the planner answers other clients, but not this request within {seconds} s; send it again"
    )]
    Unanswered {
        /// Time waited, s.
        seconds: f64,
    },
    /// More requests than a status names have ended since.
    #[error("the request has ended, and so many after it that its end is unknown; send it again")]
    EndUnknown,
    /// The planner publishes nothing, but its process exists.
    #[error(
        "the planner that has this request has been silent for {seconds} s; continue it or end it"
    )]
    PlannerSilent {
        /// Time waited, s.
        seconds: f64,
    },
    /// Something that every walk needs is missing.
    #[error("this machine cannot run a walk: {missing} requirements above are missing")]
    MissingRequirements {
        /// How many.
        missing: usize,
    },
    /// The system permits too few open files for shared memory.
    #[error("open files: the limit is {limit}, {OPEN_FILES_MIN} are needed; run 'ulimit -n 1024'")]
    OpenFiles {
        /// The limit.
        limit: u64,
    },
    /// The system permits too small files for shared memory.
    #[error(
        "file size: the limit is {kib} KiB, {FILE_KIB_MIN} are needed; run 'ulimit -f unlimited'"
    )]
    FileSize {
        /// The limit, KiB.
        kib: u64,
    },
    /// The system permits too small a stack, and no thread with another one.
    #[error(
        "stack: the limit is {kib} KiB, {STACK_KIB_MIN} are needed, and no other thread can be \
         made; run 'ulimit -s 8192'"
    )]
    Stack {
        /// The limit, KiB.
        kib: u64,
    },
    /// The supervisor that reads this role's events is gone.
    #[error("no process reads this role's events any more: {0}")]
    ReportsClosed(std::io::Error),
    /// A signal asked for the end.
    #[error("ended by signal {0}")]
    Interrupted(i32),
}

impl CommandError {
    /// The error of a command that a signal ends.
    pub fn interrupted() -> Self {
        Self::Interrupted(signals::raised().unwrap_or(libc::SIGTERM))
    }

    /// An error if a signal has asked for the end.
    ///
    /// # Errors
    /// When one has.
    pub fn unless_interrupted() -> Result<(), Self> {
        signals::raised().map_or(Ok(()), |signal| Err(Self::Interrupted(signal)))
    }

    /// An error if the limits of this process are too low for shared memory.
    ///
    /// # Errors
    /// When they are.
    pub fn unless_limited() -> Result<(), Self> {
        limits::too_few_open_files().map_or(Ok(()), |limit| Err(Self::OpenFiles { limit }))?;
        limits::too_small_files().map_or(Ok(()), |kib| Err(Self::FileSize { kib }))
    }

    /// Whether the transport failed in a way that a restart of the process may repair.
    pub fn is_transport(&self) -> bool {
        let instance = match self {
            Self::Channel(ChannelError::Transport { .. }) => return true,
            Self::Channel(ChannelError::Instance(error)) | Self::Instance(error) => error,
            _ => return false,
        };
        matches!(
            instance,
            InstanceError::Making { .. }
                | InstanceError::Missing { .. }
                | InstanceError::InUse { .. }
                | InstanceError::Io { .. }
        )
    }

    /// The exit code: 2, or 128 and the signal's number.
    pub fn code(&self) -> u8 {
        match self {
            Self::Interrupted(signal) => u8::try_from(128 + signal).unwrap_or(u8::MAX),
            _ => 2,
        }
    }

    /// Whether an output of the run cannot be written.
    pub fn is_output(&self) -> bool {
        matches!(self, Self::Output { .. })
    }

    /// The outcome's name in reports, if a run that had begun ended in this.
    pub fn name(&self) -> Option<&'static str> {
        match self {
            Self::Role { role: Role::Planner, .. }
            | Self::EndedEarly { role: Role::Planner, .. } => Some("planner_failed"),
            Self::Role { role: Role::Controller, .. }
            | Self::EndedEarly { role: Role::Controller, .. } => Some("controller_failed"),
            Self::ControllerLost => Some("controller_lost"),
            Self::Contradicted | Self::Disagreement { .. } => Some("contradicted"),
            Self::Interrupted(_) => Some("interrupted"),
            _ => None,
        }
    }
}
