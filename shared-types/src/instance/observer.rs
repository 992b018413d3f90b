//! Receives all messages of a planner and its controller: for monitors and loggers.
//!
//! An observer maps the messages read-only. A slow observer misses messages; no process waits for
//! it.

use std::cell::RefCell;

use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::ipc;
use iceoryx2::sample::Sample;

use crate::instance::chunk_counter::ChunkCounter;
use crate::instance::error::ChannelError;
use crate::instance::instance::Instance;
use crate::instance::participant::Participant;
use crate::instance::role_publisher::{PublisherRole, RolePublisher};
use crate::instance::services::{RequestServices, Service};
use crate::instance::tuning::{STATE_BUFFER, WINDOW_CHUNKS};
use crate::message::{
    Description, Feedback, Layout, PlanChunk, PlanStatus, SetPoint, SimulationState, WithCrc,
};

/// Subscribers of all messages in an instance.
#[derive(Debug)]
pub struct Observer {
    chunks: Subscriber<ipc::Service, PlanChunk, ()>,
    feedback: Subscriber<ipc::Service, Feedback, ()>,
    status: Subscriber<ipc::Service, PlanStatus, ()>,
    state: Subscriber<ipc::Service, SimulationState, ()>,
    description: Subscriber<ipc::Service, Description, ()>,
    set_points: Subscriber<ipc::Service, SetPoint, ()>,
    planner: RefCell<RolePublisher>,
    controller: RefCell<RolePublisher>,
    counter: RefCell<ChunkCounter>,
    _services: ObservedServices,
    participant: Participant,
}

/// The services that exist as long as the observer does.
#[derive(Debug)]
struct ObservedServices {
    requests: RequestServices,
    state: Service<SimulationState>,
    description: Service<Description>,
    set_points: Service<SetPoint>,
}

impl ObservedServices {
    fn open(participant: &Participant) -> Result<Self, ChannelError> {
        Ok(Self {
            requests: participant.open_request_services()?,
            state: participant.open_state()?,
            description: participant.open_description()?,
            set_points: participant.open_set_points()?,
        })
    }
}

impl Observer {
    /// Subscribes to all services of an instance.
    ///
    /// # Errors
    /// The transport fails, or another process has another message layout.
    pub fn open(instance: &Instance) -> Result<Self, ChannelError> {
        let participant = Participant::open(instance)?;
        let making = participant.making()?;
        let services = ObservedServices::open(&participant)?;
        let chunks = subscribe(&participant.chunks, WINDOW_CHUNKS)?;
        let feedback = subscribe(&participant.feedback, 1)?;
        let status = subscribe(&services.requests.status, 1)?;
        let state = subscribe(&services.state, STATE_BUFFER)?;
        let description = subscribe(&services.description, 1)?;
        let set_points = subscribe(&services.set_points, STATE_BUFFER)?;
        drop(making);
        Ok(Self {
            chunks,
            feedback,
            status,
            state,
            description,
            set_points,
            planner: RefCell::new(RolePublisher::open(instance, PublisherRole::Planner)?),
            controller: RefCell::new(RolePublisher::open(instance, PublisherRole::Controller)?),
            counter: RefCell::default(),
            _services: services,
            participant,
        })
    }

    /// The planner's next undamaged chunk, if one arrived. Those of other publishers are skipped.
    ///
    /// # Errors
    /// The transport fails.
    pub fn chunk(&self) -> Result<Option<PlanChunk>, ChannelError> {
        let chunk = next(&self.chunks, |chunk| {
            self.planner.borrow_mut().is(chunk.origin().value()) && chunk.crc_matches()
        })?;
        let mut counter = self.counter.borrow_mut();
        match &chunk {
            Some(chunk) => counter.record(chunk),
            None => counter.settle(),
        }
        Ok(chunk)
    }

    /// The number of chunks that were sent and not received so far: those that later ones show, and
    /// those that the controller has accepted. Read feedback, then chunks until there is none.
    pub fn missed_chunks(&self) -> u64 {
        self.counter.borrow().missed()
    }

    /// The controller's next well-formed feedback, if one arrived. That of other publishers is
    /// skipped.
    ///
    /// # Errors
    /// The transport fails.
    pub fn feedback(&self) -> Result<Option<Feedback>, ChannelError> {
        let feedback = next(&self.feedback, |feedback| {
            self.controller.borrow_mut().is(feedback.origin().value()) && feedback.is_well_formed()
        })?;
        if let Some(feedback) = &feedback {
            self.counter.borrow_mut().expect(feedback);
        }
        Ok(feedback)
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
        next(&self.state, |state| state.is_well_formed())
    }

    /// The next description, if one arrived: planner and controller each publish theirs.
    ///
    /// # Errors
    /// The transport fails.
    pub fn description(&self) -> Result<Option<Description>, ChannelError> {
        next(&self.description, |description| description.is_well_formed())
    }

    /// The next well-formed set-point of a sampler, if one arrived.
    ///
    /// # Errors
    /// The transport fails.
    pub fn set_point(&self) -> Result<Option<SetPoint>, ChannelError> {
        next(&self.set_points, |set_point| set_point.is_well_formed())
    }

    /// The participant of this process in the instance.
    pub fn participant(&self) -> &Participant {
        &self.participant
    }

    /// Number of attached planners and controllers. Killed ones count until a process cleans up,
    /// publishers of other processes do not.
    pub fn publisher_count(&self) -> usize {
        self.planner.borrow().count(&self.participant.chunks)
            + self.controller.borrow().count(&self.participant.feedback)
    }
}

fn subscribe<M: Layout>(
    service: &Service<M>,
    buffer: usize,
) -> Result<Subscriber<ipc::Service, M, ()>, ChannelError> {
    service
        .subscriber_builder()
        .buffer_size(buffer)
        .create()
        .map_err(|error| ChannelError::transport("creating a subscriber", error))
}

/// The next message that `counts`; others are skipped.
fn next<M: Layout>(
    subscriber: &Subscriber<ipc::Service, M, ()>,
    counts: impl Fn(&Sample<ipc::Service, M, ()>) -> bool,
) -> Result<Option<M>, ChannelError> {
    loop {
        let received =
            subscriber.receive().map_err(|error| ChannelError::transport("receiving", error))?;
        let Some(sample) = received else { return Ok(None) };
        if counts(&sample) {
            return Ok(Some(*sample.payload()));
        }
    }
}
