//! The lock file of an instance. A process in the instance holds it shared; a process that creates
//! or removes the instance holds it exclusively. It contains the instance's token once the instance
//! is ready for other processes.

use std::fs::{File, TryLockError};
use std::os::unix::fs::{FileExt, MetadataExt};
use std::path::Path;

use crate::instance::error::{InstanceError, io_error};
use crate::instance::private::open_file;
use crate::instance::token::Token;
use crate::instance::tuning::LOCK_PAUSE;

/// The lock file's name in the root.
pub(crate) const LOCK_FILE: &str = "lock";

/// Longest content of a lock file that is read, bytes.
const CONTENT_BYTES_MAX: usize = 64;

/// The lock, held exclusively, if no other process holds it.
pub(crate) fn lock_exclusive(root: &Path) -> Result<Option<File>, InstanceError> {
    let Some(file) = open_file(&root.join(LOCK_FILE), true)? else { return Ok(None) };
    Ok((granted(file.try_lock(), root)? && is_current_file(&file, root)).then_some(file))
}

/// Whether a process holds the lock.
pub(crate) fn is_locked(root: &Path) -> Result<bool, InstanceError> {
    match open_file(&root.join(LOCK_FILE), false)? {
        Some(file) => Ok(!granted(file.try_lock(), root)?),
        None => Ok(false),
    }
}

/// The lock, held shared, with the instance's token; `None` while `root` is being created or
/// removed.
pub(crate) fn lock_shared(root: &Path) -> Result<Option<(File, Token)>, InstanceError> {
    let Some(file) = open_file(&root.join(LOCK_FILE), false)? else { return Ok(None) };
    if !granted(file.try_lock_shared(), root)? || !is_current_file(&file, root) {
        return Ok(None);
    }
    Ok(token(&file).map(|token| (file, token)))
}

/// The token in a lock file that this process has locked; `None` if the instance is not ready.
pub(crate) fn token(locked: &File) -> Option<Token> {
    let mut content = [0; CONTENT_BYTES_MAX];
    let read = locked.read_at(&mut content, 0).ok()?;
    let text = std::str::from_utf8(&content[..read]).ok()?;
    Token::parse(text.strip_suffix('\n')?)
}

/// Writes the token, which marks `root` as ready for other processes. `exclusive` is its lock.
pub(crate) fn mark_ready(exclusive: &File, root: &Path, token: Token) -> Result<(), InstanceError> {
    let content = format!("{token}\n");
    exclusive
        .write_all_at(content.as_bytes(), 0)
        .map_err(|error| io_error(&root.join(LOCK_FILE), error))
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
