//! `surefoot bench replan`: planning times after refused chunks.

pub mod refusals;
pub mod replan_bench;
