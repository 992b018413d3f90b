//! base.

pub mod arena;
pub(crate) mod idle_threads;
pub mod random;
pub mod threads;
pub(crate) mod work_budget;
