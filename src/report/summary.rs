//! The summary of a run as text.

use std::collections::BTreeMap;
use std::fmt::Write;

use crate::report::binding;
use crate::report::event::{
    Bottleneck, DeliveryResult, Diagnosis, PlanResult, Planned, describe_stops,
};
use crate::report::run_report::Report;

/// Rejection reasons that are shown.
const REASONS_SHOWN: usize = 3;

/// The summary of a run: several lines, without a final line break.
pub fn text(report: &Report) -> String {
    let mut text = format!(
        "{}, {}, seed {}: {}",
        report.scenario,
        report.robot,
        report.seed,
        headline(report)
    );
    let mut line = |name: &str, content: String| add(&mut text, name, &content);
    if report.has_plan() {
        line("plan", format!("{} steps, {} waypoints", report.steps, report.waypoints));
        if let Some(walk) = &report.walk {
            line("walk", walk.describe());
        }
    }
    if let Some(smooth) = &report.smooth {
        line("motion", smooth.describe());
        let bound_by = binding::describe(&smooth.binding);
        if !bound_by.is_empty() {
            line("bound by", bound_by);
        }
    }
    if let Some(improved) = &report.improved {
        line("improved", improved.describe());
    }
    if report.has_plan() {
        line(
            "route",
            format!(
                "{} edges, {} of them possible; {} primitives",
                report.route_edges, report.route_edges_possible, report.primitives
            ),
        );
    }
    explain(report.diagnosis.as_deref(), &mut line);
    line("search", search(report));
    if let Some(digest) = &report.digest {
        line("digest", digest.clone());
    }
    if report.delivery_result().is_some() {
        line("chunks", chunks(report));
    }
    if let Some(stops) = describe_stops(report.late_chunks, report.brakes, report.stood_seconds) {
        line("stops", stops);
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

/// The summary of one search: several lines, without a final line break.
pub fn search_summary(name: &str, planned: &Planned) -> String {
    let mut text = format!("{name}: {}", planned.description);
    if planned.result == PlanResult::Found {
        add(
            &mut text,
            "plan",
            &format!(
                "{} steps, {} waypoints, {} chunks",
                planned.steps, planned.waypoints, planned.chunks
            ),
        );
        if let Some(walk) = &planned.walk {
            add(&mut text, "walk", &walk.describe());
        }
        if let Some(improved) = &planned.improved {
            add(&mut text, "improved", &improved.describe());
        }
    }
    explain(planned.diagnosis.as_deref(), &mut |name, content| add(&mut text, name, &content));
    add(
        &mut text,
        "search",
        &format!("{:.3} s, {} work units", planned.plan_seconds, planned.work),
    );
    text
}

fn add(text: &mut String, name: &str, content: &str) {
    let _ = write!(text, "\n  {name:<10} {content}");
}

/// The diagnosis of a search without a plan.
fn explain(diagnosis: Option<&Diagnosis>, line: &mut dyn FnMut(&str, String)) {
    let Some(diagnosis) = diagnosis else { return };
    line("routes", routes(diagnosis));
    if let Some(bottleneck_found) = &diagnosis.bottleneck {
        line("bottleneck", bottleneck(bottleneck_found));
    }
    if !diagnosis.rejections.is_empty() {
        line("rejected", rejected(&diagnosis.rejections));
    }
    if let Some(colliding) = &diagnosis.colliding {
        line("collides", colliding.describe());
    }
}

fn headline(report: &Report) -> String {
    let found = report.description();
    match report.delivery_result() {
        None => found.to_owned(),
        Some(DeliveryResult::Accepted) => format!("{found}, walked and accepted"),
        Some(DeliveryResult::Incomplete) => {
            format!("{found}; the robot stands where the chunks made before lead")
        }
        Some(DeliveryResult::Refused) => format!("{found}, but refused by the controller"),
        Some(DeliveryResult::Superseded) => {
            format!("{found}, but another planner has replanned")
        }
        Some(DeliveryResult::ControllerLost) => format!("{found}, but no controller answers"),
        Some(DeliveryResult::Contradicted) => format!("{found}, delivery contradicted"),
        Some(DeliveryResult::Stopped) => format!("{found}, delivery stopped"),
    }
}

fn routes(diagnosis: &Diagnosis) -> String {
    if diagnosis.used_straight_line {
        return "no guide route reaches the goal (missing clearance, foothold or step); a straight route was tried"
            .to_owned();
    }
    format!("{} tried", diagnosis.routes)
}

fn bottleneck(Bottleneck { xyz: [x, y, z], failures }: &Bottleneck) -> String {
    format!("most often near x {x:.2}, y {y:.2}, z {z:.2} m: {failures} sequences failed there")
}

/// The most frequent reasons, as shares of all rejections.
pub(crate) fn rejected(rejections: &BTreeMap<String, u64>) -> String {
    let total: u64 = rejections.values().sum();
    let mut reasons: Vec<_> = rejections.iter().collect();
    reasons.sort_by_key(|(_, count)| std::cmp::Reverse(**count));
    let share = |count: u64| 100.0 * count as f64 / total as f64;
    let shown = reasons
        .iter()
        .take(REASONS_SHOWN)
        .map(|(reason, count)| format!("{reason} {:.0} %", share(**count)));
    shown.collect::<Vec<String>>().join(", ")
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
    let in_flight = match chunks.in_flight {
        0 => String::new(),
        number => format!(", {number} on their way"),
    };
    let kinds = [(chunks.damaged, "damaged"), (chunks.other_senders, "of other senders")];
    let dropped = kinds.into_iter().filter(|(number, _)| *number > 0);
    let dropped: String =
        dropped.map(|(number, which)| format!(", {number} {which} and dropped")).collect();
    let feedback = match chunks.feedback_dropped {
        0 => String::new(),
        1 => ", 1 feedback message of another sender dropped".to_owned(),
        number => format!(", {number} feedback messages of other senders dropped"),
    };
    let checked =
        report.check_seconds.map(|time| format!(", checked in {time:.3} s")).unwrap_or_default();
    format!(
        "{} sent, {} accepted{in_flight}, {} lost, {} duplicated{dropped}{feedback}{checked}",
        chunks.sent, chunks.accepted, chunks.lost, chunks.duplicated
    )
}
