//! The instance's iceoryx2 node and its services.
//!
//! `chunks` and `requests` never overflow: what a reader's buffer cannot take is sent again until
//! it is acknowledged. `feedback` and `status` hold the latest message only. `state` holds the last
//! ticks, the oldest of which a slow reader loses. A wake pipe for each side wakes it.

use std::time::Duration;

use iceoryx2::node::Node;
use iceoryx2::prelude::{
    AttributeVerifier, LogLevel, NodeBuilder, SignalHandlingMode, ipc, set_log_level,
};
use iceoryx2::service::attribute::{AttributeKey, AttributeValue};
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeOpenError as OpenError, PublishSubscribeOpenOrCreateError as OpenOrCreateError,
};
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use crate::instance::instance::{Instance, InstanceError};
use crate::instance::wake_pipe::WakePipe;
use crate::message::{Feedback, Layout, PlanChunk, PlanRequest, PlanStatus, SimulationState};

/// Most chunks sent and not yet acknowledged; also the size of a reader's buffer.
pub const WINDOW_CHUNKS: usize = 8;
/// Most readers of a service: the other side, and monitors and loggers.
pub const READERS_MAX: usize = 8;
/// Most messages that a reader holds at a time.
pub const BORROWED_MAX: usize = 2;
/// Slots that a sender keeps loaned ahead.
pub const LOANS_AHEAD: usize = 48;
/// Most chunks of a sender that can be in use at a time: those in all readers' buffers and hands,
/// and its loan pool.
pub const CHUNK_POOL: usize = READERS_MAX * (WINDOW_CHUNKS + BORROWED_MAX) + LOANS_AHEAD;
/// Most feedback messages of a controller that can be in use at a time: likewise, with a buffer of
/// one and a history of one.
pub const FEEDBACK_POOL: usize = READERS_MAX * (1 + BORROWED_MAX) + 1 + LOANS_AHEAD;
/// Ticks that a reader of the state may be behind before it loses the oldest.
pub const STATE_BUFFER: usize = 256;
/// Most states of a controller that can be in use at a time, likewise.
pub const STATE_POOL: usize = READERS_MAX * (STATE_BUFFER + BORROWED_MAX) + 1 + LOANS_AHEAD;
/// Most writers of a service: one, and dead ones that are not cleaned yet.
const WRITERS_MAX: usize = 8;
/// Most processes in a service, dead ones included.
const NODES_MAX: usize = 32;
/// How often opening is tried while another process creates or removes the service.
const OPEN_ATTEMPTS_MAX: usize = 20;
/// Time between two attempts.
const OPEN_PAUSE: Duration = Duration::from_millis(5);
/// The attribute that carries [`Layout::HASH`].
const LAYOUT_KEY: &str = "surefoot.layout";

/// A service of an instance.
pub type Service<M> = PortFactory<ipc::Service, M, ()>;

/// Why a channel cannot be opened or used.
#[derive(Debug, thiserror::Error)]
pub enum ChannelError {
    /// The instance is unusable.
    #[error(transparent)]
    Instance(#[from] InstanceError),
    /// The other program lays its messages out differently.
    #[error(
        "service '{service}': the other side lays its messages out differently; use the same version of surefoot on both sides"
    )]
    Layout {
        /// The service's name.
        service: String,
    },
    /// iceoryx2 cannot do what is asked.
    #[error("{action}: {reason}; run 'surefoot doctor'")]
    Transport {
        /// What was being done.
        action: String,
        /// The reason that iceoryx2 gives.
        reason: String,
    },
    /// A process gave itself the reserved id 0.
    #[error("the id 0 is reserved; use instance::random_id")]
    Id,
    /// The robot of this instance is moved by another controller.
    #[error(
        "another controller moves the robot of this instance; end it, or choose another instance name"
    )]
    Taken,
    /// The chunks handed over are not one stream.
    #[error(
        "chunk {index} of the plan does not continue the stream: same plan and epoch, sequence {index} and the digest so far are needed"
    )]
    Stream {
        /// Its place in the slice.
        index: usize,
    },
}

impl ChannelError {
    /// An error of iceoryx2 during `action`.
    pub fn transport(action: &str, reason: impl std::fmt::Debug) -> Self {
        Self::Transport { action: action.to_owned(), reason: format!("{reason:?}") }
    }
}

/// A process's participant in an instance: its iceoryx2 node and its services.
#[derive(Debug)]
pub struct Participant {
    /// Plan chunks, planner to controller.
    pub chunks: Service<PlanChunk>,
    /// The controller's latest feedback.
    pub feedback: Service<Feedback>,
    /// Notified by the planner when it has sent chunks and the controller may block.
    pub chunk_wake_pipe: WakePipe,
    /// Notified by the controller when it has sent feedback and the planner may block.
    pub feedback_wake_pipe: WakePipe,
    /// The iceoryx2 node of the process.
    pub node: Node<ipc::Service>,
    /// The instance; dropped last.
    pub instance: Instance,
}

/// The services of requests to a planner that stays up.
#[derive(Debug)]
pub struct RequestServices {
    /// Requests, client to planner.
    pub requests: Service<PlanRequest>,
    /// The planner's latest status.
    pub status: Service<PlanStatus>,
}

