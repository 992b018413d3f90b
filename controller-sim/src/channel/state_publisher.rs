//! Publishes the state of the simulated robot at every tick. A slow subscriber loses ticks; the
//! controller does not wait for it.

use surefoot_shared_types::instance::error::ChannelError;
use surefoot_shared_types::instance::loan_pool::LoanPool;
use surefoot_shared_types::instance::participant::Participant;
use surefoot_shared_types::instance::services::Service;
use surefoot_shared_types::instance::tuning::{LOANS_AHEAD, STATE_POOL};
use surefoot_shared_types::message::SimulationState;

/// The controller's end of the state service.
pub struct StatePublisher {
    loan_pool: LoanPool<SimulationState>,
    _service: Service<SimulationState>,
}

impl StatePublisher {
    /// Joins the service of an instance.
    pub(crate) fn open(participant: &Participant) -> Result<Self, ChannelError> {
        let _making = participant.making()?;
        let service = participant.open_state()?;
        let publisher = service.publisher_builder().max_loaned_samples(STATE_POOL).create();
        let publisher = publisher
            .map_err(|error| ChannelError::transport("creating the state publisher", error))?;
        participant.instance.reserve_segments()?;
        Ok(Self {
            loan_pool: LoanPool::new(publisher, STATE_POOL, LOANS_AHEAD)?,
            _service: service,
        })
    }

    /// Publishes the robot's state.
    ///
    /// # Errors
    /// The transport fails.
    pub fn publish(&mut self, state: &SimulationState) -> Result<(), ChannelError> {
        let sent = self.loan_pool.take()?.write_payload(*state).send();
        sent.map(drop).map_err(|error| ChannelError::transport("sending a state", error))
    }

    /// Loans samples in advance. To be called while idle.
    ///
    /// # Errors
    /// The pool is used up.
    pub fn refill(&mut self) -> Result<(), ChannelError> {
        self.loan_pool.refill(LOANS_AHEAD)
    }
}
