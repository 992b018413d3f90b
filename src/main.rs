//! The `surefoot` command.

use std::process::ExitCode;

use surefoot::cli::arguments::Arguments;
use surefoot::commands::dispatch;
use surefoot::system::allocations::CountingAllocator;
use surefoot::system::{stack, startup};

#[global_allocator]
static ALLOCATOR: CountingAllocator = CountingAllocator;

fn main() -> ExitCode {
    startup::run();
    ExitCode::from(stack::run(run).unwrap_or_else(dispatch::report_small_stack))
}

fn run() -> u8 {
    match Arguments::read() {
        Ok(arguments) => dispatch::run(&arguments),
        Err(text) => dispatch::print_usage(&text),
    }
}
