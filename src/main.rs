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
    let code = match Arguments::read() {
        Ok(arguments) => dispatch::run(&arguments),
        Err(text) => dispatch::print_usage(&text),
    };
    ExitCode::from(code)
}
