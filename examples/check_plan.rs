//! Checks a plan that somebody else made, from its file.
//!
//! `surefoot plan SCENARIO --export plan.json`, then
//! `cargo run --release --example check_plan plan.json`

#![allow(clippy::print_stdout, reason = "an example prints")]

use surefoot::Checker;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let Some(path) = std::env::args().nth(1) else {
        println!("usage: check_plan PLAN.json");
        return Ok(());
    };
    let report = Checker::check_file(&path)?;
    for placed in report.violations() {
        println!("phase {}: {}", placed.phase, placed.violation);
    }
    let margins = report.margins;
    println!(
        "balance {:.1} mm, collision {:.1} mm",
        1e3 * margins.balance,
        1e3 * margins.collision
    );
    println!("{path}: {}", if report.is_valid() { "accepted" } else { "refused" });
    Ok(())
}
