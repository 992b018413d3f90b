//! The library's interface.

mod checker;
mod error;
mod event;
mod height_map;
mod load;
mod parameters;
mod plan;
mod plan_files;
mod plan_inputs;
mod planner;
mod pose;
mod prepared;
mod robot;
mod stance;
mod transport;
mod world;

pub use checker::{Checker, Margins};
pub use error::{
    AnswerError, BuildError, CheckError, LoadError, PlanError, PrepareError, ReplanError,
    SaveError, StartError, TransportError, WorldError,
};
pub use event::{Event, WorldCorrection};
pub use height_map::HeightMap;
pub use load::{FootLoad, Load};
pub use parameters::{CheckerConfig, ExecutionConfig, MotionKind, Parameters, PlannerConfig};
pub use plan::{Contacts, Digest, Foot, Foothold, Plan, PlanChunk, State};
pub use planner::{Improvement, Planner, PlannerBuilder, SearchStats, SearchTrace, Step};
pub use pose::Pose;
pub use prepared::Prepared;
pub use robot::Robot;
pub use stance::{Goal, Stance};
pub use transport::{Delivery, DeliveryOutcome, Message, Publisher, Subscriber};
pub use world::{Shape, World, WorldBuilder};
