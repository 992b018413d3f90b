//! The command line: commands, options and their limits.

pub mod arguments;
pub mod bench_arguments;
pub mod method_arguments;
pub mod method_bench_arguments;
pub mod robot_arguments;
pub mod shared_bench_arguments;
pub mod simulation_arguments;
pub mod values;
