//! The `surefoot` command.

use std::process::ExitCode;

use clap::Parser;
use surefoot::allocations::CountingAllocator;
use surefoot::arguments::Arguments;
use surefoot::commands;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

fn main() -> ExitCode {
    ExitCode::from(commands::run(&Arguments::parse()))
}
