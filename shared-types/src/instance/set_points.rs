//! Publishes set-points. A slow subscriber loses the oldest; the sampler does not wait for it.

use crate::instance::error::ChannelError;
use crate::instance::loan_pool::LoanPool;
use crate::instance::participant::Participant;
use crate::instance::services::Service;
use crate::instance::tuning::{LOANS_AHEAD, STATE_POOL};
use crate::message::SetPoint;

/// The sampler's end of the service of set-points.
pub struct SetPointPublisher {
    loan_pool: LoanPool<SetPoint>,
    _service: Service<SetPoint>,
}

impl SetPointPublisher {
    /// Joins the service of an instance.
    ///
    /// # Errors
    /// Shared memory is full, the service has another message layout, or the transport fails.
    pub fn open(participant: &Participant) -> Result<Self, ChannelError> {
        let _making = participant.making()?;
        let service = participant.open_set_points()?;
        let publisher = service.publisher_builder().max_loaned_samples(STATE_POOL).create();
        let publisher = publisher
            .map_err(|error| ChannelError::transport("creating the set-point publisher", error))?;
        participant.instance.reserve_segments()?;
        Ok(Self {
            loan_pool: LoanPool::new(publisher, STATE_POOL, LOANS_AHEAD)?,
            _service: service,
        })
    }

    /// Publishes a set-point.
    ///
    /// # Errors
    /// The transport fails.
    pub fn publish(&mut self, point: &SetPoint) -> Result<(), ChannelError> {
        let sent = self.loan_pool.take()?.write_payload(*point).send();
        sent.map(drop).map_err(|error| ChannelError::transport("sending a set-point", error))
    }

    /// Loans samples in advance. Call it while idle.
    ///
    /// # Errors
    /// The pool is used up.
    pub fn refill(&mut self) -> Result<(), ChannelError> {
        self.loan_pool.refill(LOANS_AHEAD)
    }
}
