//! The instance's iceoryx2 node and its services.
//!
//! `chunks` never overflows: a full buffer makes the sender wait, and what a reader's buffer cannot take is sent again
//! after the acknowledgements stall. `feedback` holds the latest word only.

use iceoryx2::node::Node;
use iceoryx2::prelude::{AttributeVerifier, LogLevel, NodeBuilder, SignalHandlingMode, ipc, set_log_level};
use iceoryx2::service::attribute::{AttributeKey, AttributeValue};
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeOpenError as OpenError, PublishSubscribeOpenOrCreateError as OpenOrCreateError,
};
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use super::{Instance, InstanceError};
use crate::message::{Feedback, Layout, PlanChunk};

/// Most chunks sent and not yet acknowledged; also the size of a reader's buffer.
pub const CREDIT: usize = 8;
/// Most readers of a service: the other side, and monitors and loggers.
const READERS_MAX: usize = 8;
/// Most writers of a service: one, and dead ones that are not cleaned yet.
const WRITERS_MAX: usize = 8;
/// Most processes in a service, dead ones included.
const NODES_MAX: usize = 32;
/// How often opening is tried while somebody else creates or removes the service.
const OPEN_ATTEMPTS_MAX: usize = 20;
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
    #[error("service '{service}': the other side lays its messages out differently; use the same version of surefoot on both sides")]
    Layout {
        /// The service's name.
        service: String,
    },
    /// iceoryx2 cannot do what is asked.
    #[error("{action}: {reason}; run 'surefoot doctor'")]
    Transport {
        /// What was being done.
        action: String,
        /// iceoryx2's words.
        reason: String,
    },
    /// A process gave itself the id that means nobody.
    #[error("0 is nobody's id; draw one with instance::draw_id")]
    Id,
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
    /// An error of iceoryx2 met while doing `action`.
    pub fn transport(action: &str, reason: impl std::fmt::Debug) -> Self {
        Self::Transport { action: action.to_owned(), reason: format!("{reason:?}") }
    }
}

/// A process's end of an instance: its node and both services.
#[derive(Debug)]
pub struct Link {
    /// Plan chunks, planner to controller.
    pub chunks: Service<PlanChunk>,
    /// The controller's latest word.
    pub feedback: Service<Feedback>,
    /// The process in iceoryx2's eyes.
    pub node: Node<ipc::Service>,
    /// Keeps the instance until all else is gone.
    _instance: Instance,
}

impl Link {
    /// Opens both services, creating what does not exist yet.
    pub fn open(instance: &Instance) -> Result<Self, ChannelError> {
        Self::open_with_layouts(instance, PlanChunk::HASH, Feedback::HASH)
    }

    /// Like [`Self::open`], for a program with these layout hashes of [`PlanChunk`] and [`Feedback`].
    pub fn open_with_layouts(instance: &Instance, chunk_hash: u64, feedback_hash: u64) -> Result<Self, ChannelError> {
        set_log_level(LogLevel::Fatal);
        let config = instance.config()?;
        let node = NodeBuilder::new().config(&config).signal_handling_mode(SignalHandlingMode::Disabled).create::<ipc::Service>();
        let node = node.map_err(|error| ChannelError::transport("creating an iceoryx2 node", error))?;
        let chunks = open_service(&node, instance, "chunks", chunk_hash, &Qos { overflow: false, buffer: CREDIT, history: 0 })?;
        let feedback = open_service(&node, instance, "feedback", feedback_hash, &Qos { overflow: true, buffer: 1, history: 1 })?;
        Ok(Self { chunks, feedback, node, _instance: instance.clone() })
    }
}

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
    let name = format!("surefoot/{}/{role}", instance.name());
    let action = format!("opening service '{name}'");
    let service_name = name.as_str().try_into().map_err(|error| ChannelError::transport(&action, error))?;
    let attributes = layout_attribute(layout_hash).map_err(|reason| ChannelError::transport(&action, reason))?;
    let mut attempts = 0;
    loop {
        attempts += 1;
        let opened = node
            .service_builder(&service_name)
            .publish_subscribe::<M>()
            .enable_safe_overflow(qos.overflow)
            .subscriber_max_buffer_size(qos.buffer)
            .history_size(qos.history)
            .subscriber_max_borrowed_samples(2)
            .max_subscribers(READERS_MAX)
            .max_publishers(WRITERS_MAX)
            .max_nodes(NODES_MAX)
            .open_or_create_with_attributes(&attributes);
        match opened {
            Ok(service) => return Ok(service),
            Err(OpenOrCreateError::PublishSubscribeOpenError(OpenError::IncompatibleAttributes | OpenError::IncompatibleTypes)) => {
                return Err(ChannelError::Layout { service: name });
            }
            Err(error) if attempts == OPEN_ATTEMPTS_MAX => return Err(ChannelError::transport(&action, error)),
            Err(_) => std::thread::sleep(std::time::Duration::from_millis(5)),
        }
    }
}

fn layout_attribute(layout_hash: u64) -> Result<AttributeVerifier, String> {
    let key = AttributeKey::try_from(LAYOUT_KEY).map_err(|error| format!("{error:?}"))?;
    let value = AttributeValue::try_from(format!("{layout_hash:016x}").as_str()).map_err(|error| format!("{error:?}"))?;
    AttributeVerifier::new().require(&key, &value).map_err(|error| format!("{error:?}"))
}
