//! The desk at which a planner that stays up is asked: its clerk, and the clients.
//!
//! A client repeats its request until the clerk's status names it; the clerk takes each request
//! once. Damaged requests, and those that make no sense, are passed over as if they had never come.

use iceoryx2::port::publisher::Publisher;
use iceoryx2::port::subscriber::Subscriber;
use iceoryx2::prelude::{BackpressureStrategy, ipc};

use super::service::{CREDIT, ChannelError, Desk, Link};
use crate::message::request::{REQUEST_SCHEMA, STATUS_SCHEMA};
use crate::message::{PlanRequest, PlanStatus, RequestKind, Sealed};

/// How many clients are remembered, so that a repeated request of theirs is known.
const CLIENTS_MAX: usize = 64;

/// The planner's side.
#[derive(Debug)]
pub struct Clerk {
    requests: Subscriber<ipc::Service, PlanRequest, ()>,
    status: Publisher<ipc::Service, PlanStatus, ()>,
    _desk: Desk,
    session: u64,
    words: u64,
    served: heapless::Deque<(u64, u64), CLIENTS_MAX>,
}

impl Clerk {
    /// Opens the desk for a planner with this session.
    ///
    /// # Errors
    /// The transport fails.
    pub fn open(link: &Link, session: u64) -> Result<Self, ChannelError> {
        let desk = link.open_desk()?;
        let requests = desk.requests.subscriber_builder().buffer_size(CREDIT).create();
        let requests = requests
            .map_err(|error| ChannelError::transport("creating the request subscriber", error))?;
        let status = desk.status.publisher_builder().max_loaned_samples(1).create();
        let status = status
            .map_err(|error| ChannelError::transport("creating the status publisher", error))?;
        link.instance.reserve_segments()?;
        Ok(Self {
            requests,
            status,
            _desk: desk,
            session,
            words: 0,
            served: heapless::Deque::new(),
        })
    }

    /// The next request that was not served yet, with its kind.
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

    /// Tells all clients how things stand; schema, session, count and CRC are filled in.
    ///
    /// # Errors
    /// The transport fails.
    pub fn tell(&mut self, status: &PlanStatus) -> Result<(), ChannelError> {
        self.words += 1;
        let mut status = PlanStatus {
            schema: STATUS_SCHEMA,
            session: self.session,
            count: self.words,
            ..*status
        };
        status.seal();
        self.status
            .send_copy(status)
            .map(drop)
            .map_err(|error| ChannelError::transport("sending the status", error))
    }

    /// Whether a request is newer than all of its client before; notes it if so.
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

/// A client's side.
#[derive(Debug)]
pub struct Client {
    requests: Publisher<ipc::Service, PlanRequest, ()>,
    status: Subscriber<ipc::Service, PlanStatus, ()>,
    _desk: Desk,
    _link: Link,
    id: u64,
    number: u64,
}

impl Client {
    /// Steps up to the desk. `id` must not be 0 and must differ from that of every client before
    /// (`instance::draw_id`).
    ///
    /// # Errors
    /// The transport fails.
    pub fn open(link: Link, id: u64) -> Result<Self, ChannelError> {
        if id == 0 {
            return Err(ChannelError::Id);
        }
        let desk = link.open_desk()?;
        let requests = desk
            .requests
            .publisher_builder()
            .backpressure_strategy(BackpressureStrategy::DiscardData)
            .create();
        let requests = requests
            .map_err(|error| ChannelError::transport("creating the request publisher", error))?;
        let status = desk.status.subscriber_builder().create();
        let status = status
            .map_err(|error| ChannelError::transport("creating the status subscriber", error))?;
        link.instance.reserve_segments()?;
        Ok(Self { requests, status, _desk: desk, _link: link, id, number: 0 })
    }

    /// Gives a request its client and number, and seals it. Send what this answers, again and again
    /// until it is named.
    pub fn sign(&mut self, request: &PlanRequest) -> PlanRequest {
        self.number += 1;
        let mut signed = PlanRequest {
            schema: REQUEST_SCHEMA,
            client: self.id,
            number: self.number,
            ..*request
        };
        signed.seal();
        signed
    }

    /// Sends a request as it is.
    ///
    /// # Errors
    /// The transport fails.
    pub fn send(&self, request: &PlanRequest) -> Result<(), ChannelError> {
        self.requests
            .send_copy(*request)
            .map(drop)
            .map_err(|error| ChannelError::transport("sending a request", error))
    }

    /// The planner's latest word, if a new one came and is well-formed.
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

    use super::super::Instance;
    use super::*;
    use crate::message::RequestState;

    #[test]
    fn each_request_is_served_once_and_nonsense_never() {
        let base = tempfile::tempdir_in("/dev/shm").unwrap();
        let instance = Instance::create_in(&base.path().join("base"), "desk").unwrap();
        let mut clerk = Clerk::open(&Link::open(&instance).unwrap(), 7).unwrap();
        let mut client = Client::open(Link::open(&instance).unwrap(), 9).unwrap();
        let cancel = PlanRequest { kind: RequestKind::Cancel as u32, ..PlanRequest::zeroed() };
        let signed = client.sign(&cancel);
        client.send(&signed).unwrap();
        client.send(&signed).unwrap();
        client.send(&PlanRequest { number: 99, ..signed }).unwrap();
        let second = client.sign(&cancel);
        client.send(&second).unwrap();
        client.send(&signed).unwrap();
        let numbers: Vec<u64> = std::iter::from_fn(|| clerk.take().unwrap())
            .map(|(request, _)| request.number)
            .collect();
        assert_eq!(numbers, [1, 2]);
        assert_eq!(client.status().unwrap(), None);
        let status = PlanStatus {
            client: 9,
            number: 2,
            state: RequestState::Cancelled as u32,
            ..PlanStatus::zeroed()
        };
        clerk.tell(&status).unwrap();
        clerk.tell(&status).unwrap();
        let heard = client.status().unwrap().unwrap();
        assert_eq!((heard.session, heard.client, heard.number, heard.count), (7, 9, 2, 2));
    }
}
