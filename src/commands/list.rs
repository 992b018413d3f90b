//! `surefoot list`: the inputs that the program carries.

use serde_json::json;

use crate::cli::arguments::ListArguments;
use crate::input::shipped::{ShippedInput, ShippedKind, shipped};
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::terminal;

/// The kinds in the order of the list, with their names in JSON and their headings.
const KINDS: [(ShippedKind, &str, &str); 3] = [
    (ShippedKind::Scenario, "scenario", "scenarios: 'surefoot walk NAME'"),
    (ShippedKind::Robot, "robot", "robots: 'surefoot new DIR' writes one to copy"),
    (ShippedKind::World, "world", "worlds, named by the scenarios"),
];

/// Runs the command.
///
/// # Errors
/// None.
pub fn run(arguments: &ListArguments) -> Result<CommandOutcome, CommandError> {
    let blocks = KINDS.iter().map(|(kind, name, heading)| {
        let inputs: Vec<ShippedInput> = shipped(*kind).collect();
        if arguments.json { json_lines(name, &inputs) } else { block(heading, &inputs) }
    });
    let between = if arguments.json { "\n" } else { "\n\n" };
    terminal::print_result(&blocks.collect::<Vec<_>>().join(between));
    Ok(CommandOutcome::Done)
}

fn block(heading: &str, inputs: &[ShippedInput]) -> String {
    let width = inputs.iter().map(|input| input.name.len()).max().unwrap_or(0);
    let rows = inputs.iter().map(|input| format!("  {:<width$}  {}", input.name, input.summary));
    std::iter::once(heading.to_owned()).chain(rows).collect::<Vec<_>>().join("\n")
}

fn json_lines(kind: &str, inputs: &[ShippedInput]) -> String {
    let row = |input: &ShippedInput| {
        json!({ "kind": kind, "name": input.name, "summary": input.summary }).to_string()
    };
    inputs.iter().map(row).collect::<Vec<_>>().join("\n")
}
