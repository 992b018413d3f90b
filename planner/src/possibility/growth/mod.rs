//! growth.

pub(crate) mod blocked;
