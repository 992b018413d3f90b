//! base.

pub(crate) mod comparison;
pub(crate) mod random;
