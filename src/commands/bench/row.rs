//! Statistics of many searches of one scenario.

use std::collections::BTreeMap;

use serde::Serialize;
use surefoot_planner::pipeline::WorkCategory;
use surefoot_shared_types::base::digest::Digest;

use crate::commands::bench::statistics::{Summary, mean};
use crate::commands::bench::table::{aligned, seconds};
use crate::commands::bench::trial::Trial;

/// One row of a bench: the trials of one scenario. Times and work are of the searches that found a
/// plan; null where none did.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Row {
    /// The scenario's name.
    pub scenario: String,
    /// Planner threads.
    pub threads: usize,
    /// Searches made.
    pub trials: usize,
    /// Searches that found a plan.
    pub found: usize,
    /// How many searches had which outcome.
    pub outcomes: BTreeMap<String, usize>,
    /// Mean time of the search, from ready to plan, s.
    pub mean_seconds: Option<f64>,
    /// Its standard deviation, s.
    pub std_seconds: Option<f64>,
    /// Its median, s.
    pub p50_seconds: Option<f64>,
    /// Its 95 % quantile, s.
    pub p95_seconds: Option<f64>,
    /// The slowest, s.
    pub max_seconds: Option<f64>,
    /// Mean processor time of all threads, s. It excludes the time of other processes.
    pub processor_mean_seconds: Option<f64>,
    /// Mean time to get ready, of all searches, s.
    pub ready_mean_seconds: Option<f64>,
    /// Time from the request until the first chunk is final and may be sent: getting ready,
    /// searching, and smoothing and timing as much as it takes. Mean, s.
    pub first_chunk_mean_seconds: Option<f64>,
    /// Its median, s.
    pub first_chunk_p50_seconds: Option<f64>,
    /// Its 95 % quantile, s.
    pub first_chunk_p95_seconds: Option<f64>,
    /// The longest, s.
    pub first_chunk_max_seconds: Option<f64>,
    /// Mean work units.
    pub mean_work: Option<f64>,
    /// Mean work units by stage.
    pub mean_work_by_stage: BTreeMap<String, f64>,
    /// Mean seconds by stage, of the searches that were timed stage by stage.
    pub mean_seconds_by_stage: BTreeMap<String, f64>,
    /// Mean waypoints of a plan.
    pub mean_waypoints: Option<f64>,
    /// Bytes of the planner's arenas, the largest.
    pub arena_bytes: u64,
    /// Plans that the controller checked.
    pub checked: usize,
    /// Plans that they refused.
    pub refused: usize,
    /// Digest of all plans' digests in the order of the seeds: the same searches give the same.
    pub digest: String,
}

impl Row {
    /// The row of some trials of one scenario, in the order of their seeds.
    pub fn of(trials: &[Trial]) -> Self {
        let found: Vec<&Trial> = trials.iter().filter(|trial| trial.is_found()).collect();
        let of_found =
            |value: fn(&Trial) -> f64| found.iter().map(|trial| value(trial)).collect::<Vec<f64>>();
        let seconds = Summary::of(&of_found(|trial| trial.seconds));
        let first_chunk = Summary::of(&of_found(|trial| {
            trial.ready_seconds + trial.first_chunk_seconds.unwrap_or(trial.seconds)
        }));
        let ready: Vec<f64> = trials.iter().map(|trial| trial.ready_seconds).collect();
        let mut outcomes = BTreeMap::new();
        trials.iter().for_each(|trial| *outcomes.entry(trial.outcome.clone()).or_default() += 1);
        let names: Vec<&[u8]> = trials
            .iter()
            .map(|trial| trial.digest.as_ref().unwrap_or(&trial.outcome).as_bytes())
            .collect();
        Self {
            scenario: trials.first().map(|trial| trial.scenario.clone()).unwrap_or_default(),
            threads: trials.first().map_or(0, |trial| trial.threads),
            trials: trials.len(),
            found: found.len(),
            outcomes,
            mean_seconds: seconds.map(|seconds| seconds.mean),
            std_seconds: seconds.map(|seconds| seconds.std),
            p50_seconds: seconds.map(|seconds| seconds.p50),
            p95_seconds: seconds.map(|seconds| seconds.p95),
            max_seconds: seconds.map(|seconds| seconds.max),
            processor_mean_seconds: mean(&of_found(|trial| trial.processor_seconds)),
            ready_mean_seconds: mean(&ready),
            first_chunk_mean_seconds: first_chunk.map(|seconds| seconds.mean),
            first_chunk_p50_seconds: first_chunk.map(|seconds| seconds.p50),
            first_chunk_p95_seconds: first_chunk.map(|seconds| seconds.p95),
            first_chunk_max_seconds: first_chunk.map(|seconds| seconds.max),
            mean_work: mean(&of_found(|trial| trial.work as f64)),
            mean_work_by_stage: mean_by_stage(
                found.iter().map(|trial| as_numbers(&trial.work_by_stage)),
            ),
            mean_seconds_by_stage: mean_by_stage(
                found.iter().filter_map(|trial| trial.seconds_by_stage.clone()),
            ),
            mean_waypoints: mean(&of_found(|trial| trial.waypoints as f64)),
            arena_bytes: trials.iter().map(|trial| trial.arena_bytes).max().unwrap_or(0),
            checked: trials.iter().filter(|trial| trial.check_result.is_some()).count(),
            refused: trials.iter().filter(|trial| trial.is_refused()).count(),
            digest: Digest::of(&names).to_string(),
        }
    }
}

