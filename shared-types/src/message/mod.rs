//! Messages in shared memory: plain old data without padding, pointers or `usize`. Sizes are
//! asserted at compile time.

pub mod binding;
pub mod chunk;
pub mod correction;
pub mod crc;
pub mod description;
pub mod feedback;
pub mod interpolation;
pub mod journal_record;
pub mod layout;
pub mod ramp;
pub mod request;
pub mod request_record;
pub mod rest_state;
pub(crate) mod rotation_vector;
pub mod set_point;
pub mod simulation_state;
pub mod walk_record;

pub use binding::{ChunkBinding, LimitKind};
pub use chunk::{Contact, PlanChunk, SupportMode, Waypoint};
pub use correction::{CorrectionKind, WorldCorrection};
pub use crc::WithCrc;
pub use description::Description;
pub use feedback::{Check, Feedback, Margins, Verdict};
pub use interpolation::Interpolation;
pub use journal_record::JournalRecord;
pub use layout::Layout;
pub use ramp::{PlanTime, Ramp};
pub use request::{PlanRequest, PlanStatus, RequestKind};
pub use request_record::{RequestRecord, RequestState};
pub use rest_state::RestState;
pub use set_point::SetPoint;
pub use simulation_state::SimulationState;
pub use walk_record::{RecordedPace, WalkRecord};
