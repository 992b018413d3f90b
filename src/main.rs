//! The `surefoot` command.

use std::process::ExitCode;

use clap::Parser;
use surefoot::cli::arguments::Arguments;
use surefoot::commands::session;
use surefoot::system::allocations::CountingAllocator;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

fn main() -> ExitCode {
    ExitCode::from(session::run(&Arguments::parse()))
}
