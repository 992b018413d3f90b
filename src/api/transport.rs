//! Plans and answers in shared memory.

pub use surefoot_planner::channel::plan_publisher::Delivery;
use surefoot_planner::channel::plan_publisher::PlanPublisher;
pub use surefoot_planner::channel::send_window::DeliveryOutcome;
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::observer::Observer;
use surefoot_shared_types::instance::random_id;
use surefoot_shared_types::message::{Feedback, PlanStatus, SimulationState};

use crate::api::error::TransportError;
use crate::api::plan::{Plan, PlanChunk};
use crate::system::instance::enter_instance;

/// The planner's side of an instance: delivers plans to whichever controller listens.
pub struct Publisher {
    publisher: PlanPublisher,
}

impl Publisher {
    /// Enters the instance of this name, and creates it where it does not exist yet.
    ///
    /// # Errors
    /// The instance cannot be entered, or the transport fails.
    pub fn open(name: &str) -> Result<Self, TransportError> {
        Ok(Self { publisher: PlanPublisher::open(&enter_instance(name)?, random_id())? })
    }

    /// Delivers all chunks of a plan in order, without a copy. Returns when all are accepted, one
    /// is refused, or no controller answers for 30 s.
    ///
    /// # Errors
    /// The transport fails.
    pub fn deliver(&mut self, plan: &Plan) -> Result<Delivery, TransportError> {
        Ok(self.publisher.deliver(plan.chunks(), &mut |_| (), &|| true)?)
    }
}

/// A message of a running planner and controller.
#[derive(Debug, Clone, PartialEq)]
pub enum Message {
    /// A plan chunk.
    Chunk(Box<PlanChunk>),
    /// The controller's answer.
    Feedback(Box<Feedback>),
    /// The state of a request to a planner that serves.
    Status(Box<PlanStatus>),
    /// The state of the simulated robot.
    State(Box<SimulationState>),
}

/// Receives all messages of an instance, read-only. No process waits for it: one that reads too
/// slowly misses messages.
#[derive(Debug)]
pub struct Subscriber {
    observer: Observer,
}

impl Subscriber {
    /// Attaches to a running instance.
    ///
    /// # Errors
    /// There is no such instance, the transport fails, or the other processes lay their messages
    /// out differently.
    pub fn open(name: &str) -> Result<Self, TransportError> {
        Ok(Self { observer: Observer::open(&Instance::attach(name)?)? })
    }

    /// The next message, if one came. Chunks come first, each kind in its own order.
    ///
    /// # Errors
    /// The transport fails.
    #[allow(clippy::should_implement_trait, reason = "it returns errors, and goes on after `None`")]
    pub fn next(&mut self) -> Result<Option<Message>, TransportError> {
        if let Some(chunk) = self.observer.chunk()? {
            return Ok(Some(Message::Chunk(Box::new(chunk))));
        }
        if let Some(feedback) = self.observer.feedback()? {
            return Ok(Some(Message::Feedback(Box::new(feedback))));
        }
        if let Some(status) = self.observer.status()? {
            return Ok(Some(Message::Status(Box::new(status))));
        }
        Ok(self.observer.state()?.map(|state| Message::State(Box::new(state))))
    }

    /// Whether a planner or a controller is attached.
    pub fn is_attended(&self) -> bool {
        self.observer.publisher_count() > 0
    }
}
