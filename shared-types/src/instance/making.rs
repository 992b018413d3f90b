//! The lock `making` of an instance: its holder may make nodes, services and ports, and clean up
//! after dead processes.
//!
//! The kernel releases the lock of a killed process. So its holder knows that no running process
//! makes one of these, and removes the unfinished ones first.

use std::fs::{File, TryLockError};
use std::path::Path;
use std::sync::{Mutex, MutexGuard, PoisonError};
use std::time::Duration;

use crate::instance::error::{InstanceError, io_error};
use crate::instance::instance::Instance;
use crate::instance::tuning::{
    MAKING_PAUSE, MAKING_WAIT_MAX, UNFINISHED_AGE_MIN, UNFINISHED_POLL_INTERVAL,
};
use crate::instance::unfinished;

/// The lock file's name in the root.
const MAKING_FILE: &str = "making";

/// A process's handle on the lock `making`.
#[derive(Debug)]
pub(crate) struct MakingLock {
    file: File,
    /// Guards of this process. The lock is held while there is one.
    guards: Mutex<usize>,
}

/// Holds the lock `making` until it is dropped.
#[derive(Debug)]
#[must_use]
pub struct Making<'a> {
    lock: &'a MakingLock,
}

impl MakingLock {
    /// Opens the lock file of an instance; creates it if it does not exist.
    pub(crate) fn open(instance: &Instance) -> Result<Self, InstanceError> {
        Ok(Self { file: instance.open_file(MAKING_FILE)?, guards: Mutex::new(0) })
    }

    /// Acquires the lock within [`MAKING_WAIT_MAX`], and removes unfinished segments with this
    /// prefix and unfinished services in `root`. A process may hold several guards.
    ///
    /// # Errors
    /// Another process holds the lock all the time, or the file system fails.
    pub(crate) fn acquire(&self, root: &Path, prefix: &str) -> Result<Making<'_>, InstanceError> {
        let mut guards = self.guards();
        if *guards == 0 {
            self.wait_for_lock(root)?;
            unfinished::remove_all_but_connections(prefix, root);
            remove_dead_connections(prefix);
        }
        *guards += 1;
        Ok(Making { lock: self })
    }

    /// As [`Self::acquire`], but `None` if another process holds the lock.
    pub(crate) fn try_acquire(
        &self,
        root: &Path,
        prefix: &str,
    ) -> Result<Option<Making<'_>>, InstanceError> {
        let mut guards = self.guards();
        if *guards == 0 {
            if !self.try_lock(root)? {
                return Ok(None);
            }
            unfinished::remove_all_but_connections(prefix, root);
            remove_dead_connections(prefix);
        }
        *guards += 1;
        Ok(Some(Making { lock: self }))
    }

    fn wait_for_lock(&self, root: &Path) -> Result<(), InstanceError> {
        let mut waited = Duration::ZERO;
        while !self.try_lock(root)? {
            if waited >= MAKING_WAIT_MAX {
                return Err(InstanceError::Making { root: root.to_owned() });
            }
            std::thread::sleep(MAKING_PAUSE);
            waited += MAKING_PAUSE;
        }
        Ok(())
    }

    fn try_lock(&self, root: &Path) -> Result<bool, InstanceError> {
        match self.file.try_lock() {
            Ok(()) => Ok(true),
            Err(TryLockError::WouldBlock) => Ok(false),
            Err(TryLockError::Error(error)) => Err(io_error(&root.join(MAKING_FILE), error)),
        }
    }

    fn guards(&self) -> MutexGuard<'_, usize> {
        self.guards.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

/// Removes unfinished connections that stay unfinished for [`UNFINISHED_AGE_MIN`]. A running
/// process makes connections without the lock, and finishes them in much less time.
fn remove_dead_connections(prefix: &str) {
    let mut known = unfinished::connections(prefix);
    let mut waited = Duration::ZERO;
    while !known.is_empty() && waited < UNFINISHED_AGE_MIN {
        std::thread::sleep(UNFINISHED_POLL_INTERVAL);
        waited += UNFINISHED_POLL_INTERVAL;
        let current = unfinished::connections(prefix);
        known.retain(|inode| current.contains(inode));
    }
    unfinished::remove_connections(prefix, &known);
}

impl Drop for Making<'_> {
    fn drop(&mut self) {
        let mut guards = self.lock.guards();
        *guards -= 1;
        if *guards == 0 {
            // Fails only for a file that is not open.
            let _ = self.lock.file.unlock();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn one_process_holds_the_lock_at_a_time() {
        let base = tempfile::tempdir_in("/dev/shm").unwrap();
        let instance = Instance::create_in(&base.path().join("base"), "making").unwrap();
        let (root, prefix) = (instance.root(), instance.segment_prefix());
        let [one, other] = [0; 2].map(|_| MakingLock::open(&instance).unwrap());
        let first = one.acquire(root, prefix).unwrap();
        let second = one.acquire(root, prefix).unwrap();
        assert!(other.try_acquire(root, prefix).unwrap().is_none());
        drop(first);
        assert!(other.try_acquire(root, prefix).unwrap().is_none());
        drop(second);
        assert!(other.try_acquire(root, prefix).unwrap().is_some());
    }
}
