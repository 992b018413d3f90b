//! Says how the simulated robot is, at every tick, for whoever listens. A slow listener loses
//! ticks; nobody waits for it.

use surefoot_shared_types::instance::service::{STATE_POOL, STOCK, Service};
use surefoot_shared_types::instance::stock::Stock;
use surefoot_shared_types::instance::{ChannelError, Link};
use surefoot_shared_types::message::State;

/// The controller's end of the state service.
pub struct StatePublisher {
    stock: Stock<State>,
    _service: Service<State>,
}

impl StatePublisher {
    /// Enters the service of an instance.
    pub(super) fn open(link: &Link) -> Result<Self, ChannelError> {
        let service = link.open_state()?;
        let publisher = service.publisher_builder().max_loaned_samples(STATE_POOL).create();
        let publisher = publisher
            .map_err(|error| ChannelError::transport("creating the state publisher", error))?;
        link.instance.reserve_segments()?;
        Ok(Self { stock: Stock::new(publisher, STATE_POOL, STOCK)?, _service: service })
    }

    /// Says how the robot is now.
    ///
    /// # Errors
    /// The transport fails.
    pub fn say(&mut self, state: &State) -> Result<(), ChannelError> {
        let sent = self.stock.take()?.write_payload(*state).send();
        sent.map(drop).map_err(|error| ChannelError::transport("sending a state", error))
    }

    /// Loans slots ahead. To be called when there is nothing else to do.
    ///
    /// # Errors
    /// The pool is used up.
    pub fn refill(&mut self) -> Result<(), ChannelError> {
        self.stock.refill(STOCK)
    }
}
