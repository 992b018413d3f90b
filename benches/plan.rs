//! Planning times: `cargo bench --bench plan [-- [--json] SCENARIO..]` plans each scenario with the
//! seeds 1 to 10, as `surefoot bench thesis` does.

#![allow(missing_docs, reason = "a benchmark command")]

use std::process::ExitCode;

use clap::Parser;
use surefoot::cli::arguments::Arguments;

const SCENARIOS: [&str; 4] = ["flat_walk", "stepping_stones", "ibeam_hallway", "ibeam_gap"];

fn main() -> ExitCode {
    let (options, asked): (Vec<String>, Vec<String>) =
        std::env::args().skip(1).partition(|argument| argument.starts_with('-'));
    let scenarios = if asked.is_empty() { SCENARIOS.map(str::to_owned).into() } else { asked };
    let bench = [
        "surefoot",
        "bench",
        "thesis",
        "--trials",
        "10",
        "--configs",
        concat!(env!("CARGO_MANIFEST_DIR"), "/configs/scenarios"),
    ];
    let json = options.into_iter().filter(|option| option == "--json");
    let scenarios = scenarios.into_iter().flat_map(|scenario| ["--scenario".to_owned(), scenario]);
    let arguments =
        Arguments::parse_from(bench.map(str::to_owned).into_iter().chain(json).chain(scenarios));
    ExitCode::from(surefoot::commands::dispatch::run(&arguments))
}
