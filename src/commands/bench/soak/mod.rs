//! `surefoot bench soak`: walks and requests with random kills, stops and messages of a forger.

pub mod faults;
pub mod forger;
pub mod random;
pub mod requests;
pub mod soak_bench;
pub mod traces;
pub mod walks;