/// A table of the rows' stages: mean time, and share of the work.
pub fn stages<'a>(rows: impl Iterator<Item = &'a Row>) -> String {
    let head = std::iter::once("scenario").chain(WorkCategory::NAMES).map(str::to_owned).collect();
    let cells = rows.filter(|row| row.found > 0).map(|row| {
        let total: f64 = row.mean_work_by_stage.values().sum();
        let stage = |stage: &str| {
            let share =
                row.mean_work_by_stage.get(stage).map_or(0.0, |work| 100.0 * work / total.max(1.0));
            format!("{} {share:.0} %", seconds(row.mean_seconds_by_stage.get(stage).copied()))
        };
        std::iter::once(row.scenario.clone()).chain(WorkCategory::NAMES.map(stage)).collect()
    });
    aligned(&std::iter::once(head).chain(cells).collect::<Vec<Vec<String>>>())
}

fn as_numbers(work: &BTreeMap<String, u64>) -> BTreeMap<String, f64> {
    work.iter().map(|(stage, work)| (stage.clone(), *work as f64)).collect()
}

fn mean_by_stage(trials: impl Iterator<Item = BTreeMap<String, f64>>) -> BTreeMap<String, f64> {
    let mut by_stage: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    trials.flatten().for_each(|(stage, value)| by_stage.entry(stage).or_default().push(value));
    by_stage.into_iter().filter_map(|(stage, values)| Some((stage, mean(&values)?))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn trial(seed: u64, outcome: &str, seconds: f64) -> Trial {
        Trial {
            key: String::new(),
            scenario: "flat".into(),
            seed,
            threads: 2,
            outcome: outcome.into(),
            ready_seconds: 0.5,
            seconds,
            processor_seconds: 2.0 * seconds,
            work: 10 * seed,
            work_by_stage: [("footholds".to_owned(), 10 * seed)].into(),
            seconds_by_stage: (seed == 1).then(|| [("footholds".to_owned(), 0.125)].into()),
            waypoints: 3,
            arena_bytes: seed,
            digest: (outcome == "found").then(|| format!("digest {seed}")),
            check_result: (seed == 2).then(|| "torque".into()),
        }
    }

    #[test]
    fn failures_count_as_trials_but_not_in_times() {
        let trials =
            [trial(1, "found", 1.0), trial(2, "found", 3.0), trial(3, "budget_exhausted", 99.0)];
        let row = Row::of(&trials);
        assert_eq!((row.trials, row.found, row.checked, row.refused), (3, 2, 1, 1));
        assert_eq!(
            (row.mean_seconds, row.max_seconds, row.mean_work),
            (Some(2.0), Some(3.0), Some(15.0))
        );
        assert_eq!(row.processor_mean_seconds, Some(4.0));
        assert_eq!(
            (row.first_chunk_mean_seconds, row.first_chunk_max_seconds),
            (Some(2.5), Some(3.5))
        );
        assert_eq!(row.mean_work_by_stage["footholds"], 15.0);
        assert_eq!(row.mean_seconds_by_stage["footholds"], 0.125);
        assert_eq!(row.outcomes["budget_exhausted"], 1);
    }

    #[test]
    fn the_digest_depends_on_plans_but_not_on_times() {
        let base = [trial(1, "found", 1.0), trial(2, "found", 3.0)];
        let slower = [trial(1, "found", 5.0), trial(2, "found", 9.0)];
        let other = [trial(1, "found", 1.0), trial(2, "arena_full", 3.0)];
        assert_eq!(Row::of(&base).digest, Row::of(&slower).digest);
        assert_ne!(Row::of(&base).digest, Row::of(&other).digest);
    }

    #[test]
    fn without_a_plan_there_are_no_times() {
        let row = Row::of(&[trial(1, "arena_full", 1.0)]);
        assert_eq!(
            (row.found, row.mean_seconds, row.p95_seconds, row.mean_work),
            (0, None, None, None)
        );
    }
}
