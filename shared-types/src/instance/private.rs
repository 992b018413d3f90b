//! Private folders and files: opened without following links and without waiting, then checked.

use std::fs::{DirBuilder, File, OpenOptions, Permissions};
use std::io::ErrorKind;
use std::os::unix::fs::{DirBuilderExt, MetadataExt, OpenOptionsExt, PermissionsExt};
use std::path::Path;

use crate::base::user::effective_uid;
use crate::instance::error::{InstanceError, io_error};

/// Mode of a private folder.
const FOLDER_MODE: u32 = 0o700;
/// Mode of a private file.
const FILE_MODE: u32 = 0o600;

/// Creates a folder with mode 0700, or checks that an existing one is private to this user. `false`
/// if it existed and another process removed it before the check.
pub(crate) fn ensure_folder(path: &Path) -> Result<bool, InstanceError> {
    match DirBuilder::new().mode(FOLDER_MODE).create(path) {
        // The process's umask may have removed rights of its own user.
        Ok(()) => unless_missing(
            std::fs::set_permissions(path, Permissions::from_mode(FOLDER_MODE))
                .map(|()| true)
                .map_err(|error| io_error(path, error)),
        ),
        Err(error) if error.kind() == ErrorKind::AlreadyExists => is_ours(path),
        Err(error) => Err(io_error(path, error)),
    }
}

/// As [`ensure_folder`] for a folder in the base; `false` also if another process removed the base
/// in between.
pub(crate) fn ensure_root(root: &Path) -> Result<bool, InstanceError> {
    unless_missing(ensure_folder(root))
}

/// Whether `path` exists; an error if it is not a private folder of this user.
pub(crate) fn is_ours(path: &Path) -> Result<bool, InstanceError> {
    unless_missing(check_folder(path).map(|()| true))
}

/// `false` instead of the error that a file does not exist.
fn unless_missing(found: Result<bool, InstanceError>) -> Result<bool, InstanceError> {
    match found {
        Err(InstanceError::Io { source, .. }) if source.kind() == ErrorKind::NotFound => Ok(false),
        found => found,
    }
}

/// Checks the open folder at `path`: owner and mode.
fn check_folder(path: &Path) -> Result<(), InstanceError> {
    let flags = libc::O_PATH | libc::O_DIRECTORY | libc::O_NOFOLLOW;
    let folder = match OpenOptions::new().read(true).custom_flags(flags).open(path) {
        Ok(folder) => folder,
        Err(error) if error.kind() == ErrorKind::NotADirectory => {
            let is_link = path.symlink_metadata().is_ok_and(|metadata| metadata.is_symlink());
            let reason =
                if is_link { "it is a symbolic link, not a folder" } else { "it is not a folder" };
            return Err(not_private(path, reason.into()));
        }
        Err(error) => return Err(io_error(path, error)),
    };
    let metadata = folder.metadata().map_err(|error| io_error(path, error))?;
    check_owner(path, metadata.uid())?;
    let mode = metadata.mode() & 0o7777;
    if mode & 0o077 != 0 {
        let reason = format!("its mode is {mode:04o}, so other users may enter it; 0700 is needed");
        return Err(not_private(path, reason));
    }
    Ok(())
}

/// Opens a regular file of this user for reading and writing; creates it with mode 0600 if `create`
/// says so. `None` if it does not exist.
///
/// Neither a link is followed nor a pipe or a device waited for.
pub(crate) fn open_file(path: &Path, create: bool) -> Result<Option<File>, InstanceError> {
    let opened = OpenOptions::new()
        .read(true)
        .write(true)
        .create(create)
        .truncate(false)
        .mode(FILE_MODE)
        .custom_flags(libc::O_NOFOLLOW | libc::O_NONBLOCK)
        .open(path);
    let file = match opened {
        Ok(file) => file,
        Err(error) if error.kind() == ErrorKind::NotFound => return Ok(None),
        Err(error) if error.raw_os_error() == Some(libc::ENXIO) => {
            return Err(not_private(path, "it is a socket or a device, not a file".into()));
        }
        Err(error) => return Err(io_error(path, error)),
    };
    let metadata = file.metadata().map_err(|error| io_error(path, error))?;
    if !metadata.is_file() {
        return Err(not_private(path, "it is not a regular file".into()));
    }
    check_owner(path, metadata.uid())?;
    if metadata.mode() & 0o777 != FILE_MODE {
        file.set_permissions(Permissions::from_mode(FILE_MODE))
            .map_err(|error| io_error(path, error))?;
    }
    Ok(Some(file))
}

fn check_owner(path: &Path, owner: u32) -> Result<(), InstanceError> {
    if owner == effective_uid() {
        return Ok(());
    }
    let reason = format!("it belongs to user {owner}, not to user {}", effective_uid());
    Err(not_private(path, reason))
}

/// The error that `path` is not private.
pub(crate) fn not_private(path: &Path, reason: String) -> InstanceError {
    InstanceError::NotPrivate { path: path.to_owned(), reason }
}
