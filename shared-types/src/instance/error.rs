//! Errors of instances and of the channels in them.

use std::io;
use std::path::{Path, PathBuf};

use crate::instance::tuning::MAKING_WAIT_MAX;

/// The folder in which Linux shows POSIX shared memory.
pub(crate) const SHARED_MEMORY: &str = "/dev/shm";

/// Longest name of an instance, bytes.
pub const NAME_LEN_MAX: usize = 32;
/// Longest path of a base folder, bytes. iceoryx2 limits its paths, and its folders lie below.
pub(crate) const BASE_PATH_LEN_MAX: usize = 64;

/// Why an instance cannot be created, attached or cleaned.
#[derive(Debug, thiserror::Error)]
pub enum InstanceError {
    /// The name is not usable.
    #[error("instance name '{name}': use 1 to {NAME_LEN_MAX} of the characters a-z, 0-9, _ and -")]
    Name {
        /// The name as given.
        name: String,
    },
    /// Another user owns the folder, or other users may enter it.
    #[error("{}: {reason}; remove it, or choose another instance name", path.display())]
    NotPrivate {
        /// The folder or segment.
        path: PathBuf,
        /// Why it is not private.
        reason: String,
    },
    /// Other processes use the instance.
    #[error("instance '{name}' is in use; end its processes or choose another name")]
    InUse {
        /// Its name.
        name: String,
    },
    /// No process created the instance.
    #[error("instance '{name}' does not exist ({}); start its creator first", root.display())]
    Missing {
        /// Its name.
        name: String,
        /// Its root folder, if it existed.
        root: PathBuf,
    },
    /// Another process holds the lock `making` for too long.
    #[error(
        "{}: another process has been opening this instance for {} s; continue it or end it",
        root.display(),
        MAKING_WAIT_MAX.as_secs()
    )]
    Making {
        /// The instance's root folder.
        root: PathBuf,
    },
    /// The path does not fit iceoryx2's limits.
    #[error(
        "{}: the path is not absolute, not plain text, or longer than {BASE_PATH_LEN_MAX} bytes",
        path.display()
    )]
    Path {
        /// The base folder.
        path: PathBuf,
    },
    /// Shared memory is missing or read-only.
    #[error(
        "shared memory: {SHARED_MEMORY} cannot be written to: {source}; mount a tmpfs there with mode 1777"
    )]
    NoSharedMemory {
        /// The error of the operating system.
        source: io::Error,
    },
    /// Shared memory is full.
    #[error(
        "shared memory is full: {free_kib} KiB free, {needed_kib} KiB are needed; free some in /dev/shm, or enlarge it (in a container: --shm-size=256m)"
    )]
    Full {
        /// Free memory, KiB.
        free_kib: u64,
        /// Needed memory, KiB.
        needed_kib: u64,
    },
    /// The file system failed.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The error of the operating system.
        source: io::Error,
    },
}

/// The error `source` at `path`.
pub(crate) fn io_error(path: &Path, source: io::Error) -> InstanceError {
    InstanceError::Io { path: path.to_owned(), source }
}

/// Why a channel cannot be opened or used.
#[derive(Debug, thiserror::Error)]
pub enum ChannelError {
    /// The instance is unusable.
    #[error(transparent)]
    Instance(#[from] InstanceError),
    /// The other program has another message layout.
    #[error(
        "service '{service}': the other program has another message layout; use the same version of surefoot on both sides"
    )]
    Layout {
        /// The service's name.
        service: String,
    },
    /// An iceoryx2 operation failed.
    #[error("{action}: {reason}; run 'surefoot doctor'")]
    Transport {
        /// The operation, such as "receiving a chunk".
        action: String,
        /// The reason that iceoryx2 gives.
        reason: String,
    },
    /// A process gave itself the reserved id 0.
    #[error("the id 0 is reserved; use instance::random_id")]
    Id,
    /// Another controller moves the robot of this instance.
    #[error(
        "another controller moves the robot of this instance; end it, or choose another instance name"
    )]
    Taken,
    /// Another planner delivers plans in this instance.
    #[error(
        "another planner plans for this instance; end it, send it a request ('surefoot request'), or choose another instance name"
    )]
    PlannerTaken,
    /// The instance takes no more processes.
    #[error("this instance has as many clients as it can have; try again when one has ended")]
    TooManyClients,
    /// The chunks given are not one stream.
    #[error(
        "chunk {index} of the plan does not continue the stream: same plan and epoch, sequence {index} and the digest so far are needed"
    )]
    Stream {
        /// Index of the first chunk that does not fit.
        index: usize,
    },
}

impl ChannelError {
    /// An error of iceoryx2 during `action`.
    pub fn transport(action: &str, reason: impl std::fmt::Debug) -> Self {
        Self::Transport { action: action.to_owned(), reason: format!("{reason:?}") }
    }
}
