//! The wake pipe: a FIFO that wakes a process blocked on its peer.
//!
//! Correctness does not depend on it. A reader blocks for a bounded time and then polls the
//! service, so a lost or unrelated notification costs at most that time. The pipe is a FIFO in the
//! instance's folder: the path of an iceoryx2 listener's socket is limited to 107 bytes, too few
//! for an instance's folder and name.

use std::ffi::CString;
use std::fs::{File, OpenOptions};
use std::io;
use std::io::{Read, Write};
use std::os::fd::AsRawFd;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::path::Path;
use std::time::Duration;

use crate::instance::error::{InstanceError, io_error};
use crate::instance::instance::Instance;
use crate::instance::tuning::{POLLING_TIME, SPINNING_TIME};

/// Waits briefly without blocking: spins, later yields the core. `idle` is the time since the last
/// message. `false` once it exceeds the polling time: the caller then blocks on the wake pipe.
pub fn keep_polling(idle: Duration) -> bool {
    match idle {
        _ if idle < SPINNING_TIME => std::hint::spin_loop(),
        _ if idle < POLLING_TIME => std::thread::yield_now(),
        _ => return false,
    }
    true
}

/// A wake pipe of an instance. One process waits on it; any process may notify it.
#[derive(Debug)]
pub struct WakePipe {
    pipe: File,
}

impl WakePipe {
    /// Opens the wake pipe called `name`; creates it if it does not exist.
    pub(crate) fn open(instance: &Instance, name: &str) -> Result<Self, InstanceError> {
        let path = instance.root().join(name);
        let failed = |error| io_error(&path, error);
        make_pipe(&path).map_err(failed)?;
        // Open for reading and writing, so that neither opening nor reading depends on the peer.
        let flags = libc::O_NONBLOCK | libc::O_NOFOLLOW;
        let pipe = OpenOptions::new()
            .read(true)
            .write(true)
            .custom_flags(flags)
            .open(&path)
            .map_err(failed)?;
        if !pipe.metadata().map_err(failed)?.file_type().is_fifo() {
            return Err(InstanceError::NotPrivate { path, reason: "it is not a pipe".into() });
        }
        Ok(Self { pipe })
    }

    /// Wakes the reader, if one waits.
    pub fn notify(&self) {
        let _ = (&self.pipe).write(&[1]);
    }

    /// Waits until a notification or a signal arrives, at most `timeout_max`.
    pub fn wait(&self, timeout_max: Duration) {
        let mut poll_descriptor =
            libc::pollfd { fd: self.pipe.as_raw_fd(), events: libc::POLLIN, revents: 0 };
        let seconds = libc::time_t::try_from(timeout_max.as_secs()).unwrap_or(libc::time_t::MAX);
        let timeout = libc::timespec {
            tv_sec: seconds,
            tv_nsec: libc::c_long::from(timeout_max.subsec_nanos() as i32),
        };
        // SAFETY: both pointers outlive the call, and one descriptor is named.
        let ready = unsafe { libc::ppoll(&mut poll_descriptor, 1, &timeout, std::ptr::null()) };
        if ready > 0 {
            let _ = (&self.pipe).read(&mut [0; 64]);
        }
    }
}

fn make_pipe(path: &Path) -> io::Result<()> {
    let path = CString::new(path.as_os_str().as_bytes())?;
    // SAFETY: the path outlives the call.
    if unsafe { libc::mkfifo(path.as_ptr(), 0o600) } == 0 {
        // The process's umask may have removed rights of its own user.
        // SAFETY: as above.
        unsafe { libc::chmod(path.as_ptr(), 0o600) };
        return Ok(());
    }
    match io::Error::last_os_error() {
        error if error.kind() == io::ErrorKind::AlreadyExists => Ok(()),
        error => Err(error),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_notification_before_or_during_the_wait_ends_it() {
        let base = tempfile::tempdir_in("/dev/shm").unwrap();
        let instance = Instance::create_in(&base.path().join("base"), "wake-pipe").unwrap();
        let (reader, writer) = (
            WakePipe::open(&instance, "a-pipe").unwrap(),
            WakePipe::open(&instance, "a-pipe").unwrap(),
        );
        writer.notify();
        reader.wait(Duration::from_secs(60));
        std::thread::scope(|scope| {
            scope.spawn(|| {
                std::thread::sleep(Duration::from_millis(20));
                writer.notify();
            });
            reader.wait(Duration::from_secs(60));
        });
        reader.wait(Duration::from_millis(1));
        (0..100_000).for_each(|_| writer.notify());
        reader.wait(Duration::from_secs(60));
    }

    #[test]
    fn a_regular_file_is_refused() {
        let base = tempfile::tempdir_in("/dev/shm").unwrap();
        let instance = Instance::create_in(&base.path().join("base"), "wake-pipe").unwrap();
        std::fs::write(instance.root().join("a-pipe"), "").unwrap();
        assert!(matches!(
            WakePipe::open(&instance, "a-pipe"),
            Err(InstanceError::NotPrivate { .. })
        ));
    }
}
