//! An instance: the shared memory that one planner, one controller and their clients use, closed
//! to other users and programs.
//!
//! Its root folder is `/dev/shm/surefoot-<uid>/<name>`, mode 0700, and the name of every
//! shared-memory segment begins with the instance's prefix. The prefix holds a random token, which
//! the file `lock` in the root contains. Every process of the instance holds a shared lock on that
//! file; the kernel drops the locks of killed processes.
//! Only a process that holds the lock exclusively removes the root and its segments: the last
//! process that leaves, or after a crash [`Instance::create`] or [`Instance::clean_dead`].

use std::fs::File;
use std::path::Path;
use std::sync::Arc;

use iceoryx2::prelude::{Config, FileName, Path as IoxPath, SemanticString};

use crate::instance::dead_nodes;
use crate::instance::error::{InstanceError, SHARED_MEMORY, io_error};
use crate::instance::location::Location;
use crate::instance::token::Token;
use crate::instance::tuning::{ATTACH_PAUSE, LOCK_ATTEMPTS_MAX};
use crate::instance::{base_folder, capacity, directory, lock, private};

/// A handle on an instance. Clones share it; when the last one is dropped the process leaves.
#[derive(Debug, Clone)]
pub struct Instance {
    membership: Arc<Membership>,
}

#[derive(Debug)]
struct Membership {
    location: Location,
    token: Token,
    prefix: String,
    lock: File,
}

impl Instance {
    /// Creates an instance below the default base folder. Removes files that a crash left there.
    ///
    /// # Errors
    /// The name is invalid, the instance is in use, its folder belongs to another user, or the
    /// file system fails.
    pub fn create(name: &str) -> Result<Self, InstanceError> {
        Self::create_in(&base_folder::ensure()?, name)
    }

    /// Enters an instance that another process created.
    ///
    /// # Errors
    /// The name is invalid, the instance does not exist, its folder belongs to another user, or
    /// the file system fails.
    pub fn attach(name: &str) -> Result<Self, InstanceError> {
        for base in base_folder::existing()? {
            match Self::attach_in(&base, name) {
                Err(InstanceError::Missing { .. }) => {}
                attached => return attached,
            }
        }
        let Location { name, root } = Location::new(&base_folder::plain(), name)?;
        Err(InstanceError::Missing { name, root })
    }

    /// As [`Self::attach`], and waits while the instance does not exist and `may_wait` is true.
    ///
    /// # Errors
    /// As [`Self::attach`].
    pub fn attach_once_made(
        name: &str,
        may_wait: &mut dyn FnMut() -> bool,
    ) -> Result<Self, InstanceError> {
        loop {
            match Self::attach(name) {
                Err(InstanceError::Missing { .. }) if may_wait() => {}
                attached => return attached,
            }
            std::thread::sleep(ATTACH_PAUSE);
        }
    }

    /// As [`Self::create`], below the folder `base`: an absolute path, created with mode 0700 if
    /// it does not exist.
    ///
    /// # Errors
    /// As [`Self::create`]; also if the path of `base` is relative or too long.
    pub fn create_in(base: &Path, name: &str) -> Result<Self, InstanceError> {
        let location = Location::new(base, name)?;
        for _ in 0..LOCK_ATTEMPTS_MAX {
            // Nothing slow between the folder and its lock: `clean_dead` counts a folder without a
            // lock as dead.
            let exists = private::ensure_folder(base)? && private::ensure_root(&location.root)?;
            if exists && let Some(lock) = lock::lock_exclusive(&location.root)? {
                let token = Self::make_ready(&location, &lock)?;
                if lock::downgrade(&lock, &location.root)? {
                    return Ok(Self::of(location, token, lock));
                }
            }
            lock::pause();
        }
        Err(InstanceError::InUse { name: location.name })
    }

