//! The operating system: clock, cores, memory, signals and the terminal.

pub mod allocations;
pub mod clock;
pub mod cores;
pub mod instance;
pub mod memory;
pub mod signals;
pub mod terminal;
