//! The request server of a planner process, with the status that it publishes.

use bytemuck::Zeroable;
use surefoot_shared_types::instance::requests::RequestServer;
use surefoot_shared_types::message::{
    PlanRequest, PlanStatus, RequestKind, RequestRecord, RequestState,
};

use crate::report::command_error::CommandError;
use crate::system::clock::Stopwatch;
use crate::system::signals;

/// Time between two repetitions of the status while nothing changes, s.
const REPEAT_SECONDS: f64 = 0.5;

/// A request with its kind.
pub(crate) type IncomingRequest = (PlanRequest, RequestKind);

/// The request server, and the request that arrived while another one was served.
pub(crate) struct RequestQueue {
    server: RequestServer,
    /// The status that is published.
    status: PlanStatus,
    next: Option<IncomingRequest>,
    /// Time since the status was published.
    published: Stopwatch,
}

impl RequestQueue {
    /// An empty queue.
    pub(crate) fn new(server: RequestServer) -> Self {
        let published = Stopwatch::start();
        Self { server, status: PlanStatus::zeroed(), next: None, published }
    }

    /// The next request, if there is one.
    ///
    /// # Errors
    /// The transport fails.
    pub(crate) fn take(&mut self) -> Result<Option<IncomingRequest>, CommandError> {
        match self.next.take() {
            Some(request) => Ok(Some(request)),
            None => Ok(self.server.take()?),
        }
    }

    /// Whether a request or a signal has arrived.
    pub(crate) fn is_interrupted(&mut self) -> bool {
        if self.next.is_none() {
            // A server that fails here fails again in `take`.
            self.next = self.server.take().unwrap_or(None);
        }
        self.next.is_some() || signals::raised().is_some()
    }

    /// As [`Self::is_interrupted`]; also repeats the status when [`REPEAT_SECONDS`] have passed.
    pub(crate) fn is_interrupted_or_repeat(&mut self) -> bool {
        if self.published.seconds() > REPEAT_SECONDS {
            // A transport that fails here fails again in the next `publish`.
            let _ = self.publish();
        }
        self.is_interrupted()
    }

    /// The record of the current request.
    pub(crate) fn current(&mut self) -> &mut RequestRecord {
        &mut self.status.current
    }

    /// Begins a request.
    ///
    /// # Errors
    /// The transport fails.
    pub(crate) fn begin(&mut self, request: &PlanRequest) -> Result<(), CommandError> {
        let (client, number) = (request.client, request.number);
        self.status.current = RequestRecord { client, number, ..RequestRecord::zeroed() };
        self.set_state(RequestState::Planning)
    }

    /// Publishes how the current request ended.
    ///
    /// # Errors
    /// The transport fails.
    pub(crate) fn finish(&mut self, state: RequestState, reason: &str) -> Result<(), CommandError> {
        self.status.current.state = state as u32;
        self.status.current.set_reason(reason);
        self.status.record_end();
        self.publish()
    }

    /// Publishes the status.
    ///
    /// # Errors
    /// The transport fails.
    pub(crate) fn publish(&mut self) -> Result<(), CommandError> {
        self.published = Stopwatch::start();
        Ok(self.server.publish(&self.status)?)
    }

    /// Sets the request's state and publishes it.
    ///
    /// # Errors
    /// The transport fails.
    pub(crate) fn set_state(&mut self, state: RequestState) -> Result<(), CommandError> {
        self.status.current.state = state as u32;
        self.publish()
    }

    /// Publishes that the search for a plan begins.
    ///
    /// # Errors
    /// The transport fails.
    pub(crate) fn begin_plan(&mut self, plan_id: u64, epoch: u64) -> Result<(), CommandError> {
        let RequestRecord { client, number, .. } = self.status.current;
        self.status.current =
            RequestRecord { client, number, plan_id, epoch, ..RequestRecord::zeroed() };
        self.set_state(RequestState::Planning)
    }
}
