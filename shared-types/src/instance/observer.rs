//! Listens to a pair without taking part: for monitors and loggers.
//!
//! An observer's mapping of the messages is read-only. One that reads too slowly misses messages;
//! nobody waits for it.

use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{PortFactory, ipc};

use super::Instance;
use super::service::{CREDIT, ChannelError, Desk, Link, STATE_BUFFER, Service};
use crate::message::{Feedback, Layout, PlanChunk, PlanStatus, Sealed, State};

/// Hears everything that passes in an instance.
#[derive(Debug)]
pub struct Observer {
    chunks: Subscriber<ipc::Service, PlanChunk, ()>,
    feedback: Subscriber<ipc::Service, Feedback, ()>,
    status: Subscriber<ipc::Service, PlanStatus, ()>,
    state: Subscriber<ipc::Service, State, ()>,
    _desk: Desk,
    _state_service: Service<State>,
    link: Link,
}

impl Observer {
    /// Attaches to an instance.
    ///
    /// # Errors
    /// The transport fails, or the other processes lay their messages out differently.
    pub fn open(instance: &Instance) -> Result<Self, ChannelError> {
        let link = Link::open(instance)?;
        let (desk, state_service) = (link.open_desk()?, link.open_state()?);
        let failed = |error| ChannelError::transport("creating a subscriber", error);
        let chunks =
            link.chunks.subscriber_builder().buffer_size(CREDIT).create().map_err(failed)?;
        let feedback = link.feedback.subscriber_builder().create().map_err(failed)?;
        let status = desk.status.subscriber_builder().create().map_err(failed)?;
        let state = state_service
            .subscriber_builder()
            .buffer_size(STATE_BUFFER)
            .create()
            .map_err(failed)?;
        Ok(Self {
            chunks,
            feedback,
            status,
            state,
            _desk: desk,
            _state_service: state_service,
            link,
        })
    }

    /// The next chunk, if one came and is undamaged.
    ///
    /// # Errors
    /// The transport fails.
    pub fn chunk(&self) -> Result<Option<PlanChunk>, ChannelError> {
        next(&self.chunks, PlanChunk::is_intact)
    }

    /// The controller's next word, if one came and is well-formed.
    ///
    /// # Errors
    /// The transport fails.
    pub fn feedback(&self) -> Result<Option<Feedback>, ChannelError> {
        next(&self.feedback, Feedback::is_well_formed)
    }

    /// The next word of a planner that stays up, if one came and is well-formed.
    ///
    /// # Errors
    /// The transport fails.
    pub fn status(&self) -> Result<Option<PlanStatus>, ChannelError> {
        next(&self.status, |status| status.known_state().is_some())
    }

    /// The simulated robot's next state, if one came and is well-formed.
    ///
    /// # Errors
    /// The transport fails.
    pub fn state(&self) -> Result<Option<State>, ChannelError> {
        next(&self.state, State::is_well_formed)
    }

    /// Planners and controllers attached, killed ones included until somebody cleans up.
    pub fn speakers(&self) -> usize {
        self.link.chunks.dynamic_config().number_of_publishers()
            + self.link.feedback.dynamic_config().number_of_publishers()
    }
}

/// The next message that `is_sound`; others are passed over.
fn next<M: Layout>(
    subscriber: &Subscriber<ipc::Service, M, ()>,
    is_sound: impl Fn(&M) -> bool,
) -> Result<Option<M>, ChannelError> {
    loop {
        let received =
            subscriber.receive().map_err(|error| ChannelError::transport("receiving", error))?;
        let Some(sample) = received else { return Ok(None) };
        if is_sound(sample.payload()) {
            return Ok(Some(*sample.payload()));
        }
    }
}
