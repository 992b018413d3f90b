//! Says how the simulated robot is: the latest value, for whoever listens.

use iceoryx2::port::publisher::Publisher;
use iceoryx2::prelude::ipc;
use surefoot_shared_types::instance::service::Service;
use surefoot_shared_types::instance::{ChannelError, Link};
use surefoot_shared_types::message::State;

/// The controller's end of the state service.
#[derive(Debug)]
pub struct StatePublisher {
    publisher: Publisher<ipc::Service, State, ()>,
    _service: Service<State>,
}

impl StatePublisher {
    /// Enters the service of an instance.
    pub(super) fn open(link: &Link) -> Result<Self, ChannelError> {
        let service = link.open_state()?;
        let publisher = service.publisher_builder().max_loaned_samples(1).create();
        let publisher = publisher.map_err(|error| ChannelError::transport("creating the state publisher", error))?;
        Ok(Self { publisher, _service: service })
    }

    /// Says how the robot is now.
    pub fn say(&self, state: &State) -> Result<(), ChannelError> {
        let sample = self.publisher.loan_uninit().map_err(|error| ChannelError::transport("loaning a state", error))?;
        sample.write_payload(*state).send().map(drop).map_err(|error| ChannelError::transport("sending a state", error))
    }
}
