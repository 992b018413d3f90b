//! What crosses shared memory: plain old data, no padding, no `usize`, sizes asserted at compile time.

pub mod chunk;
pub mod feedback;
pub mod layout;
pub mod limits;

pub use chunk::{Contact, PlanChunk, SupportMode, Waypoint};
pub use feedback::{Check, Feedback, Margins, Verdict};
pub use layout::Layout;
