//! The request server of a serving planner, and its clients.
//!
//! A client repeats its request until the server's status names it; the server takes each request
//! once. Damaged and malformed requests are ignored.

use iceoryx2::port::publisher::{Publisher, PublisherCreateError};
use iceoryx2::port::subscriber::{Subscriber, SubscriberCreateError};
use iceoryx2::prelude::{BackpressureStrategy, PortFactory, ipc};

use crate::instance::error::ChannelError;
use crate::instance::participant::Participant;
use crate::instance::services::RequestServices;
use crate::instance::tuning::{CLIENTS_MAX, WINDOW_CHUNKS};
use crate::message::request::{REQUEST_SCHEMA, STATUS_SCHEMA};
use crate::message::{PlanRequest, PlanStatus, RequestKind, WithCrc};

/// The request server: the planner's side.
#[derive(Debug)]
pub struct RequestServer {
    requests: Subscriber<ipc::Service, PlanRequest, ()>,
    status: Publisher<ipc::Service, PlanStatus, ()>,
    _services: RequestServices,
    session: u64,
    status_count: u64,
    served: heapless::Deque<(u64, u64), CLIENTS_MAX>,
}

impl RequestServer {
    /// Opens the request services for a planner with this session.
    ///
    /// # Errors
    /// The transport fails.
    pub fn open(participant: &Participant, session: u64) -> Result<Self, ChannelError> {
        let _making = participant.making()?;
        let services = participant.open_request_services()?;
        let requests = services.requests.subscriber_builder().buffer_size(WINDOW_CHUNKS).create();
        let requests = requests
            .map_err(|error| ChannelError::transport("creating the request subscriber", error))?;
        let status = services.status.publisher_builder().max_loaned_samples(1).create();
        let status = status
            .map_err(|error| ChannelError::transport("creating the status publisher", error))?;
        participant.instance.reserve_segments()?;
        Ok(Self {
            requests,
            status,
            _services: services,
            session,
            status_count: 0,
            served: heapless::Deque::new(),
        })
    }

    /// The next well-formed request that was not taken before, with its kind.
    ///
    /// # Errors
    /// The transport fails.
    pub fn take(&mut self) -> Result<Option<(PlanRequest, RequestKind)>, ChannelError> {
        loop {
            let received = self
                .requests
                .receive()
                .map_err(|error| ChannelError::transport("receiving a request", error))?;
            let Some(sample) = received else { return Ok(None) };
            let request = *sample.payload();
            if let Some(kind) = request.known_kind()
                && self.is_new(&request)
            {
                return Ok(Some((request, kind)));
            }
        }
    }

    /// Publishes a status to all clients. Writes its schema, session, count and CRC.
    ///
    /// # Errors
    /// The transport fails.
    pub fn publish(&mut self, status: &PlanStatus) -> Result<(), ChannelError> {
        self.status_count += 1;
        let mut status = PlanStatus {
            schema: STATUS_SCHEMA,
            session: self.session,
            count: self.status_count,
            ..*status
        };
        status.write_crc();
        self.status
            .send_copy(status)
            .map(drop)
            .map_err(|error| ChannelError::transport("sending the status", error))
    }

    /// Whether a request's number exceeds all earlier ones of its client. Remembers the number.
    fn is_new(&mut self, request: &PlanRequest) -> bool {
        if let Some((_, number)) =
            self.served.iter_mut().find(|(client, _)| *client == request.client)
        {
            let newer = request.number > *number;
            *number = request.number.max(*number);
            return newer;
        }
        if self.served.is_full() {
            self.served.pop_front();
        }
        self.served.push_back((request.client, request.number)).is_ok()
    }
}

/// A request client.
#[derive(Debug)]
pub struct RequestClient {
    requests: Publisher<ipc::Service, PlanRequest, ()>,
    status: Subscriber<ipc::Service, PlanStatus, ()>,
    services: RequestServices,
    participant: Participant,
    id: u64,
    number: u64,
}

