//! Why a plan could not be exported.

use surefoot_controller_sim::CheckerError;
use surefoot_shared_types::InputError;

/// Why a plan could not be exported.
#[derive(Debug, thiserror::Error)]
pub enum ExportError {
    /// The plan, its robot or its world cannot be used.
    #[error(transparent)]
    Input(#[from] InputError),
    /// The robot or the world has no form for contact forces.
    #[error(transparent)]
    Checker(#[from] CheckerError),
    /// An option is missing, does not belong to the format, or names something unknown.
    #[error("{0}")]
    Option(String),
    /// A file that the plan names has changed.
    #[error(
        "{changed}; restore the file, or plan again: an export of another robot or world would be \
         wrong"
    )]
    Changed {
        /// The file and its change.
        changed: String,
    },
    /// No contact forces hold the robot.
    #[error(
        "no contact forces within the friction hold the robot at {time} s, so it has no static \
         efforts there; 'surefoot check' says more about this plan"
    )]
    NoEquilibrium {
        /// The time, s.
        time: f64,
    },
    /// The format's writer failed.
    #[error("the {format} export cannot be written: {reason}")]
    Writer {
        /// The format.
        format: &'static str,
        /// What its writer said.
        reason: String,
    },
}

impl ExportError {
    /// The error of a format's writer.
    pub(crate) fn writer(format: &'static str, error: impl std::fmt::Display) -> Self {
        Self::Writer { format, reason: error.to_string() }
    }
}