    /// Removes what a crash left in the root, and marks the instance as ready. `lock` is held
    /// exclusively.
    fn make_ready(location: &Location, lock: &File) -> Result<Token, InstanceError> {
        location.remove_segments(lock::token(lock))?;
        lock::mark_unready(lock, &location.root)?;
        directory::empty_except_lock(&location.root)?;
        let token = Token::random();
        lock::mark_ready(lock, &location.root, token)?;
        Ok(token)
    }

    fn of(location: Location, token: Token, lock: File) -> Self {
        let prefix = location.prefix(token);
        Self { membership: Arc::new(Membership { location, token, prefix, lock }) }
    }

    /// As [`Self::attach`], below the folder `base`.
    ///
    /// # Errors
    /// As [`Self::attach`]; also if the path of `base` is relative or too long.
    pub fn attach_in(base: &Path, name: &str) -> Result<Self, InstanceError> {
        let location = Location::new(base, name)?;
        for _ in 0..LOCK_ATTEMPTS_MAX {
            if !private::is_ours(base)? || !private::is_ours(&location.root)? {
                break;
            }
            if let Some((lock, token)) = lock::lock_shared(&location.root)? {
                return Ok(Self::of(location, token, lock));
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
        base_folder::existing()?.iter().map(|base| Self::clean_dead_in(base)).sum()
    }

    /// As [`Self::clean_dead`], below the folder `base`.
    ///
    /// # Errors
    /// As [`Self::clean_dead`].
    pub fn clean_dead_in(base: &Path) -> Result<usize, InstanceError> {
        let mut removed = 0;
        for name in directory::child_names(base)? {
            let Ok(location) = Location::new(base, &name) else { continue };
            if !matches!(private::is_ours(&location.root), Ok(true)) {
                continue;
            }
            if let Some(exclusive) = lock::lock_exclusive(&location.root)? {
                location.remove(lock::token(&exclusive))?;
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
        let mut running = Vec::new();
        for base in base_folder::existing()? {
            let mut names = directory::child_names(&base)?;
            names.retain(|name| {
                Location::new(&base, name)
                    .is_ok_and(|location| matches!(lock::is_locked(&location.root), Ok(true)))
            });
            running.extend(names);
        }
        Ok(running)
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
        &self.membership.prefix
    }

    /// Opens the regular file `name` in the root for reading and writing; creates it with mode 0600
    /// if it does not exist.
    ///
    /// # Errors
    /// It is a link, a pipe, a device or a file of another user, or the file system fails.
    pub fn open_file(&self, name: &str) -> Result<File, InstanceError> {
        let path = self.root().join(name);
        let missing = || io_error(&path, std::io::ErrorKind::NotFound.into());
        private::open_file(&path, true)?.ok_or_else(missing)
    }

    /// Checks that shared memory has space for one more process of this instance.
    pub(crate) fn check_capacity(&self) -> Result<(), InstanceError> {
        capacity::check(self.root())?;
        capacity::check(Path::new(SHARED_MEMORY))
    }

    /// Allocates the memory of all segments of this instance, so that no later access of a page
    /// fails. Call it after opening ports.
    ///
    /// # Errors
    /// Shared memory is full.
    pub fn reserve_segments(&self) -> Result<(), InstanceError> {
        directory::segments(self.segment_prefix())?
            .iter()
            .try_for_each(|segment| capacity::reserve(segment))
    }

    /// iceoryx2's configuration for this instance. No configuration file is read.
    pub(crate) fn config(&self) -> Result<Config, InstanceError> {
        let unusable = || InstanceError::Path { path: self.root().to_owned() };
        let root = self.root().to_str().ok_or_else(unusable)?;
        let mut config = Config::default();
        config.global.set_root_path(&IoxPath::new(root.as_bytes()).map_err(|_| unusable())?);
        config.global.prefix =
            FileName::new(self.segment_prefix().as_bytes()).map_err(|_| unusable())?;
        dead_nodes::leave_alone(&mut config);
        Ok(config)
    }
}

impl Drop for Membership {
    fn drop(&mut self) {
        if lock::upgrade(&self.lock) {
            // The next start removes files that a failure leaves here; it is not reported.
            let _ = self.location.remove(Some(self.token));
        }
    }
}
