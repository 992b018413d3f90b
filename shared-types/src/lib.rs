//! The data that Surefoot's processes share: robots, worlds, scenarios, plan files, messages and
//! the shared memory that carries them. It plans nothing and checks nothing.
//!
//! [`robot`], [`world`] and [`config`] turn files into validated values. [`plan_file`] reads and
//! writes exported plans (`biped-plan/1`). [`message`] holds the layouts in shared memory, and
//! [`instance`] the shared memory itself.

pub mod base;
pub mod config;
pub mod geometry;
pub mod instance;
pub mod mesh;
pub mod message;
pub mod plan_file;
pub mod plan_format;
pub mod robot;
pub mod robot_draft;
pub mod scenario;
pub mod world;

pub use base::input_error::InputError;
pub use base::spatial::Pose;
pub use base::text_file::NUMBER_MAX;
pub use geometry::shape::Shape;
