//! The `surefoot` command.

use std::process::ExitCode;

use clap::Parser;
use surefoot::cli::arguments::Arguments;
use surefoot::commands::dispatch;
use surefoot::system::allocations::CountingAllocator;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

fn main() -> ExitCode {
    ExitCode::from(dispatch::run(&Arguments::parse()))
}
