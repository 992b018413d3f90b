//! `surefoot bench scale`: costs of longer scenarios and larger worlds.

pub mod plot;
pub mod scale_bench;
