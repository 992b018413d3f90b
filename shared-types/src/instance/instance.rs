//! An instance: the private part of shared memory that one planner and one controller share.
//!
//! Its root folder is `/dev/shm/surefoot-<uid>/<name>`, mode 0700, and every segment carries a
//! prefix of its own, so that nothing is shared with other users or other iceoryx2 programs.
//! Every process of the instance holds a shared lock on the file `lock` in the root; the kernel
//! drops the locks of killed processes. Only a process that holds the lock exclusively may remove
//! the root and its segments: the last process that leaves does so, and so does the next
//! [`Instance::create`] or [`Instance::clean_dead`] after a crash.

use crate::instance::capacity;
use crate::instance::directory;
use crate::instance::lock;
use std::fs::File;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use iceoryx2::prelude::{Config, FileName, Path as IoxPath, SemanticString};

use crate::instance::directory::remove_segments;

use crate::base::digest::Digest;

/// Longest name of an instance, bytes.
pub const NAME_LEN_MAX: usize = 32;
/// Longest path of a base folder, bytes; leaves room for iceoryx2's own folders below it.
const BASE_PATH_LEN_MAX: usize = 64;
/// How often a lock is tried while another process creates or removes the same instance.
const LOCK_ATTEMPTS_MAX: usize = 20;

/// Why an instance cannot be entered.
#[derive(Debug, thiserror::Error)]
pub enum InstanceError {
    /// The name is not usable.
    #[error("instance name '{name}': use 1 to {NAME_LEN_MAX} of the characters a-z, 0-9, _ and -")]
    Name {
        /// The name as given.
        name: String,
    },
    /// Another user owns the folder, or others may enter it.
    #[error("{}: {reason}; remove it, or choose another instance name", path.display())]
    NotPrivate {
        /// The folder or segment.
        path: PathBuf,
        /// What is wrong with it.
        reason: String,
    },
    /// Other processes use it.
    #[error("instance '{name}' is in use; end its processes or choose another name")]
    InUse {
        /// Its name.
        name: String,
    },
    /// It was not created.
    #[error("instance '{name}' does not exist ({}); start its creator first", root.display())]
    Missing {
        /// Its name.
        name: String,
        /// Where it was looked for.
        root: PathBuf,
    },
    /// The path does not fit iceoryx2's limits.
    #[error("{}: the path is not absolute, not plain text, or longer than {BASE_PATH_LEN_MAX} bytes", path.display())]
    Path {
        /// The base folder.
        path: PathBuf,
    },
    /// Shared memory is full.
    #[error(
        "shared memory is full: {free_kib} KiB free, {needed_kib} KiB are needed; free some in /dev/shm, or enlarge it (in a container: --shm-size=256m)"
    )]
    Full {
        /// Free memory.
        free_kib: u64,
        /// Needed memory.
        needed_kib: u64,
    },
    /// The file system refused.
    #[error("{}: {source}", path.display())]
    Io {
        /// The file or folder.
        path: PathBuf,
        /// The error of the system.
        source: std::io::Error,
    },
}

/// A handle on an instance. Clones share it; with the last one the process leaves.
#[derive(Debug, Clone)]
pub struct Instance {
    membership: Arc<Membership>,
}

#[derive(Debug)]
struct Membership {
    location: Location,
    lock: File,
}

/// Name, root folder and segment prefix of an instance.
#[derive(Debug, Clone)]
pub(crate) struct Location {
    name: String,
    root: PathBuf,
    prefix: String,
}

impl Instance {
    /// Creates an instance under the default base folder, after removing what a crash left of it.
    ///
    /// # Errors
    /// The name is invalid, the instance is in use, its folder belongs to somebody else, or the
    /// file system fails.
    pub fn create(name: &str) -> Result<Self, InstanceError> {
        Self::create_in(&directory::default_base()?, name)
    }

    /// Enters an instance that another process created.
    ///
    /// # Errors
    /// The name is invalid, the instance does not exist, its folder belongs to somebody else, or
    /// the file system fails.
    pub fn attach(name: &str) -> Result<Self, InstanceError> {
        Self::attach_in(&directory::default_base()?, name)
    }

    /// Like [`Self::create`], with the base folder given: an absolute path, created with mode 0700
    /// when missing.
    ///
    /// # Errors
    /// As [`Self::create`]; also where the base folder's path is relative or too long.
    pub fn create_in(base: &Path, name: &str) -> Result<Self, InstanceError> {
        let location = Location::new(base, name)?;
        for _ in 0..LOCK_ATTEMPTS_MAX {
            directory::refuse_foreign_segments(&location.prefix)?;
            // Nothing slow from here to the lock: `clean_dead` takes a folder without a lock for
            // dead.
            let is_there =
                directory::ensure_private(base)? && directory::ensure_private_root(&location.root)?;
            if is_there && let Some(lock) = lock::lock_exclusive(&location.root)? {
                lock::mark_unready(&lock, &location.root)?;
                directory::empty_except_lock(&location.root)?;
                remove_segments(&location.prefix)?;
                lock::mark_ready(&lock, &location.root)?;
                if lock::downgrade(&lock, &location.root)? {
                    return Ok(Self { membership: Arc::new(Membership { location, lock }) });
                }
            }
            lock::pause();
        }
        Err(InstanceError::InUse { name: location.name })
    }

