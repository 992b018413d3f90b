//! Slots of shared memory that are loaned before they are needed: loaning one costs an allocation,
//! using it costs none.

use std::mem::MaybeUninit;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::ipc;
use iceoryx2::sample_mut_uninit::SampleMutUninit;

use crate::instance::participant::ChannelError;
use crate::message::Layout;

/// A slot that was loaned and not written yet.
pub type Slot<M> = SampleMutUninit<ipc::Service, MaybeUninit<M>, ()>;

/// A publisher with a pool of loaned slots.
pub struct LoanPool<M: Layout> {
    slots: Vec<Slot<M>>,
    publisher: Publisher<ipc::Service, M, ()>,
}

impl<M: Layout> LoanPool<M> {
    /// Touches `pool` slots, so that no page is touched for the first time later, and keeps `len`
    /// of them loaned. The publisher must be allowed to loan `pool` slots at a time.
    ///
    /// # Errors
    /// The publisher has not so many.
    pub fn new(
        publisher: Publisher<ipc::Service, M, ()>,
        pool: usize,
        len: usize,
    ) -> Result<Self, ChannelError> {
        let mut slots = Vec::with_capacity(pool);
        for _ in 0..pool {
            let mut slot = loan(&publisher)?;
            *slot.payload_mut() = MaybeUninit::zeroed();
            slots.push(slot);
        }
        slots.truncate(len);
        Ok(Self { slots, publisher })
    }

    /// A slot of the pool, or a new loan if the pool is empty.
    ///
    /// # Errors
    /// The pool is used up.
    pub fn take(&mut self) -> Result<Slot<M>, ChannelError> {
        match self.slots.pop() {
            Some(slot) => Ok(slot),
            None => loan(&self.publisher),
        }
    }

    /// Fills the pool up to `len` slots again. Call it while idle.
    ///
    /// # Errors
    /// The pool is used up.
    pub fn refill(&mut self, len: usize) -> Result<(), ChannelError> {
        while self.slots.len() < len {
            self.slots.push(loan(&self.publisher)?);
        }
        Ok(())
    }
}

fn loan<M: Layout>(publisher: &Publisher<ipc::Service, M, ()>) -> Result<Slot<M>, ChannelError> {
    publisher.loan_uninit().map_err(|error| ChannelError::transport("loaning shared memory", error))
}
