//! What crosses shared memory: plain old data, no padding, no `usize`, sizes asserted at compile
//! time.

pub mod chunk;
pub mod correction;
pub mod feedback;
pub mod layout;
pub mod limits;
pub mod record;
pub mod request;
mod seal;
pub mod standing;
pub mod state;

pub use chunk::{Contact, PlanChunk, SupportMode, Waypoint};
pub use correction::{Correction, CorrectionKind};
pub use feedback::{Check, Feedback, Margins, Verdict};
pub use layout::Layout;
pub use record::RobotRecord;
pub use request::{PlanRequest, PlanStatus, RequestKind, RequestState};
pub use seal::WithCrc;
pub use standing::Standing;
pub use state::State;
