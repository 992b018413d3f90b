//! The iceoryx2 services of an instance.
//!
//! `chunks` and `requests` never overflow: a message that does not fit a subscriber's buffer is
//! sent again until it is acknowledged. `feedback` and `status` hold the latest message only.
//! `state` holds the last ticks; a slow subscriber loses the oldest.

use iceoryx2::node::Node;
use iceoryx2::prelude::{AttributeVerifier, ipc};
use iceoryx2::service::attribute::{AttributeKey, AttributeValue};
use iceoryx2::service::builder::publish_subscribe::{
    PublishSubscribeOpenError as OpenError, PublishSubscribeOpenOrCreateError as OpenOrCreateError,
};
use iceoryx2::service::port_factory::publish_subscribe::PortFactory;

use crate::instance::error::ChannelError;
use crate::instance::instance::Instance;
use crate::instance::tuning::{
    BORROWED_MAX, CLIENTS_AT_ONCE_MAX, NODES_MAX, OPEN_ATTEMPTS_MAX, OPEN_PAUSE, READERS_MAX,
    STATE_BUFFER, WINDOW_CHUNKS, WRITERS_MAX,
};
use crate::message::{Layout, PlanRequest, PlanStatus};

/// The service attribute that holds [`Layout::HASH`].
const LAYOUT_KEY: &str = "surefoot.layout";

/// A service of an instance.
pub type Service<M> = PortFactory<ipc::Service, M, ()>;

/// The services of requests to a serving planner.
#[derive(Debug)]
pub struct RequestServices {
    /// Requests, client to planner.
    pub requests: Service<PlanRequest>,
    /// The planner's latest status.
    pub status: Service<PlanStatus>,
}

/// No message is overwritten: a message that does not fit a subscriber's buffer is not delivered.
pub(crate) const LOSSLESS: Qos = Qos { overflow: false, buffer: WINDOW_CHUNKS, ..DEFAULT };
/// The newest message replaces the one before. A late subscriber receives it.
pub(crate) const LATEST: Qos = Qos { overflow: true, buffer: 1, history: 1, ..DEFAULT };
/// The newest messages replace the oldest. A late subscriber receives the last one.
pub(crate) const RECENT: Qos = Qos { overflow: true, buffer: STATE_BUFFER, history: 1, ..DEFAULT };
/// As [`LOSSLESS`], from many clients.
pub(crate) const FROM_CLIENTS: Qos = Qos { writers: CLIENTS_AT_ONCE_MAX, ..LOSSLESS };
/// As [`LATEST`], to many clients.
pub(crate) const TO_CLIENTS: Qos = Qos { readers: CLIENTS_AT_ONCE_MAX, ..LATEST };
/// The ports of most services.
const DEFAULT: Qos =
    Qos { overflow: false, buffer: 1, history: 0, readers: READERS_MAX, writers: WRITERS_MAX };

/// Quality of service.
pub(crate) struct Qos {
    /// Whether a full buffer drops its oldest message.
    overflow: bool,
    /// Messages in a subscriber's buffer.
    buffer: usize,
    /// Messages that a late subscriber receives.
    history: usize,
    /// Most subscribers.
    readers: usize,
    /// Most publishers.
    writers: usize,
}

/// Opens the service `role` of an instance; creates it if it does not exist.
pub(crate) fn open_service<M: Layout>(
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
            .max_subscribers(qos.readers)
            .max_publishers(qos.writers)
            .max_nodes(NODES_MAX)
            .open_or_create_with_attributes(&attributes);
        match opened {
            Ok(service) => return Ok(service),
            Err(OpenOrCreateError::PublishSubscribeOpenError(
                OpenError::IncompatibleAttributes | OpenError::IncompatibleTypes,
            )) => {
                return Err(ChannelError::Layout { service: name });
            }
            Err(OpenOrCreateError::PublishSubscribeOpenError(
                OpenError::ExceedsMaxNumberOfNodes,
            )) if attempts == OPEN_ATTEMPTS_MAX => {
                return Err(ChannelError::TooManyClients);
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
