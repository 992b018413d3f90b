//! Receives all messages of a planner and its controller: for monitors and loggers.
//!
//! An observer's mapping of the messages is read-only. One that reads too slowly misses messages;
//! no process waits for it.

use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{PortFactory, ipc};

use crate::instance::instance::Instance;
use crate::instance::participant::{
    ChannelError, Participant, RequestServices, STATE_BUFFER, Service, WINDOW_CHUNKS,
};
use crate::message::{Feedback, Layout, PlanChunk, PlanStatus, SimulationState, WithCrc};

/// Subscribers of all messages in an instance.
#[derive(Debug)]
pub struct Observer {
    chunks: Subscriber<ipc::Service, PlanChunk, ()>,
    feedback: Subscriber<ipc::Service, Feedback, ()>,
    status: Subscriber<ipc::Service, PlanStatus, ()>,
    state: Subscriber<ipc::Service, SimulationState, ()>,
    _services: RequestServices,
    _state_service: Service<SimulationState>,
    participant: Participant,
}

impl Observer {
    /// Attaches to an instance.
    ///
    /// # Errors
    /// The transport fails, or the other processes lay their messages out differently.
    pub fn open(instance: &Instance) -> Result<Self, ChannelError> {
        let participant = Participant::open(instance)?;
        let (services, state_service) =
            (participant.open_request_services()?, participant.open_state()?);
        let failed = |error| ChannelError::transport("creating a subscriber", error);
        let chunks = participant
            .chunks
            .subscriber_builder()
            .buffer_size(WINDOW_CHUNKS)
            .create()
            .map_err(failed)?;
        let feedback = participant.feedback.subscriber_builder().create().map_err(failed)?;
        let status = services.status.subscriber_builder().create().map_err(failed)?;
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
            _services: services,
            _state_service: state_service,
            participant,
        })
    }

    /// The next chunk, if one came and is undamaged.
    ///
    /// # Errors
    /// The transport fails.
    pub fn chunk(&self) -> Result<Option<PlanChunk>, ChannelError> {
        next(&self.chunks, PlanChunk::crc_matches)
    }

    /// The controller's next feedback, if one came and is well-formed.
    ///
    /// # Errors
    /// The transport fails.
    pub fn feedback(&self) -> Result<Option<Feedback>, ChannelError> {
        next(&self.feedback, Feedback::is_well_formed)
    }

    /// The next status of a planner that stays up, if one came and is well-formed.
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
    pub fn state(&self) -> Result<Option<SimulationState>, ChannelError> {
        next(&self.state, SimulationState::is_well_formed)
    }

    /// Planners and controllers attached, killed ones included until a process cleans up.
    pub fn publisher_count(&self) -> usize {
        self.participant.chunks.dynamic_config().number_of_publishers()
            + self.participant.feedback.dynamic_config().number_of_publishers()
    }
}

/// The next message that `is_sound`; others are skipped.
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
