//! The facts of a run's report: how it ended, how far its search came, and what turned it down.

use serde_json::Value;

use crate::report::event::CollidingLinks;

/// Rejection reasons and what each says about robot and world.
const REASONS: [(&str, &str); 7] = [
    (
        "unreachable",
        "a leg does not reach: footholds further apart or higher than its joints allow",
    ),
    ("balance", "the centre of mass leaves the support: too little or too small ground"),
    ("torque", "a joint needs more than [planner] effort_share of its effort limit"),
    ("collision", "the robot touches the world, or comes closer than [planner] clearance"),
    ("self_collision", "the robot touches itself"),
    ("foot_drift", "a stance foot would move"),
    ("discontinuous", "the motion needs too many steps, or a joint jumps"),
];

/// The facts, one line each; `None` if this is no report.
pub(super) fn lines(report: &Value) -> Option<Vec<String>> {
    let outcome = report.get("outcome")?.as_str()?;
    let text = |name: &str| report.get(name).and_then(Value::as_str).unwrap_or("?");
    let count = |name: &str| report.get(name).and_then(Value::as_u64).unwrap_or(0);
    let mut lines = vec![format!(
        "{} with {} in world {}, seed {}: {}",
        text("scenario"),
        text("robot"),
        text("world"),
        count("seed"),
        outcome.replace('_', " ")
    )];
    let description = report.get("description").and_then(Value::as_str);
    lines.extend(description.filter(|_| count("steps") == 0).map(str::to_owned));
    if let Some(bound) = report.get("bound").and_then(Value::as_str) {
        lines.push(format!("the search ended at its bound {bound}"));
    }
    if count("steps") > 0 {
        let (steps, work) = (count("steps"), count("work"));
        lines.push(format!("the plan has {steps} steps and took {work} units of work"));
    }
    if let Some(diagnosis) = report.get("diagnosis").filter(|there| there.is_object()) {
        lines.extend(diagnosis_lines(diagnosis));
    }
    if let Some(refusal) = report.get("refusal").filter(|there| there.is_object()) {
        let part = |name: &str| refusal.get(name).map(Value::to_string).unwrap_or_default();
        lines.push(format!("refused by the check {}: {}", part("check"), part("detail")));
    }
    Some(lines)
}

fn diagnosis_lines(diagnosis: &Value) -> Vec<String> {
    let mut lines = Vec::new();
    if diagnosis.get("used_straight_line").and_then(Value::as_bool) == Some(true) {
        lines.push(
            "no guide route was found: along a straight line from start to goal, feet were tried"
                .to_owned(),
        );
    }
    if let Some(bottleneck) = diagnosis.get("bottleneck").filter(|there| there.is_object()) {
        let xyz: Vec<f64> = bottleneck
            .get("xyz")
            .and_then(Value::as_array)
            .map(|xyz| xyz.iter().filter_map(Value::as_f64).collect())
            .unwrap_or_default();
        let failures = bottleneck.get("failures").and_then(Value::as_u64).unwrap_or(0);
        if let [x, y, z] = xyz[..] {
            lines.push(format!(
                "most sequences of steps, {failures}, failed near ({x:.2}, {y:.2}, {z:.2}): look \
                 there first"
            ));
        }
    }
    lines.extend(rejection_lines(diagnosis));
    let colliding = diagnosis.get("colliding").cloned();
    let colliding = colliding.and_then(|pair| serde_json::from_value::<CollidingLinks>(pair).ok());
    lines.extend(colliding.map(|pair| pair.describe()));
    lines
}

/// The reasons of rejections, the most frequent first.
fn rejection_lines(diagnosis: &Value) -> Vec<String> {
    let count = |reason: &str| {
        diagnosis.get("rejections").and_then(|counts| counts.get(reason)).and_then(Value::as_u64)
    };
    let mut counted: Vec<(u64, &str, &str)> = REASONS
        .iter()
        .filter_map(|(reason, meaning)| Some((count(reason)?, *reason, *meaning)))
        .filter(|(count, ..)| *count > 0)
        .collect();
    counted.sort_by(|a, b| b.0.cmp(&a.0).then(a.1.cmp(b.1)));
    counted
        .iter()
        .map(|(count, reason, meaning)| format!("rejected {count} times, {reason}: {meaning}"))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;
    use surefoot_planner::constraints::rejection::Rejection;

    #[test]
    fn every_reason_is_explained() {
        assert!(REASONS.iter().map(|(reason, _)| *reason).eq(Rejection::NAMES));
    }

    #[test]
    fn a_report_without_a_plan_names_place_and_reason() {
        let report = json!({
            "outcome": "budget_exhausted", "bound": "work_max", "scenario": "s", "robot": "r",
            "world": "w", "seed": 7, "steps": 0, "work": 9, "description": "no plan: raise it",
            "diagnosis": {
                "used_straight_line": true, "bottleneck": { "xyz": [1.0, 2.0, 0.5], "failures": 3 },
                "rejections": { "balance": 5, "collision": 8, "torque": 0 },
            },
        });
        let lines = lines(&report).unwrap();
        assert_eq!(lines[0], "s with r in world w, seed 7: budget exhausted");
        assert_eq!(lines[1], "no plan: raise it");
        assert_eq!(lines[2], "the search ended at its bound work_max");
        assert!(lines[4].contains("3, failed near (1.00, 2.00, 0.50)"), "{}", lines[4]);
        assert!(lines[5].starts_with("rejected 8 times, collision"), "{}", lines[5]);
        assert_eq!(lines.len(), 7);
        assert_eq!(super::lines(&json!({ "x": 1 })), None);
    }
}
