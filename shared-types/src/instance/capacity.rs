//! Capacity of shared memory. A process that accesses a page when shared memory is full ends with
//! SIGBUS. So free space is checked before anything is opened, and every page is allocated right
//! after.

use std::ffi::CString;
use std::fs::OpenOptions;
use std::io;
use std::os::fd::AsRawFd;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{MetadataExt, OpenOptionsExt};
use std::path::Path;

use crate::instance::error::{InstanceError, io_error};
use crate::instance::tuning::NEEDED_KIB;
use crate::instance::unfinished::is_unfinished;

/// Checks that the file system of `path` has [`NEEDED_KIB`] free, enough for one more process.
pub(crate) fn check(path: &Path) -> Result<(), InstanceError> {
    match free_kib(path) {
        Some(free_kib) if free_kib < NEEDED_KIB => {
            Err(InstanceError::Full { free_kib, needed_kib: NEEDED_KIB })
        }
        _ => Ok(()),
    }
}

/// Allocates all pages of a segment. Its content and its mode stay. No error if the segment does
/// not exist. A segment that its process has not finished is left to that process.
pub(crate) fn reserve(segment: &Path) -> Result<(), InstanceError> {
    let opened =
        OpenOptions::new().read(true).write(true).custom_flags(libc::O_NOFOLLOW).open(segment);
    let file = match opened {
        Ok(file) => file,
        // Missing, or not finished: write-only.
        Err(error)
            if matches!(
                error.kind(),
                io::ErrorKind::NotFound | io::ErrorKind::PermissionDenied
            ) =>
        {
            return Ok(());
        }
        Err(error) => return Err(io_error(segment, error)),
    };
    let metadata = file.metadata().map_err(|error| io_error(segment, error))?;
    let length = metadata.len();
    if is_unfinished(length, metadata.mode()) {
        return Ok(());
    }
    let Ok(length) = libc::off_t::try_from(length) else { return Ok(()) };
    // SAFETY: the descriptor is open, and the call touches no memory of this process.
    match unsafe { libc::posix_fallocate(file.as_raw_fd(), 0, length) } {
        0 => Ok(()),
        libc::ENOSPC => Err(InstanceError::Full {
            free_kib: free_kib(segment).unwrap_or(0),
            needed_kib: length.unsigned_abs() / 1024,
        }),
        libc::EOPNOTSUPP | libc::EINVAL => Ok(()),
        code => Err(io_error(segment, io::Error::from_raw_os_error(code))),
    }
}

/// Free space of the file system of `path`, KiB; `None` if the system does not report it.
fn free_kib(path: &Path) -> Option<u64> {
    let path = CString::new(path.as_os_str().as_bytes()).ok()?;
    // SAFETY: all-zero bytes are a valid statvfs.
    let mut stat: libc::statvfs = unsafe { std::mem::zeroed() };
    // SAFETY: both pointers outlive the call.
    let result = unsafe { libc::statvfs(path.as_ptr(), &mut stat) };
    let kib = (u128::from(stat.f_bavail) * u128::from(stat.f_frsize)) >> 10;
    (result == 0).then(|| u64::try_from(kib).unwrap_or(u64::MAX))
}
