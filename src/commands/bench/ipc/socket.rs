//! A Unix stream socket, both sides blocking in the kernel.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::time::Duration;

use surefoot_shared_types::instance::tuning::WINDOW_CHUNKS;
use surefoot_shared_types::message::{Feedback, PlanChunk};

use crate::commands::bench::ipc::drive;
use crate::commands::bench::ipc::drive::{Far, Measured, Near, feedback};
use crate::report::command_error::CommandError;

/// Time that the far end waits before it checks whether the bench is over.
const WAIT_MAX: Duration = Duration::from_millis(100);

/// Measures it.
pub(crate) fn measure(rounds: usize) -> Result<Measured, CommandError> {
    let (near, far) = UnixStream::pair().map_err(CommandError::ReportsClosed)?;
    far.set_read_timeout(Some(WAIT_MAX)).map_err(CommandError::ReportsClosed)?;
    let chunk = Box::new(bytemuck::Zeroable::zeroed());
    let near = || Ok(SocketNear { stream: near });
    drive::measure(rounds, WINDOW_CHUNKS as u64, near, move || {
        Ok(SocketFar { stream: far, chunk, filled: 0, taken: 0 })
    })
}

struct SocketNear {
    stream: UnixStream,
}

impl Near for SocketNear {
    fn send(&mut self, chunk: &PlanChunk, _: u64) -> Result<(), CommandError> {
        self.stream.write_all(bytemuck::bytes_of(chunk)).map_err(CommandError::ReportsClosed)
    }

    fn answered(&mut self) -> Result<u64, CommandError> {
        let mut feedback: Feedback = bytemuck::Zeroable::zeroed();
        self.stream
            .read_exact(bytemuck::bytes_of_mut(&mut feedback))
            .map_err(CommandError::ReportsClosed)?;
        Ok(feedback.next_sequence)
    }
}

struct SocketFar {
    stream: UnixStream,
    chunk: Box<PlanChunk>,
    filled: usize,
    taken: u64,
}

impl Far for SocketFar {
    fn serve(&mut self) -> Result<(), CommandError> {
        let bytes = bytemuck::bytes_of_mut(&mut *self.chunk);
        match self.stream.read(&mut bytes[self.filled..]) {
            Ok(read) => self.filled += read,
            Err(error)
                if matches!(
                    error.kind(),
                    std::io::ErrorKind::WouldBlock | std::io::ErrorKind::TimedOut
                ) =>
            {
                return Ok(());
            }
            Err(error) => return Err(CommandError::ReportsClosed(error)),
        }
        if self.filled == bytes.len() {
            (self.filled, self.taken) = (0, self.taken + 1);
            let feedback = feedback(self.taken);
            // A near end that has left needs no answer.
            let _ = self.stream.write_all(bytemuck::bytes_of(&feedback));
        }
        Ok(())
    }
}
