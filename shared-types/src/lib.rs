//! Data that Surefoot's processes share.
//!
//! Data, parsing and message layouts; no planning and no checking. `robot`, `scene`
//! and `config` each turn a raw file into a validated value; `plan_file` is the exported plan
//! (`biped-plan/1`); `message` is what crosses shared memory.

pub mod config;
pub mod digest;
pub mod error;
mod hull;
pub mod instance;
mod mesh;
pub mod message;
pub mod plan_file;
pub mod robot;
pub mod scene;
pub mod shape;
mod source;
pub mod spatial;

pub use error::InputError;
pub use shape::Shape;
pub use source::NUMBER_MAX;
pub use spatial::Pose;
