//! What became of the changed plans.

use std::collections::BTreeMap;

use serde::Serialize;

use super::kinds::{KINDS, Kind};
use crate::commands::bench::table::aligned;

/// Everything that is reported.
#[derive(Debug, Serialize)]
pub(super) struct MutationsReport {
    pub(super) schema: &'static str,
    pub(super) seed: u64,
    /// The plans that were changed, each accepted as it was.
    pub(super) plans: Vec<String>,
    pub(super) kinds: Vec<KindCounts>,
    /// The changed plans that were accepted.
    pub(super) accepted: Vec<AcceptedPlan>,
}

/// What became of the plans changed in one way.
#[derive(Debug, Serialize)]
pub(super) struct KindCounts {
    pub(super) kind: &'static str,
    pub(super) unit: &'static str,
    pub(super) changed: u64,
    pub(super) refused: u64,
    /// The largest change that was accepted.
    pub(super) largest_accepted: Option<f64>,
    /// The smallest change that was refused.
    pub(super) smallest_refused: Option<f64>,
    /// Refusals by the check that is violated first.
    pub(super) by_check: BTreeMap<String, u64>,
}

/// A changed plan that was accepted.
#[derive(Debug, Serialize)]
pub(super) struct AcceptedPlan {
    /// Its number.
    pub(super) number: u64,
    pub(super) plan: String,
    pub(super) kind: &'static str,
    pub(super) size: f64,
    /// Whether every change of this size must be refused.
    pub(super) is_wrong: bool,
}

impl MutationsReport {
    /// Before any plan is changed.
    pub(super) fn new(seed: u64) -> Self {
        let counts = |kind: &Kind| KindCounts {
            kind: kind.name,
            unit: kind.unit,
            changed: 0,
            refused: 0,
            largest_accepted: None,
            smallest_refused: None,
            by_check: BTreeMap::new(),
        };
        Self {
            schema: "surefoot-bench-mutations/1",
            seed,
            plans: Vec::new(),
            kinds: KINDS.iter().map(counts).collect(),
            accepted: Vec::new(),
        }
    }

    /// Adds a plan changed in the way `kind`; `refusal` is the check that it violates.
    pub(super) fn add(
        &mut self,
        kind: usize,
        refusal: Option<String>,
        (number, plan, size): (u64, &str, f64),
    ) {
        let counts = &mut self.kinds[kind];
        counts.changed += 1;
        if let Some(check) = refusal {
            counts.refused += 1;
            *counts.by_check.entry(check).or_default() += 1;
            let smallest = counts.smallest_refused.unwrap_or(size);
            counts.smallest_refused = Some(smallest.min(size));
            return;
        }
        counts.largest_accepted = Some(counts.largest_accepted.unwrap_or(size).max(size));
        let Kind { name, refused_from, .. } = KINDS[kind];
        let is_wrong = size >= refused_from;
        self.accepted.push(AcceptedPlan { number, plan: plan.into(), kind: name, size, is_wrong });
    }

    /// Whether a plan was accepted although its change is so large that it must be refused.
    pub(super) fn has_wrong(&self) -> bool {
        self.accepted.iter().any(|accepted| accepted.is_wrong)
    }

    /// As a table.
    pub(super) fn text(&self) -> String {
        let head = ["change", "plans", "refused", "smallest refused", "largest accepted", "checks"];
        let row = |counts: &KindCounts| {
            let size = |size: Option<f64>| {
                size.map_or("-".into(), |size| format!("{size:.3} {}", counts.unit))
            };
            let checks = counts.by_check.iter().map(|(check, count)| format!("{check} {count}"));
            vec![
                counts.kind.to_owned(),
                counts.changed.to_string(),
                counts.refused.to_string(),
                size(counts.smallest_refused),
                size(counts.largest_accepted),
                checks.collect::<Vec<_>>().join(", "),
            ]
        };
        let rows = std::iter::once(head.map(str::to_owned).to_vec())
            .chain(self.kinds.iter().map(row))
            .collect::<Vec<_>>();
        let changed: u64 = self.kinds.iter().map(|counts| counts.changed).sum();
        let wrong = self.accepted.iter().filter(|accepted| accepted.is_wrong);
        let wrong = wrong.map(|AcceptedPlan { number, plan, kind, size, .. }| {
            format!("\naccepted and must be refused: number {number}, {plan}, {kind} by {size:.3}")
        });
        format!(
            "{}\n{changed} changed plans of {}: {} refused, {} accepted{}",
            aligned(&rows),
            self.plans.join(", "),
            changed - self.accepted.len() as u64,
            self.accepted.len(),
            wrong.collect::<String>()
        )
    }
}
