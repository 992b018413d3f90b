//! A pool of messages in shared memory, loaned before they are needed. Loaning a message allocates,
//! writing and sending it does not.

use std::mem::MaybeUninit;

use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::ipc;
use iceoryx2::sample_mut_uninit::SampleMutUninit;

use crate::instance::error::ChannelError;
use crate::message::Layout;

/// A loaned message that is not written yet.
pub type Slot<M> = SampleMutUninit<ipc::Service, MaybeUninit<M>, ()>;

/// A publisher with a pool of loaned slots.
pub struct LoanPool<M: Layout> {
    slots: Vec<Slot<M>>,
    publisher: Publisher<ipc::Service, M, ()>,
}

impl<M: Layout> LoanPool<M> {
    /// Loans and writes `pool` slots, so that the first access of each page happens here, and keeps
    /// `len` of them loaned. The publisher's limit of loans must be at least `pool`.
    ///
    /// # Errors
    /// The publisher cannot loan `pool` slots.
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

    /// The id of the publisher, as the readers of its messages see it.
    pub fn publisher_id(&self) -> u128 {
        self.publisher.id().value()
    }

    /// Takes a slot of the pool, or a new loan if the pool is empty.
    ///
    /// # Errors
    /// The publisher cannot loan another slot.
    pub fn take(&mut self) -> Result<Slot<M>, ChannelError> {
        match self.slots.pop() {
            Some(slot) => Ok(slot),
            None => loan(&self.publisher),
        }
    }

    /// Fills the pool up to `len` slots. It allocates: call it while idle.
    ///
    /// # Errors
    /// The publisher cannot loan another slot.
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
