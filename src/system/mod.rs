//! The operating system: clock, cores, limits, memory, signals and the terminal.

pub mod allocations;
pub mod clock;
pub mod cores;
pub(crate) mod fixed_text;
pub mod instance;
pub mod limits;
pub mod memory;
pub mod memory_file;
pub mod signals;
pub mod size;
pub mod stack;
pub mod startup;
pub mod terminal;
