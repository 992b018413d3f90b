//! The lock file of an instance. A process in the instance holds it shared; a process that creates
//! or removes the instance holds it exclusively.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::Write;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::Path;

use crate::instance::error::{InstanceError, io_error};
use crate::instance::tuning::LOCK_PAUSE;

/// The lock file's name in the root.
pub(crate) const LOCK_FILE: &str = "lock";

/// The lock, held exclusively, if no other process holds it.
pub(crate) fn lock_exclusive(root: &Path) -> Result<Option<File>, InstanceError> {
    let Some(file) = open(root, true)? else { return Ok(None) };
    Ok((granted(file.try_lock(), root)? && is_current_file(&file, root)).then_some(file))
}

/// Whether a process holds the lock.
pub(crate) fn is_locked(root: &Path) -> Result<bool, InstanceError> {
    let path = root.join(LOCK_FILE);
    match OpenOptions::new().read(true).custom_flags(libc::O_NOFOLLOW).open(&path) {
        Ok(file) => Ok(!granted(file.try_lock(), root)?),
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => Ok(false),
        Err(error) => Err(io_error(&path, error)),
    }
}

/// The lock, held shared; `None` while `root` is being created or removed.
pub(crate) fn lock_shared(root: &Path) -> Result<Option<File>, InstanceError> {
    let Some(file) = open(root, false)? else { return Ok(None) };
    let is_ready = |file: &File| file.metadata().is_ok_and(|metadata| metadata.len() > 0);
    Ok((granted(file.try_lock_shared(), root)? && is_ready(&file) && is_current_file(&file, root))
        .then_some(file))
}

/// Marks `root` as ready for other processes. `exclusive` is its lock.
pub(crate) fn mark_ready(mut exclusive: &File, root: &Path) -> Result<(), InstanceError> {
    exclusive.write_all(b"ready\n").map_err(|error| io_error(&root.join(LOCK_FILE), error))
}

/// Removes the mark of [`mark_ready`].
pub(crate) fn mark_unready(exclusive: &File, root: &Path) -> Result<(), InstanceError> {
    exclusive.set_len(0).map_err(|error| io_error(&root.join(LOCK_FILE), error))
}

/// Turns an exclusive lock into a shared one. `false` if another process removed the root between
/// the two.
pub(crate) fn downgrade(file: &File, root: &Path) -> Result<bool, InstanceError> {
    Ok(granted(file.try_lock_shared(), root)? && is_current_file(file, root))
}

/// Turns a shared lock into an exclusive one if no other process holds it.
pub(crate) fn upgrade(file: &File) -> bool {
    file.try_lock().is_ok()
}

/// Waits for [`LOCK_PAUSE`], in which the holder of the lock may release it.
pub(crate) fn pause() {
    std::thread::sleep(LOCK_PAUSE);
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

/// Whether the locked file is still the one in `root`.
fn is_current_file(file: &File, root: &Path) -> bool {
    let (Ok(locked), Ok(present)) = (file.metadata(), root.join(LOCK_FILE).symlink_metadata())
    else {
        return false;
    };
    (locked.dev(), locked.ino()) == (present.dev(), present.ino())
}
