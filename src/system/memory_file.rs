//! Files in memory that processes hand on by descriptor: nothing of them stays when all have ended.

use std::fs::File;
use std::io;
use std::os::fd::{AsRawFd, FromRawFd};

/// An empty file in memory. Processes that this one starts inherit it if `is_inherited`.
///
/// # Errors
/// The system permits no more files or memory.
pub fn create(is_inherited: bool) -> io::Result<File> {
    let flags = if is_inherited { 0 } else { libc::MFD_CLOEXEC };
    // SAFETY: the name is a C string that outlives the call.
    let descriptor = unsafe { libc::memfd_create(c"surefoot".as_ptr(), flags) };
    if descriptor < 0 {
        return Err(io::Error::last_os_error());
    }
    // SAFETY: the descriptor is new, and no one else owns it.
    Ok(unsafe { File::from_raw_fd(descriptor) })
}

/// The same file, opened anew: with a position of its own, at the beginning.
///
/// # Errors
/// The system permits no more files.
pub fn reopen(file: &File) -> io::Result<File> {
    File::open(format!("/proc/self/fd/{}", file.as_raw_fd()))
}
