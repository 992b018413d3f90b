//! What a person reads in the end.

use std::fmt::Write;

use crate::line::DeliveryEnd;
use crate::report::Report;

/// The verdict on a run, several lines without a line break at the end.
pub fn text(report: &Report) -> String {
    let mut text = format!("{}, {}, seed {}: {}", report.scenario, report.robot, report.seed, headline(report));
    let mut line = |name: &str, content: String| {
        let _ = write!(text, "\n  {name:<8} {content}");
    };
    if report.has_plan() {
        line("plan", format!("{} steps, {} waypoints", report.steps, report.waypoints));
    }
    if report.has_plan() {
        line(
            "route",
            format!("{} edges, {} of them possible; {} primitives", report.route_edges, report.route_edges_possible, report.primitives),
        );
    }
    line("search", search(report));
    if let Some(digest) = &report.digest {
        line("digest", digest.clone());
    }
    if report.delivery().is_some() {
        line("chunks", chunks(report));
    }
    if report.replans > 0 {
        line("replans", report.replans.to_string());
    }
    if report.restarts > 0 {
        line("restarts", report.restarts.to_string());
    }
    let margins = report.margins.describe();
    if !margins.is_empty() {
        line("margins", margins);
    }
    if let Some(refusal) = &report.refusal {
        line("refused", refusal.describe());
    }
    text
}

fn headline(report: &Report) -> String {
    let found = report.description();
    match report.delivery() {
        None => found.to_owned(),
        Some(DeliveryEnd::Accepted) => format!("{found}, walked and accepted"),
        Some(DeliveryEnd::Refused) => format!("{found}, but refused by the controller"),
        Some(DeliveryEnd::Superseded) => format!("{found}, but another planner planned again meanwhile"),
        Some(DeliveryEnd::ControllerLost) => format!("{found}, but no controller answers"),
        Some(DeliveryEnd::Stopped) => format!("{found}, delivery stopped"),
    }
}

fn search(report: &Report) -> String {
    let seconds = |time: Option<f64>| time.map_or("-".to_owned(), |time| format!("{time:.3} s"));
    format!(
        "{} ({} to get ready), {} work units, {} sequences, {} threads, {} allocations",
        seconds(report.plan_seconds),
        seconds(report.ready_seconds),
        report.work,
        report.sequences,
        report.threads,
        report.allocations_after_ready
    )
}

fn chunks(report: &Report) -> String {
    let chunks = &report.chunks;
    let checked = report.check_seconds.map(|time| format!(", checked in {time:.3} s")).unwrap_or_default();
    format!("{} sent, {} accepted, {} lost, {} duplicated{checked}", chunks.sent, chunks.accepted, chunks.lost, chunks.duplicated)
}
