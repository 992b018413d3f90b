//! Plans in the formats of other programs: sampled tables, footsteps, contact sequences, keyframes
//! and recordings.

pub mod bodies;
pub mod contact_sequence;
pub mod csv;
pub mod error;
pub mod footsteps;
pub mod format;
pub mod joint_selection;
pub mod keyframes;
pub mod loads;
pub mod mcap;
pub mod motion;
pub mod npy;
pub mod npz;
pub mod options;
pub mod quaternion;
pub mod recording;
pub mod ros;
pub mod sampling;
pub mod write;
pub mod zip;

pub use error::ExportError;
pub use format::ExportFormat;
pub use motion::ExportMotion;
pub use options::ExportOptions;
pub use write::export;