impl Participant {
    /// Opens both services, creating what does not exist yet.
    ///
    /// # Errors
    /// The shared memory is too small, a service has another message layout, or the transport
    /// fails.
    pub fn open(instance: &Instance) -> Result<Self, ChannelError> {
        Self::open_with_layouts(instance, PlanChunk::HASH, Feedback::HASH)
    }

    /// Like [`Self::open`], for a program with these layout hashes of [`PlanChunk`] and
    /// [`Feedback`].
    ///
    /// # Errors
    /// As [`Self::open`].
    pub fn open_with_layouts(
        instance: &Instance,
        chunk_hash: u64,
        feedback_hash: u64,
    ) -> Result<Self, ChannelError> {
        set_log_level(LogLevel::Fatal);
        instance.check_capacity()?;
        let config = instance.config()?;
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>();
        let node =
            node.map_err(|error| ChannelError::transport("creating an iceoryx2 node", error))?;
        let chunks = open_service(&node, instance, "chunks", chunk_hash, &LOSSLESS)?;
        let feedback = open_service(&node, instance, "feedback", feedback_hash, &LATEST)?;
        let chunk_wake_pipe = WakePipe::open(instance, "chunk-wake-pipe")?;
        let feedback_wake_pipe = WakePipe::open(instance, "feedback-wake-pipe")?;
        instance.reserve_segments()?;
        Ok(Self {
            chunks,
            feedback,
            chunk_wake_pipe,
            feedback_wake_pipe,
            node,
            instance: instance.clone(),
        })
    }

    /// Opens the service on which a controller publishes the simulated robot's state, creating it
    /// if it does not exist yet.
    ///
    /// # Errors
    /// The service has another message layout, or the transport fails.
    pub fn open_state(&self) -> Result<Service<SimulationState>, ChannelError> {
        open_service(&self.node, &self.instance, "state", SimulationState::HASH, &RECENT)
    }

    /// Opens the request services, creating the ones that do not exist yet.
    ///
    /// # Errors
    /// A service has another message layout, or the transport fails.
    pub fn open_request_services(&self) -> Result<RequestServices, ChannelError> {
        let requests =
            open_service(&self.node, &self.instance, "requests", PlanRequest::HASH, &LOSSLESS)?;
        let status = open_service(&self.node, &self.instance, "status", PlanStatus::HASH, &LATEST)?;
        Ok(RequestServices { requests, status })
    }
}

/// Nothing is overwritten: what finds no room is not delivered.
const LOSSLESS: Qos = Qos { overflow: false, buffer: WINDOW_CHUNKS, history: 0 };
/// The newest message replaces the one before, and waits for late readers.
const LATEST: Qos = Qos { overflow: true, buffer: 1, history: 1 };
/// The newest messages replace the oldest; the last one waits for late readers.
const RECENT: Qos = Qos { overflow: true, buffer: STATE_BUFFER, history: 1 };

struct Qos {
    overflow: bool,
    buffer: usize,
    history: usize,
}

fn open_service<M: Layout>(
    node: &Node<ipc::Service>,
    instance: &Instance,
    role: &str,
    layout_hash: u64,
    qos: &Qos,
) -> Result<Service<M>, ChannelError> {
    let name = service_name(instance, role);
    let action = format!("opening service '{name}'");
    let iox_name =
        name.as_str().try_into().map_err(|error| ChannelError::transport(&action, error))?;
    let attributes =
        layout_attribute(layout_hash).map_err(|reason| ChannelError::transport(&action, reason))?;
    let mut attempts = 0;
    loop {
        attempts += 1;
        let opened = node
            .service_builder(&iox_name)
            .publish_subscribe::<M>()
            .enable_safe_overflow(qos.overflow)
            .subscriber_max_buffer_size(qos.buffer)
            .history_size(qos.history)
            .subscriber_max_borrowed_samples(BORROWED_MAX)
            .max_subscribers(READERS_MAX)
            .max_publishers(WRITERS_MAX)
            .max_nodes(NODES_MAX)
            .open_or_create_with_attributes(&attributes);
        match opened {
            Ok(service) => return Ok(service),
            Err(OpenOrCreateError::PublishSubscribeOpenError(
                OpenError::IncompatibleAttributes | OpenError::IncompatibleTypes,
            )) => {
                return Err(ChannelError::Layout { service: name });
            }
            Err(error) if attempts == OPEN_ATTEMPTS_MAX => {
                return Err(ChannelError::transport(&action, error));
            }
            Err(_) => std::thread::sleep(OPEN_PAUSE),
        }
    }
}

fn service_name(instance: &Instance, role: &str) -> String {
    format!("surefoot/{}/{role}", instance.name())
}

fn layout_attribute(layout_hash: u64) -> Result<AttributeVerifier, String> {
    let key = AttributeKey::try_from(LAYOUT_KEY).map_err(|error| format!("{error:?}"))?;
    let value = AttributeValue::try_from(format!("{layout_hash:016x}").as_str())
        .map_err(|error| format!("{error:?}"))?;
    AttributeVerifier::new().require(&key, &value).map_err(|error| format!("{error:?}"))
}
