//! The processes of a walk.

/// The duty of a process.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Role {
    /// Plans and delivers.
    Planner,
    /// Checks and executes.
    Controller,
}

impl std::fmt::Display for Role {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(match self {
            Self::Planner => "planner",
            Self::Controller => "controller",
        })
    }
}
