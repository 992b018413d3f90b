//! A thread that removes unfinished connections of killed processes.
//!
//! A running process opens the connections that a new peer makes, in the middle of sending and
//! receiving. If the peer is killed before it has set a connection's size, iceoryx2 waits for that
//! size without limit. This thread removes the connection, which ends the wait.

use std::sync::{Arc, Condvar, Mutex, PoisonError};
use std::thread::JoinHandle;

use crate::instance::error::{InstanceError, io_error};
use crate::instance::instance::Instance;
use crate::instance::tuning::{UNFINISHED_AGE_MIN, WATCH_STACK_BYTES};
use crate::instance::unfinished::{self, Unfinished};

/// The running thread. Dropped, it ends the thread.
#[derive(Debug)]
pub(crate) struct UnfinishedWatch {
    end: Arc<(Mutex<bool>, Condvar)>,
    thread: Option<JoinHandle<()>>,
}

impl UnfinishedWatch {
    /// Starts the thread for the segments of an instance.
    pub(crate) fn start(instance: &Instance) -> Result<Self, InstanceError> {
        let end = Arc::new((Mutex::new(false), Condvar::new()));
        let (prefix, thread_end) = (instance.segment_prefix().to_owned(), end.clone());
        let thread = std::thread::Builder::new()
            .name("unfinished".into())
            .stack_size(WATCH_STACK_BYTES)
            .spawn(move || {
                block_signals();
                watch(&prefix, &thread_end);
            })
            .map_err(|error| io_error(instance.root(), error))?;
        Ok(Self { end, thread: Some(thread) })
    }
}

/// Removes every connection that two consecutive scans find unfinished, until `end` is set.
fn watch(prefix: &str, (end, changed): &(Mutex<bool>, Condvar)) {
    let mut known = Unfinished::new();
    let mut is_over = end.lock().unwrap_or_else(PoisonError::into_inner);
    while !*is_over {
        let waited = changed.wait_timeout(is_over, UNFINISHED_AGE_MIN);
        is_over = waited.unwrap_or_else(PoisonError::into_inner).0;
        let current = unfinished::connections(prefix);
        known.retain(|inode| current.contains(inode));
        if !known.is_empty() {
            unfinished::remove_connections(prefix, &known);
        }
        known = current;
    }
}

/// Leaves the signals of the process to its other threads.
fn block_signals() {
    // SAFETY: all-zero bytes are a valid set, and both pointers outlive the calls.
    unsafe {
        let mut all: libc::sigset_t = std::mem::zeroed();
        libc::sigfillset(&mut all);
        libc::pthread_sigmask(libc::SIG_BLOCK, &all, std::ptr::null_mut());
    }
}

impl Drop for UnfinishedWatch {
    fn drop(&mut self) {
        *self.end.0.lock().unwrap_or_else(PoisonError::into_inner) = true;
        self.end.1.notify_all();
        // The thread ends by itself; a panic in it is not passed on.
        let _ = self.thread.take().map(JoinHandle::join);
    }
}
