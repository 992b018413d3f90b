//! Data that Surefoot's processes share.
//!
//! Data, parsing and message layouts; no planning and no checking. `robot`, `scene`
//! and `config` each turn a raw file into a validated value; `plan_file` is the exported plan
//! (`biped-plan/1`); `message` is what crosses shared memory.

pub mod base;
pub mod config;
pub mod geometry;
pub mod instance;
pub mod mesh;
pub mod message;
pub mod plan_file;
pub mod plan_format;
pub mod robot;
pub mod world;

pub use base::input_error::InputError;
pub use base::spatial::Pose;
pub use base::text_file::NUMBER_MAX;
pub use geometry::shape::Shape;