    /// Like [`Self::attach`], with the base folder given.
    ///
    /// # Errors
    /// As [`Self::attach`]; also where the base folder's path is relative or too long.
    pub fn attach_in(base: &Path, name: &str) -> Result<Self, InstanceError> {
        let location = Location::new(base, name)?;
        for _ in 0..LOCK_ATTEMPTS_MAX {
            if !directory::is_ours(base)? || !directory::is_ours(&location.root)? {
                break;
            }
            directory::refuse_foreign_segments(&location.prefix)?;
            if let Some(lock) = lock::lock_shared(&location.root)? {
                return Ok(Self { membership: Arc::new(Membership { location, lock }) });
            }
            lock::pause();
        }
        Err(InstanceError::Missing { name: location.name, root: location.root })
    }

    /// Removes every instance of this user without a running process; returns how many.
    /// Call it at start-up.
    ///
    /// # Errors
    /// The base folder cannot be read, or a dead instance cannot be locked or removed.
    pub fn clean_dead() -> Result<usize, InstanceError> {
        Self::clean_dead_in(&directory::default_base()?)
    }

    /// Like [`Self::clean_dead`], with the base folder given.
    ///
    /// # Errors
    /// As [`Self::clean_dead`].
    pub fn clean_dead_in(base: &Path) -> Result<usize, InstanceError> {
        let mut removed = 0;
        for name in directory::child_names(base)? {
            let Ok(location) = Location::new(base, &name) else { continue };
            if !matches!(directory::is_ours(&location.root), Ok(true)) {
                continue;
            }
            if let Some(lock) = lock::lock_exclusive(&location.root)? {
                location.remove(&lock)?;
                removed += 1;
            }
        }
        Ok(removed)
    }

    /// The names of all instances of this user with a running process.
    ///
    /// # Errors
    /// The folder of all instances is not private to this user.
    pub fn running() -> Result<Vec<String>, InstanceError> {
        let base = directory::default_base()?;
        let mut names = directory::child_names(&base)?;
        names.retain(|name| {
            Location::new(&base, name)
                .is_ok_and(|location| matches!(lock::is_locked(&location.root), Ok(true)))
        });
        Ok(names)
    }

    /// The instance's name.
    pub fn name(&self) -> &str {
        &self.membership.location.name
    }

    /// The instance's root folder.
    pub fn root(&self) -> &Path {
        &self.membership.location.root
    }

    /// What every shared-memory segment's name of this instance begins with.
    pub fn segment_prefix(&self) -> &str {
        &self.membership.location.prefix
    }

    /// Checks that shared memory has room for what a process of this instance puts there.
    ///
    /// # Errors
    /// It has not.
    pub(crate) fn check_capacity(&self) -> Result<(), InstanceError> {
        capacity::check(self.root())?;
        capacity::check(Path::new(directory::SHARED_MEMORY))
    }

    /// Takes the memory of all segments of this instance from the system now, so that no later
    /// touch of them can find none left, and closes them to other users. Call it after opening
    /// ports.
    ///
    /// # Errors
    /// Shared memory is full.
    pub fn reserve_segments(&self) -> Result<(), InstanceError> {
        directory::segments(self.segment_prefix())?
            .iter()
            .try_for_each(|segment| capacity::reserve(&segment.path()))
    }

    /// iceoryx2's configuration for this instance. Nothing is looked up in files.
    pub(crate) fn config(&self) -> Result<Config, InstanceError> {
        let location = &self.membership.location;
        let unusable = || InstanceError::Path { path: location.root.clone() };
        let root = location.root.to_str().ok_or_else(unusable)?;
        let mut config = Config::default();
        config.global.set_root_path(&IoxPath::new(root.as_bytes()).map_err(|_| unusable())?);
        config.global.prefix = FileName::new(location.prefix.as_bytes()).map_err(|_| unusable())?;
        Ok(config)
    }
}

impl Location {
    fn new(base: &Path, name: &str) -> Result<Self, InstanceError> {
        let fits = (1..=NAME_LEN_MAX).contains(&name.len());
        if !fits
            || !name.bytes().all(|byte| {
                byte.is_ascii_lowercase() || byte.is_ascii_digit() || byte == b'_' || byte == b'-'
            })
        {
            return Err(InstanceError::Name { name: name.to_owned() });
        }
        let path =
            base.to_str().filter(|path| base.is_absolute() && path.len() <= BASE_PATH_LEN_MAX);
        let path = path.ok_or_else(|| InstanceError::Path { path: base.to_owned() })?;
        let tag = Digest::of(&[path.as_bytes()]).to_string();
        Ok(Self {
            name: name.to_owned(),
            root: base.join(name),
            prefix: format!("surefoot-{}-{name}.", &tag[..12]),
        })
    }

    /// Removes root and segments. `_exclusive` is the exclusive lock that makes it lawful.
    fn remove(&self, _exclusive: &File) -> Result<(), InstanceError> {
        remove_segments(&self.prefix)?;
        directory::remove_root(&self.root)
    }
}

impl Drop for Membership {
    fn drop(&mut self) {
        if lock::upgrade(&self.lock) {
            // A failure leaves files that the next start removes; it is not reported.
            let _ = self.location.remove(&self.lock);
        }
    }
}

#[cfg(test)]
mod tests;
