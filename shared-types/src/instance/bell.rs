//! A bell: wakes a process that waits for the other side, without a look at the clock in between.
//!
//! Nothing depends on it. Whoever waits does so for a bounded time and then looks for itself, so a
//! ring that is lost, or rung by a stranger, costs a moment and no more. It is a named pipe in the
//! instance's folder: iceoryx2's listeners are sockets whose paths may have 107 bytes only, which
//! an instance's name and folder would not leave.

use std::ffi::CString;
use std::fs::{File, OpenOptions};
use std::io::{self, Read, Write};
use std::os::fd::AsRawFd;
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt};
use std::path::Path;
use std::time::Duration;

use super::directory::io_error;
use super::{Instance, InstanceError};

/// How long whoever waits looks for itself before it sleeps until the bell.
const LOOK_FOR: Duration = Duration::from_micros(500);
/// How long it does so without giving way to whoever else needs its core.
const SPIN_FOR: Duration = Duration::from_micros(50);
/// Whoever was spoken to so recently still looks for itself; later it may sleep, and is to be
/// woken.
pub const AWAKE_FOR: Duration = Duration::from_micros(250);

/// Waits a moment and stays awake; `false` where nothing happened for so long, `idle`, that it is
/// time to sleep until the bell.
pub fn stay_awake(idle: Duration) -> bool {
    match idle {
        _ if idle < SPIN_FOR => std::hint::spin_loop(),
        _ if idle < LOOK_FOR => std::thread::yield_now(),
        _ => return false,
    }
    true
}

/// A bell of an instance. One process hears it, any may ring it.
#[derive(Debug)]
pub struct Bell {
    pipe: File,
}

impl Bell {
    /// Opens the bell called `name`, creating it if it does not exist yet.
    pub(super) fn open(instance: &Instance, name: &str) -> Result<Self, InstanceError> {
        let path = instance.root().join(name);
        let failed = |error| io_error(&path, error);
        make_pipe(&path).map_err(failed)?;
        // Open for both, so that it neither waits for the other side nor ends with it.
        let flags = libc::O_NONBLOCK | libc::O_NOFOLLOW;
        let pipe = OpenOptions::new()
            .read(true)
            .write(true)
            .custom_flags(flags)
            .open(&path)
            .map_err(failed)?;
        if !pipe.metadata().map_err(failed)?.file_type().is_fifo() {
            return Err(InstanceError::Squatted { path, reason: "it is not a pipe".into() });
        }
        Ok(Self { pipe })
    }

    /// Wakes whoever waits. It need not be heard.
    pub fn ring(&self) {
        let _ = (&self.pipe).write(&[1]);
    }

    /// Waits until the bell rings, a signal comes, or as long as `longest`.
    pub fn wait(&self, longest: Duration) {
        let mut looked_at =
            libc::pollfd { fd: self.pipe.as_raw_fd(), events: libc::POLLIN, revents: 0 };
        let seconds = libc::time_t::try_from(longest.as_secs()).unwrap_or(libc::time_t::MAX);
        let timeout = libc::timespec {
            tv_sec: seconds,
            tv_nsec: libc::c_long::from(longest.subsec_nanos() as i32),
        };
        // SAFETY: both pointers outlive the call, and one descriptor is named.
        let ready = unsafe { libc::ppoll(&mut looked_at, 1, &timeout, std::ptr::null()) };
        if ready > 0 {
            let _ = (&self.pipe).read(&mut [0; 64]);
        }
    }
}

fn make_pipe(path: &Path) -> io::Result<()> {
    let path = CString::new(path.as_os_str().as_bytes())?;
    // SAFETY: the path outlives the call.
    if unsafe { libc::mkfifo(path.as_ptr(), 0o600) } == 0 {
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
    fn a_ring_before_or_during_the_wait_ends_it() {
        let base = tempfile::tempdir_in("/dev/shm").unwrap();
        let instance = Instance::create_in(&base.path().join("base"), "bell").unwrap();
        let (ear, hand) =
            (Bell::open(&instance, "a-bell").unwrap(), Bell::open(&instance, "a-bell").unwrap());
        hand.ring();
        ear.wait(Duration::from_secs(60));
        std::thread::scope(|scope| {
            scope.spawn(|| {
                std::thread::sleep(Duration::from_millis(20));
                hand.ring();
            });
            ear.wait(Duration::from_secs(60));
        });
        ear.wait(Duration::from_millis(1));
        (0..100_000).for_each(|_| hand.ring());
        ear.wait(Duration::from_secs(60));
    }

    #[test]
    fn a_file_in_its_place_is_refused() {
        let base = tempfile::tempdir_in("/dev/shm").unwrap();
        let instance = Instance::create_in(&base.path().join("base"), "bell").unwrap();
        std::fs::write(instance.root().join("a-bell"), "").unwrap();
        assert!(matches!(Bell::open(&instance, "a-bell"), Err(InstanceError::Squatted { .. })));
    }
}
