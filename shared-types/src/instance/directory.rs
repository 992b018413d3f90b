//! Private folders, and the shared-memory segments of iceoryx2 in `/dev/shm`.

use std::fs;
use std::fs::{DirBuilder, DirEntry};
use std::io;
use std::io::ErrorKind;
use std::os::unix::fs::{DirBuilderExt, MetadataExt};
use std::path::{Path, PathBuf};

use crate::instance::error::{InstanceError, SHARED_MEMORY, io_error};
use crate::instance::lock::LOCK_FILE;

/// The folder of all instances of this user, in `/dev/shm`: there iceoryx2 puts its segments.
pub(crate) fn default_base() -> Result<PathBuf, InstanceError> {
    let base = Path::new(SHARED_MEMORY).join(format!("surefoot-{}", effective_uid()));
    match ensure_private(&base) {
        Ok(_) => Ok(base),
        Err(InstanceError::Io { source, .. }) => Err(InstanceError::NoSharedMemory { source }),
        Err(not_private) => Err(not_private),
    }
}

/// Creates a folder with mode 0700, or checks that an existing one is private to this user. `false`
/// if it existed and another process removed it before the check.
pub(crate) fn ensure_private(path: &Path) -> Result<bool, InstanceError> {
    match DirBuilder::new().mode(0o700).create(path) {
        Ok(()) => Ok(true),
        Err(error) if error.kind() == ErrorKind::AlreadyExists => is_ours(path),
        Err(error) => Err(io_error(path, error)),
    }
}

/// As [`ensure_private`] for a folder in the base; `false` also if another process removed the base
/// in between.
pub(crate) fn ensure_private_root(root: &Path) -> Result<bool, InstanceError> {
    unless_missing(ensure_private(root))
}

/// Whether `path` exists; an error if it is not a private folder of this user.
pub(crate) fn is_ours(path: &Path) -> Result<bool, InstanceError> {
    unless_missing(check_private(path).map(|()| true))
}

/// `false` instead of the error that a file does not exist.
fn unless_missing(found: Result<bool, InstanceError>) -> Result<bool, InstanceError> {
    match found {
        Err(InstanceError::Io { source, .. }) if source.kind() == ErrorKind::NotFound => Ok(false),
        found => found,
    }
}

/// Checks that `path` is a private folder of this user.
fn check_private(path: &Path) -> Result<(), InstanceError> {
    let not_private =
        |reason: String| Err(InstanceError::NotPrivate { path: path.to_owned(), reason });
    let metadata = path.symlink_metadata().map_err(|error| io_error(path, error))?;
    if metadata.is_symlink() {
        return not_private("it is a symbolic link, not a folder".into());
    }
    if !metadata.is_dir() {
        return not_private("it is not a folder".into());
    }
    if metadata.uid() != effective_uid() {
        return not_private(format!(
            "it belongs to user {}, not to user {}",
            metadata.uid(),
            effective_uid()
        ));
    }
    let mode = metadata.mode() & 0o7777;
    if mode & 0o077 != 0 {
        return not_private(format!(
            "its mode is {mode:04o}, so other users may enter it; 0700 is needed"
        ));
    }
    Ok(())
}

/// An error if a segment with this prefix belongs to another user.
pub(crate) fn refuse_foreign_segments(prefix: &str) -> Result<(), InstanceError> {
    for segment in segments(prefix)? {
        match segment.path().symlink_metadata() {
            Ok(metadata) if metadata.uid() != effective_uid() => {
                let reason = format!("it belongs to user {}", metadata.uid());
                return Err(InstanceError::NotPrivate { path: segment.path(), reason });
            }
            _ => {}
        }
    }
    Ok(())
}

/// Removes all segments whose names begin with `prefix`. iceoryx2 itself leaves one behind for
/// each prefix.
///
/// # Errors
/// The operating system does not permit it.
pub fn remove_segments(prefix: &str) -> Result<(), InstanceError> {
    for segment in segments(prefix)? {
        unless_gone(fs::remove_file(segment.path()), &segment.path())?;
    }
    Ok(())
}

/// Removes everything in the root except the lock file.
pub(crate) fn empty_except_lock(root: &Path) -> Result<(), InstanceError> {
    for entry in entries(root)? {
        if entry.file_name() == LOCK_FILE {
            continue;
        }
        let path = entry.path();
        let is_folder = entry.file_type().map_err(|error| io_error(&path, error))?.is_dir();
        unless_gone(
            if is_folder { fs::remove_dir_all(&path) } else { fs::remove_file(&path) },
            &path,
        )?;
    }
    Ok(())
}

/// Removes the root, and the base folder if it is empty then. The lock file goes last: a process
/// that finds no lock file creates its own, and the root stays.
pub(crate) fn remove_root(root: &Path) -> Result<(), InstanceError> {
    empty_except_lock(root)?;
    let lock = root.join(LOCK_FILE);
    unless_gone(fs::remove_file(&lock), &lock)?;
    match fs::remove_dir(root) {
        Err(error) if error.kind() == ErrorKind::DirectoryNotEmpty => return Ok(()),
        removed => unless_gone(removed, root)?,
    }
    // Fails while other instances exist in the base folder, as it must.
    let _ = root.parent().map(fs::remove_dir);
    Ok(())
}

/// The names of the entries of `folder`, sorted; empty if it does not exist.
pub(crate) fn child_names(folder: &Path) -> Result<Vec<String>, InstanceError> {
    let mut names: Vec<String> =
        entries(folder)?.iter().filter_map(|entry| entry.file_name().into_string().ok()).collect();
    names.sort();
    Ok(names)
}

/// The segments whose names begin with `prefix`.
pub(crate) fn segments(prefix: &str) -> Result<Vec<DirEntry>, InstanceError> {
    let mut found = entries(Path::new(SHARED_MEMORY))?;
    found.retain(|entry| entry.file_name().to_str().is_some_and(|name| name.starts_with(prefix)));
    Ok(found)
}

fn entries(folder: &Path) -> Result<Vec<DirEntry>, InstanceError> {
    match fs::read_dir(folder) {
        Ok(read) => read.collect::<Result<_, _>>().map_err(|error| io_error(folder, error)),
        Err(error) if error.kind() == ErrorKind::NotFound => Ok(Vec::new()),
        Err(error) => Err(io_error(folder, error)),
    }
}

fn unless_gone(result: io::Result<()>, path: &Path) -> Result<(), InstanceError> {
    match result {
        Err(error) if error.kind() != ErrorKind::NotFound => Err(io_error(path, error)),
        _ => Ok(()),
    }
}

fn effective_uid() -> u32 {
    // SAFETY: geteuid has no preconditions and cannot fail.
    unsafe { libc::geteuid() }
}
