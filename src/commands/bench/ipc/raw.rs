//! Mapped memory and atomic counters, both sides spinning: the floor.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use memmap2::{MmapMut, MmapRaw};
use surefoot_shared_types::instance::tuning::WINDOW_CHUNKS;
use surefoot_shared_types::message::{Feedback, PlanChunk};

use crate::commands::bench::ipc::drive;
use crate::commands::bench::ipc::drive::{Far, Measured, Near, feedback};
use crate::commands::bench::ipc::integrity;
use crate::report::command_error::CommandError;

/// A slot of one message and the number of the one that it holds.
#[repr(C, align(64))]
struct Slot<M> {
    number: AtomicU64,
    message: std::cell::UnsafeCell<M>,
}

/// Both directions, in memory that was mapped for sharing.
#[repr(C)]
struct Board {
    chunks: [Slot<PlanChunk>; WINDOW_CHUNKS],
    feedback: [Slot<Feedback>; WINDOW_CHUNKS],
}

#[derive(Clone)]
struct SharedMap(Arc<MmapRaw>);

/// Measures it; `with_crc` adds the CRC and digests of our transport.
pub(crate) fn measure(rounds: usize, with_crc: bool) -> Result<Measured, CommandError> {
    let map = MmapMut::map_anon(size_of::<Board>() + 64).map_err(CommandError::ReportsClosed)?;
    let shared = SharedMap(Arc::new(MmapRaw::from(map)));
    let far = shared.clone();
    let near = || Ok(RawNear { shared, answered: 0, with_crc });
    drive::measure(rounds, WINDOW_CHUNKS as u64, near, move || {
        Ok(RawFar { shared: far, taken: 0, with_crc })
    })
}

impl SharedMap {
    fn board(&self) -> *const Board {
        let start = self.0.as_mut_ptr();
        // SAFETY: the map is 64 bytes longer than the board, so that an aligned one fits.
        unsafe { start.add(start.align_offset(64)) }.cast()
    }

    fn chunk(&self, number: u64) -> &Slot<PlanChunk> {
        // SAFETY: zeroed memory is a valid board, it is mapped as long as `self`, and all access is
        // through atomics and cells.
        unsafe { &(*self.board()).chunks[number as usize % WINDOW_CHUNKS] }
    }

    fn feedback(&self, number: u64) -> &Slot<Feedback> {
        // SAFETY: as for `chunk`.
        unsafe { &(*self.board()).feedback[number as usize % WINDOW_CHUNKS] }
    }
}

impl<M: Copy> Slot<M> {
    fn put(&self, message: &M, number: u64) {
        // SAFETY: the other side reads a slot only after its number changed, and never more than
        // `WINDOW_CHUNKS` messages are in flight, so no one reads this slot.
        unsafe { *self.message.get() = *message };
        self.number.store(number, Ordering::Release);
    }

    fn take(&self, number: u64) -> Option<M> {
        // SAFETY: the slot holds message `number`, and is written again only after this side
        // answered.
        (self.number.load(Ordering::Acquire) == number).then(|| unsafe { *self.message.get() })
    }
}

struct RawNear {
    shared: SharedMap,
    answered: u64,
    with_crc: bool,
}

impl Near for RawNear {
    fn send(&mut self, chunk: &PlanChunk, number: u64) -> Result<(), CommandError> {
        if self.with_crc {
            let mut chunk = *chunk;
            integrity::write_crc(&mut chunk);
            self.shared.chunk(number).put(&chunk, number);
        } else {
            self.shared.chunk(number).put(chunk, number);
        }
        Ok(())
    }

    fn answered(&mut self) -> Result<u64, CommandError> {
        if let Some(feedback) = self.shared.feedback(self.answered + 1).take(self.answered + 1) {
            if self.with_crc {
                std::hint::black_box(integrity::verified_digest(&feedback));
            }
            self.answered = std::hint::black_box(feedback).next_sequence;
        }
        Ok(self.answered)
    }
}

struct RawFar {
    shared: SharedMap,
    taken: u64,
    with_crc: bool,
}

impl Far for RawFar {
    fn serve(&mut self) -> Result<(), CommandError> {
        let number = self.taken + 1;
        let Some(chunk) = self.shared.chunk(number).take(number) else { return Ok(()) };
        let mut feedback = feedback(number);
        if self.with_crc {
            integrity::check(&chunk, &mut feedback);
        }
        std::hint::black_box(&chunk);
        self.shared.feedback(number).put(&feedback, number);
        self.taken = number;
        Ok(())
    }
}
