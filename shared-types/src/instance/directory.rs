//! The root folder of an instance, and the shared-memory segments of iceoryx2 in `/dev/shm`.

use std::fs;
use std::fs::DirEntry;
use std::io;
use std::io::ErrorKind;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use crate::base::user::effective_uid;
use crate::instance::error::{InstanceError, SHARED_MEMORY, io_error};
use crate::instance::lock::LOCK_FILE;

/// Removes all segments of this user whose names begin with `prefix`. iceoryx2 itself leaves one
/// behind for each prefix.
///
/// # Errors
/// The operating system does not permit it.
pub fn remove_segments(prefix: &str) -> Result<(), InstanceError> {
    for segment in segments(prefix)? {
        unless_gone(fs::remove_file(&segment), &segment)?;
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

/// The segments of this user whose names begin with `prefix`. Files of other users do not matter:
/// none can have the name of a segment that iceoryx2 has yet to make, because that holds an id that
/// they cannot know.
pub(crate) fn segments(prefix: &str) -> Result<Vec<PathBuf>, InstanceError> {
    let has_prefix =
        |entry: &DirEntry| entry.file_name().to_str().is_some_and(|name| name.starts_with(prefix));
    let is_ours = |path: &PathBuf| {
        path.symlink_metadata().is_ok_and(|metadata| metadata.uid() == effective_uid())
    };
    let found = entries(Path::new(SHARED_MEMORY))?;
    Ok(found.iter().filter(|entry| has_prefix(entry)).map(DirEntry::path).filter(is_ours).collect())
}

/// Whether a name in shared memory that begins with `prefix`, of any user, has more than
/// `bytes_max` bytes. An error counts as none, and shows where segments are opened.
pub(crate) fn has_longer_name(prefix: &str, bytes_max: usize) -> bool {
    let is_longer = |entry: &DirEntry| {
        let name = entry.file_name();
        name.len() > bytes_max && name.as_encoded_bytes().starts_with(prefix.as_bytes())
    };
    entries(Path::new(SHARED_MEMORY)).is_ok_and(|entries| entries.iter().any(is_longer))
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
