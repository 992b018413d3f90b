//! Receives all messages of a planner and its controller: for monitors and loggers.
//!
//! An observer maps the messages read-only. A slow observer misses messages; no process waits for
//! it.

use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{PortFactory, ipc};

use crate::instance::error::ChannelError;
use crate::instance::instance::Instance;
use crate::instance::participant::Participant;
use crate::instance::services::{RequestServices, Service};
use crate::instance::tuning::{STATE_BUFFER, WINDOW_CHUNKS};
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
    /// Subscribes to all services of an instance.
    ///
    /// # Errors
    /// The transport fails, or another process has another message layout.
    pub fn open(instance: &Instance) -> Result<Self, ChannelError> {
        let participant = Participant::open(instance)?;
        let making = participant.making()?;
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
        drop(making);
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

    /// The next undamaged chunk, if one arrived.
    ///
    /// # Errors
    /// The transport fails.
    pub fn chunk(&self) -> Result<Option<PlanChunk>, ChannelError> {
        next(&self.chunks, PlanChunk::crc_matches)
    }

    /// The controller's next well-formed feedback, if one arrived.
    ///
    /// # Errors
    /// The transport fails.
    pub fn feedback(&self) -> Result<Option<Feedback>, ChannelError> {
        next(&self.feedback, Feedback::is_well_formed)
    }

    /// The next well-formed status of a serving planner, if one arrived.
    ///
    /// # Errors
    /// The transport fails.
    pub fn status(&self) -> Result<Option<PlanStatus>, ChannelError> {
        next(&self.status, |status| status.known_state().is_some())
    }

    /// The simulated robot's next well-formed state, if one arrived.
    ///
    /// # Errors
    /// The transport fails.
    pub fn state(&self) -> Result<Option<SimulationState>, ChannelError> {
        next(&self.state, SimulationState::is_well_formed)
    }

    /// Number of attached planners and controllers. Killed ones count until a process cleans up.
    pub fn publisher_count(&self) -> usize {
        self.participant.chunks.dynamic_config().number_of_publishers()
            + self.participant.feedback.dynamic_config().number_of_publishers()
    }
}

/// The next message that `is_well_formed`; others are skipped.
fn next<M: Layout>(
    subscriber: &Subscriber<ipc::Service, M, ()>,
    is_well_formed: impl Fn(&M) -> bool,
) -> Result<Option<M>, ChannelError> {
    loop {
        let received =
            subscriber.receive().map_err(|error| ChannelError::transport("receiving", error))?;
        let Some(sample) = received else { return Ok(None) };
        if is_well_formed(sample.payload()) {
            return Ok(Some(*sample.payload()));
        }
    }
}
