//! The `surefoot` command.

use std::process::ExitCode;

use surefoot::cli::arguments::Arguments;
use surefoot::commands::dispatch;
use surefoot::system::allocations::CountingAllocator;
use surefoot::system::startup;

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

fn main() -> ExitCode {
    startup::run();
    ExitCode::from(dispatch::run(&Arguments::read()))
}
