//! A process's participant in an instance: its iceoryx2 node, the services of chunks and feedback,
//! and a wake pipe for each direction.

use iceoryx2::node::Node;
use iceoryx2::prelude::{LogLevel, NodeBuilder, SignalHandlingMode, ipc, set_log_level};

use crate::instance::dead_nodes;
use crate::instance::description::DescriptionPublisher;
use crate::instance::error::ChannelError;
use crate::instance::instance::Instance;
use crate::instance::making::{Making, MakingLock};
use crate::instance::management_segment;
use crate::instance::services::{
    FROM_CLIENTS, LATEST, LOSSLESS, RECENT, RequestServices, Service, TO_CLIENTS, open_service,
};
use crate::instance::unfinished_watch::UnfinishedWatch;
use crate::instance::wake_pipe::WakePipe;
use crate::message::{
    Description, Feedback, Layout, PlanChunk, PlanRequest, PlanStatus, SetPoint, SimulationState,
};

/// A process's participant in an instance.
#[derive(Debug)]
pub struct Participant {
    /// Plan chunks, planner to controller.
    pub chunks: Service<PlanChunk>,
    /// The controller's latest feedback.
    pub feedback: Service<Feedback>,
    /// The planner notifies it when it has sent chunks and the controller may block.
    pub chunk_wake_pipe: WakePipe,
    /// The controller notifies it when it has sent feedback and the planner may block.
    pub feedback_wake_pipe: WakePipe,
    description: Option<DescriptionPublisher>,
    node: Node<ipc::Service>,
    making: MakingLock,
    _watch: UnfinishedWatch,
    /// The instance; dropped last.
    pub instance: Instance,
}

impl Participant {
    /// Opens the services of chunks and feedback; creates the ones that do not exist.
    ///
    /// # Errors
    /// Shared memory is full, a service has another message layout, or the transport fails.
    pub fn open(instance: &Instance) -> Result<Self, ChannelError> {
        Self::open_with_layouts(instance, PlanChunk::HASH, Feedback::HASH)
    }

    /// As [`Self::open`], for a program with these layout hashes of [`PlanChunk`] and [`Feedback`].
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
        let watch = UnfinishedWatch::start(instance)?;
        let making = MakingLock::open(instance)?;
        let guard = making.acquire(instance.root(), instance.segment_prefix())?;
        management_segment::ensure(instance.segment_prefix())?;
        let node = NodeBuilder::new()
            .config(&config)
            .signal_handling_mode(SignalHandlingMode::Disabled)
            .create::<ipc::Service>();
        let node =
            node.map_err(|error| ChannelError::transport("creating an iceoryx2 node", error))?;
        dead_nodes::free(&node, instance.root(), instance.segment_prefix());
        let chunks = open_service(&node, instance, "chunks", chunk_hash, &LOSSLESS)?;
        let feedback = open_service(&node, instance, "feedback", feedback_hash, &LATEST)?;
        let chunk_wake_pipe = WakePipe::open(instance, "chunk-wake-pipe")?;
        let feedback_wake_pipe = WakePipe::open(instance, "feedback-wake-pipe")?;
        instance.reserve_segments()?;
        drop(guard);
        Ok(Self {
            chunks,
            feedback,
            chunk_wake_pipe,
            feedback_wake_pipe,
            description: None,
            node,
            making,
            _watch: watch,
            instance: instance.clone(),
        })
    }

    /// Holds the lock `making`. Hold it while services are opened and ports are created, so that
    /// other processes know whether one of them was killed in the middle.
    ///
    /// # Errors
    /// Another process holds the lock for too long, or the file system fails.
    pub fn making(&self) -> Result<Making<'_>, ChannelError> {
        Ok(self.making.acquire(self.instance.root(), self.instance.segment_prefix())?)
    }

    /// As [`Self::making`], but `None` if another process holds the lock.
    ///
    /// # Errors
    /// The file system fails.
    pub fn try_making(&self) -> Result<Option<Making<'_>>, ChannelError> {
        Ok(self.making.try_acquire(self.instance.root(), self.instance.segment_prefix())?)
    }

    /// Frees the resources of dead processes. Does nothing while another process opens the
    /// instance, or on an error, which shows at the next opening.
    pub fn clean_up_dead(&self) {
        let making = self.making.try_acquire(self.instance.root(), self.instance.segment_prefix());
        if let Ok(Some(_making)) = making {
            dead_nodes::free(&self.node, self.instance.root(), self.instance.segment_prefix());
        }
    }

    /// Publishes what readers have to know of this process's walk.
    ///
    /// # Errors
    /// Shared memory is full, the service has another message layout, or the transport fails.
    pub fn describe(&mut self, description: &Description) -> Result<(), ChannelError> {
        let making = self.making()?;
        let publisher = DescriptionPublisher::open(self.open_description()?, description)?;
        self.instance.reserve_segments()?;
        drop(making);
        self.description = Some(publisher);
        Ok(())
    }

    /// Delivers this process's description to readers that have joined since the last call. Call
    /// it while idle, some times a second.
    pub fn refresh_description(&self) {
        if let Some(publisher) = &self.description {
            publisher.refresh();
        }
    }

    /// The node of this process.
    pub(crate) fn node(&self) -> &Node<ipc::Service> {
        &self.node
    }

    /// Opens the service of descriptions; creates it if it does not exist. Hold [`Self::making`]
    /// meanwhile.
    ///
    /// # Errors
    /// The service has another message layout, or the transport fails.
    pub fn open_description(&self) -> Result<Service<Description>, ChannelError> {
        open_service(&self.node, &self.instance, "description", Description::HASH, &LATEST)
    }

    /// Opens the service of set-points; creates it if it does not exist. Hold [`Self::making`]
    /// meanwhile.
    ///
    /// # Errors
    /// The service has another message layout, or the transport fails.
    pub fn open_set_points(&self) -> Result<Service<SetPoint>, ChannelError> {
        open_service(&self.node, &self.instance, "set_points", SetPoint::HASH, &RECENT)
    }

    /// Opens the service on which a controller publishes the simulated robot's state; creates it
    /// if it does not exist. Hold [`Self::making`] meanwhile.
    ///
    /// # Errors
    /// The service has another message layout, or the transport fails.
    pub fn open_state(&self) -> Result<Service<SimulationState>, ChannelError> {
        open_service(&self.node, &self.instance, "state", SimulationState::HASH, &RECENT)
    }

    /// Opens the request services; creates the ones that do not exist. Hold [`Self::making`]
    /// meanwhile.
    ///
    /// # Errors
    /// A service has another message layout, or the transport fails.
    pub fn open_request_services(&self) -> Result<RequestServices, ChannelError> {
        let requests =
            open_service(&self.node, &self.instance, "requests", PlanRequest::HASH, &FROM_CLIENTS)?;
        let status =
            open_service(&self.node, &self.instance, "status", PlanStatus::HASH, &TO_CLIENTS)?;
        Ok(RequestServices { requests, status })
    }
}
