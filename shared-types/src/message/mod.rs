//! What crosses shared memory: plain old data, no padding, no `usize`, sizes asserted at compile
//! time.

pub mod crc;
pub mod journal_record;
pub mod rest_state;
pub mod simulation_state;

pub use chunk::{Contact, PlanChunk, SupportMode, Waypoint};
pub use correction::{CorrectionKind, WorldCorrection};
pub use crc::WithCrc;
pub use feedback::{Check, Feedback, Margins, Verdict};
pub use journal_record::JournalRecord;
pub use layout::Layout;
pub use request::{PlanRequest, PlanStatus, RequestKind, RequestState};
pub use rest_state::RestState;
pub use simulation_state::SimulationState;

pub mod chunk;
pub mod correction;
pub mod feedback;
pub mod layout;
pub mod request;
