//! An instance: the shared memory that one planner, one controller and their clients use, closed
//! to other users and programs.
//!
//! Its root folder is `/dev/shm/surefoot-<uid>/<name>`, mode 0700, and the name of every
//! shared-memory segment begins with the instance's prefix. Every process of the instance holds a
//! shared lock on the file `lock` in the root; the kernel drops the locks of killed processes.
//! Only a process that holds the lock exclusively removes the root and its segments: the last
//! process that leaves, or after a crash [`Instance::create`] or [`Instance::clean_dead`].

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use iceoryx2::prelude::{Config, FileName, Path as IoxPath, SemanticString};

use crate::instance::capacity;
use crate::instance::directory;
use crate::instance::error::{InstanceError, SHARED_MEMORY};
use crate::instance::location::Location;
use crate::instance::lock;
use crate::instance::tuning::LOCK_ATTEMPTS_MAX;

/// A handle on an instance. Clones share it; when the last one is dropped the process leaves.
#[derive(Debug, Clone)]
pub struct Instance {
    membership: Arc<Membership>,
}

#[derive(Debug)]
struct Membership {
    location: Location,
    lock: File,
}

impl Instance {
    /// Creates an instance below the default base folder. Removes files that a crash left there.
    ///
    /// # Errors
    /// The name is invalid, the instance is in use, its folder belongs to another user, or the
    /// file system fails.
    pub fn create(name: &str) -> Result<Self, InstanceError> {
        Self::create_in(&directory::default_base()?, name)
    }

    /// Enters an instance that another process created.
    ///
    /// # Errors
    /// The name is invalid, the instance does not exist, its folder belongs to another user, or
    /// the file system fails.
    pub fn attach(name: &str) -> Result<Self, InstanceError> {
        Self::attach_in(&directory::default_base()?, name)
    }

    /// As [`Self::create`], below the folder `base`: an absolute path, created with mode 0700 if
    /// it does not exist.
    ///
    /// # Errors
    /// As [`Self::create`]; also if the path of `base` is relative or too long.
    pub fn create_in(base: &Path, name: &str) -> Result<Self, InstanceError> {
        let location = Location::new(base, name)?;
        for _ in 0..LOCK_ATTEMPTS_MAX {
            directory::refuse_foreign_segments(&location.prefix)?;
            // Nothing slow between the folder and its lock: `clean_dead` counts a folder without a
            // lock as dead.
            let exists =
                directory::ensure_private(base)? && directory::ensure_private_root(&location.root)?;
            if exists && let Some(lock) = lock::lock_exclusive(&location.root)? {
                lock::mark_unready(&lock, &location.root)?;
                directory::empty_except_lock(&location.root)?;
                directory::remove_segments(&location.prefix)?;
                lock::mark_ready(&lock, &location.root)?;
                if lock::downgrade(&lock, &location.root)? {
                    return Ok(Self { membership: Arc::new(Membership { location, lock }) });
                }
            }
            lock::pause();
        }
        Err(InstanceError::InUse { name: location.name })
    }

    /// As [`Self::attach`], below the folder `base`.
    ///
    /// # Errors
    /// As [`Self::attach`]; also if the path of `base` is relative or too long.
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

    /// Removes every instance of this user that has no running process, and returns how many.
    ///
    /// # Errors
    /// The base folder cannot be read, or a dead instance cannot be locked or removed.
    pub fn clean_dead() -> Result<usize, InstanceError> {
        Self::clean_dead_in(&directory::default_base()?)
    }

    /// As [`Self::clean_dead`], below the folder `base`.
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
            if let Some(_exclusive) = lock::lock_exclusive(&location.root)? {
                location.remove()?;
                removed += 1;
            }
        }
        Ok(removed)
    }

    /// The names of all instances of this user that have a running process.
    ///
    /// # Errors
    /// The base folder is not private to this user.
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

    /// The beginning of the name of every shared-memory segment of this instance.
    pub fn segment_prefix(&self) -> &str {
        &self.membership.location.prefix
    }

    /// Checks that shared memory has space for one more process of this instance.
    pub(crate) fn check_capacity(&self) -> Result<(), InstanceError> {
        capacity::check(self.root())?;
        capacity::check(Path::new(SHARED_MEMORY))
    }

    /// Allocates the memory of all segments of this instance, so that no later access of a page
    /// fails, and closes them to other users. Call it after opening ports.
    ///
    /// # Errors
    /// Shared memory is full.
    pub fn reserve_segments(&self) -> Result<(), InstanceError> {
        directory::segments(self.segment_prefix())?
            .iter()
            .try_for_each(|segment| capacity::reserve(&segment.path()))
    }

    /// iceoryx2's configuration for this instance. No configuration file is read.
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

impl Drop for Membership {
    fn drop(&mut self) {
        if lock::upgrade(&self.lock) {
            // The next start removes files that a failure leaves here; it is not reported.
            let _ = self.location.remove();
        }
    }
}
