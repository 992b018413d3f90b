//! Constants of memory and threads that change speed but no result. Each was chosen by the benches
//! on two virtual cores.

/// Bytes of each arena that are written when it is reserved: more than a short search uses. To
/// write a whole arena takes longer than such a search. A process that locks its memory has all
/// pages from the start.
pub(crate) const WRITTEN_BYTES_MAX: usize = 512 << 10;

/// Polls of an idle thread before it sleeps: about 2 ms, longer than most sequential work.
pub(crate) const IDLE_POLLS_MAX: u32 = 16384;

/// Polls of a thread that waits for another one before rayon puts it to sleep: about 150 µs.
pub(crate) const WAIT_POLLS_MAX: u32 = 1024;
