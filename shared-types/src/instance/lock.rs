//! The lock that tells whether anybody lives in an instance.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::Write;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::Path;

use super::InstanceError;
use super::directory::io_error;

/// The lock file's name in the root.
pub(super) const LOCK_FILE: &str = "lock";

/// The lock, held exclusively, if nobody lives in `root`.
pub(super) fn alone(root: &Path) -> Result<Option<File>, InstanceError> {
    let Some(file) = open(root, true)? else { return Ok(None) };
    Ok((granted(file.try_lock(), root)? && still_there(&file, root)).then_some(file))
}

/// Whether anybody holds the lock.
pub(super) fn is_held(root: &Path) -> Result<bool, InstanceError> {
    let path = root.join(LOCK_FILE);
    match OpenOptions::new().read(true).custom_flags(libc::O_NOFOLLOW).open(&path) {
        Ok(file) => Ok(!granted(file.try_lock(), root)?),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(io_error(&path, error)),
    }
}

/// The lock, held together with others, unless nobody has finished creating `root`, or somebody is
/// removing it.
pub(super) fn among_others(root: &Path) -> Result<Option<File>, InstanceError> {
    let Some(file) = open(root, false)? else { return Ok(None) };
    let is_ready = |file: &File| file.metadata().is_ok_and(|metadata| metadata.len() > 0);
    Ok((granted(file.try_lock_shared(), root)? && is_ready(&file) && still_there(&file, root))
        .then_some(file))
}

/// Marks `root` as one that others may enter. `alone` is its lock.
pub(super) fn admit_others(mut alone: &File, root: &Path) -> Result<(), InstanceError> {
    alone.write_all(b"ready\n").map_err(|error| io_error(&root.join(LOCK_FILE), error))
}

/// Takes the mark of [`admit_others`] away.
pub(super) fn admit_nobody(alone: &File, root: &Path) -> Result<(), InstanceError> {
    alone.set_len(0).map_err(|error| io_error(&root.join(LOCK_FILE), error))
}

/// Turns an exclusive lock into a shared one. False if somebody removed the root in between.
pub(super) fn share(file: &File, root: &Path) -> Result<bool, InstanceError> {
    Ok(granted(file.try_lock_shared(), root)? && still_there(file, root))
}

/// Turns a shared lock into an exclusive one if nobody else holds it.
pub(super) fn become_alone(file: &File) -> bool {
    file.try_lock().is_ok()
}

/// Waits a moment for whoever holds the lock.
pub(super) fn pause() {
    std::thread::sleep(std::time::Duration::from_millis(5));
}

fn open(root: &Path, create: bool) -> Result<Option<File>, InstanceError> {
    let path = root.join(LOCK_FILE);
    let opened = OpenOptions::new()
        .read(true)
        .write(true)
        .create(create)
        .truncate(false)
        .mode(0o600)
        .custom_flags(libc::O_NOFOLLOW)
        .open(&path);
    match opened {
        Ok(file) => Ok(Some(file)),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(None),
        Err(error) => Err(io_error(&path, error)),
    }
}

fn granted(result: Result<(), TryLockError>, root: &Path) -> Result<bool, InstanceError> {
    match result {
        Ok(()) => Ok(true),
        Err(TryLockError::WouldBlock) => Ok(false),
        Err(TryLockError::Error(error)) => Err(io_error(&root.join(LOCK_FILE), error)),
    }
}

/// Whether the locked file is still the one that stands in `root`.
fn still_there(file: &File, root: &Path) -> bool {
    let (Ok(held), Ok(standing)) = (file.metadata(), root.join(LOCK_FILE).symlink_metadata())
    else {
        return false;
    };
    (held.dev(), held.ino()) == (standing.dev(), standing.ino())
}
