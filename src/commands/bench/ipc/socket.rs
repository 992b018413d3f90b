//! A Unix stream socket, both sides blocking in the kernel.

use std::io::{Read, Write};
use std::os::unix::net::UnixStream;
use std::time::Duration;

use surefoot_shared_types::instance::service::CREDIT;
use surefoot_shared_types::message::{Feedback, PlanChunk};

use super::drive::{self, Far, Measured, Near, word};
use crate::failure::Failure;

/// How long the far end waits before it looks whether all is over.
const PATIENCE: Duration = Duration::from_millis(100);

/// Measures it.
pub(super) fn measure(rounds: usize) -> Result<Measured, Failure> {
    let (near, far) = UnixStream::pair().map_err(Failure::Unheard)?;
    far.set_read_timeout(Some(PATIENCE)).map_err(Failure::Unheard)?;
    let chunk = Box::new(bytemuck::Zeroable::zeroed());
    let near = || Ok(SocketNear { stream: near });
    drive::measure(rounds, CREDIT as u64, near, move || {
        Ok(SocketFar { stream: far, chunk, filled: 0, taken: 0 })
    })
}

struct SocketNear {
    stream: UnixStream,
}

impl Near for SocketNear {
    fn send(&mut self, chunk: &PlanChunk, _: u64) -> Result<(), Failure> {
        self.stream.write_all(bytemuck::bytes_of(chunk)).map_err(Failure::Unheard)
    }

    fn answered(&mut self) -> Result<u64, Failure> {
        let mut word: Feedback = bytemuck::Zeroable::zeroed();
        self.stream.read_exact(bytemuck::bytes_of_mut(&mut word)).map_err(Failure::Unheard)?;
        Ok(word.next_sequence)
    }
}

struct SocketFar {
    stream: UnixStream,
    chunk: Box<PlanChunk>,
    filled: usize,
    taken: u64,
}

impl Far for SocketFar {
    fn serve(&mut self) -> Result<(), Failure> {
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
            Err(error) => return Err(Failure::Unheard(error)),
        }
        if self.filled == bytes.len() {
            (self.filled, self.taken) = (0, self.taken + 1);
            let word = word(self.taken);
            // A near end that has left needs no answer.
            let _ = self.stream.write_all(bytemuck::bytes_of(&word));
        }
        Ok(())
    }
}
