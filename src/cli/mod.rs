//! cli.

pub mod arguments;
pub mod bench_arguments;
