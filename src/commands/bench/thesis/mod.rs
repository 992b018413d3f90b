//! `surefoot bench thesis`: our planning times beside those of the thesis.

pub mod published;
pub mod report;
pub mod thesis_bench;