impl RequestClient {
    /// Opens the request services. `id` must not be 0 and must differ from the id of every earlier
    /// client ([`random_id`](crate::instance::sender::random_id)).
    ///
    /// # Errors
    /// The id is 0, or the transport fails.
    pub fn open(participant: Participant, id: u64) -> Result<Self, ChannelError> {
        if id == 0 {
            return Err(ChannelError::Id);
        }
        let making = participant.making()?;
        let services = participant.open_request_services()?;
        let requests = services
            .requests
            .publisher_builder()
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create();
        let requests = requests.map_err(|error| match error {
            PublisherCreateError::ExceedsMaxSupportedPublishers => ChannelError::TooManyClients,
            error => ChannelError::transport("creating the request publisher", error),
        })?;
        let status = services.status.subscriber_builder().create();
        let status = status.map_err(|error| match error {
            SubscriberCreateError::ExceedsMaxSupportedSubscribers => ChannelError::TooManyClients,
            error => ChannelError::transport("creating the status subscriber", error),
        })?;
        participant.instance.reserve_segments()?;
        drop(making);
        Ok(Self { requests, status, services, participant, id, number: 0 })
    }

    /// A copy of `request` with schema, client, number and CRC written. Send it repeatedly until a
    /// status names it.
    pub fn stamp(&mut self, request: &PlanRequest) -> PlanRequest {
        self.number += 1;
        let mut stamped = PlanRequest {
            schema: REQUEST_SCHEMA,
            client: self.id,
            number: self.number,
            ..*request
        };
        stamped.write_crc();
        stamped
    }

    /// Sends a request unchanged.
    ///
    /// # Errors
    /// The transport fails.
    pub fn send(&self, request: &PlanRequest) -> Result<(), ChannelError> {
        self.requests
            .send_copy(*request)
            .map(drop)
            .map_err(|error| ChannelError::transport("sending a request", error))
    }

    /// Whether a request server is connected. Cleans up first, so that a killed one does not count.
    pub fn has_server(&self) -> bool {
        self.participant.clean_up_dead();
        self.services.status.dynamic_config().number_of_publishers() > 0
    }

    /// The planner's latest well-formed status, if a new one arrived.
    ///
    /// # Errors
    /// The transport fails.
    pub fn status(&self) -> Result<Option<PlanStatus>, ChannelError> {
        let mut latest = None;
        while let Some(sample) = self
            .status
            .receive()
            .map_err(|error| ChannelError::transport("receiving the status", error))?
        {
            latest =
                Some(*sample.payload()).filter(|status| status.known_state().is_some()).or(latest);
        }
        Ok(latest)
    }
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;
    use crate::instance::instance::Instance;
    use crate::message::{RequestRecord, RequestState};

    #[test]
    fn each_request_is_served_once_and_a_malformed_one_never() {
        let base = tempfile::tempdir_in("/dev/shm").unwrap();
        let instance = Instance::create_in(&base.path().join("base"), "services").unwrap();
        let mut server = RequestServer::open(&Participant::open(&instance).unwrap(), 7).unwrap();
        let mut client = RequestClient::open(Participant::open(&instance).unwrap(), 9).unwrap();
        let cancel = PlanRequest { kind: RequestKind::Cancel as u32, ..PlanRequest::zeroed() };
        let stamped = client.stamp(&cancel);
        client.send(&stamped).unwrap();
        client.send(&stamped).unwrap();
        client.send(&PlanRequest { number: 99, ..stamped }).unwrap();
        let second = client.stamp(&cancel);
        client.send(&second).unwrap();
        client.send(&stamped).unwrap();
        let numbers: Vec<u64> = std::iter::from_fn(|| server.take().unwrap())
            .map(|(request, _)| request.number)
            .collect();
        assert_eq!(numbers, [1, 2]);
        assert_eq!(client.status().unwrap(), None);
        let state = RequestState::Cancelled as u32;
        let current = RequestRecord { client: 9, number: 2, state, ..RequestRecord::zeroed() };
        let status = PlanStatus { current, ..PlanStatus::zeroed() };
        server.publish(&status).unwrap();
        server.publish(&status).unwrap();
        let received = client.status().unwrap().unwrap();
        assert_eq!(
            (received.session, received.current.client, received.current.number, received.count),
            (7, 9, 2, 2)
        );
    }
}
