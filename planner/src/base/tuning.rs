//! Constants of memory that change speed but no result.

/// Bytes of each arena that are written when it is reserved: more than a short search uses. To
/// write a whole arena takes longer than such a search. A process that locks its memory has all
/// pages from the start.
pub(crate) const WRITTEN_BYTES_MAX: usize = 512 << 10;
