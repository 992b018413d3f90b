//! Times small functions in batches.

use std::hint::black_box;
use std::time::Instant;

use serde::Serialize;
use surefoot::commands::bench::statistics::Summary;

/// Batches of a measurement.
const BATCHES: usize = 41;
/// Shortest duration of a batch, s; much longer than reading the clock.
const BATCH_SECONDS: f64 = 2e-3;
/// Most calls of a batch.
const CALLS_MAX: usize = 1 << 20;

/// A kernel's measured cost.
#[derive(Debug, Serialize)]
pub struct Kernel {
    /// Its name.
    pub name: String,
    /// Batches.
    pub trials: usize,
    /// Calls of a batch.
    pub calls: usize,
    /// Nanoseconds per call: median of the batches.
    pub median_ns: f64,
    /// Nanoseconds per call: the fastest batch.
    pub best_ns: f64,
    /// Seconds per call: mean, standard deviation and percentiles over the batches.
    pub mean_seconds: f64,
    pub std_seconds: f64,
    pub p50_seconds: f64,
    pub p95_seconds: f64,
    pub max_seconds: f64,
    /// Work units per call, if a call counts as work.
    pub mean_work: Option<f64>,
    /// Valid results per second, if not every call has one.
    pub per_second: Option<f64>,
    /// A remark, such as the share of valid results.
    pub note: String,
}

/// Times a function. Its argument is the index of the call in its batch; its result is the work of
/// the call.
pub fn time(name: impl Into<String>, mut call: impl FnMut(usize) -> u64) -> Kernel {
    let mut batch = |calls: usize| {
        let begin = Instant::now();
        let work: u64 = (0..calls).map(|index| black_box(call(index))).sum();
        (begin.elapsed().as_secs_f64(), work)
    };
    let mut calls = 1;
    while batch(calls).0 < BATCH_SECONDS && calls < CALLS_MAX {
        calls *= 2;
    }
    let batches: Vec<(f64, u64)> = (0..BATCHES).map(|_| batch(calls)).collect();
    let per_call: Vec<f64> = batches.iter().map(|(seconds, _)| seconds / calls as f64).collect();
    let best = per_call.iter().copied().fold(f64::INFINITY, f64::min);
    let Summary { mean, std, p50, p95, max, .. } = Summary::of(&per_call).unwrap();
    let work = batches.iter().map(|(_, work)| work).sum::<u64>() as f64 / (BATCHES * calls) as f64;
    Kernel {
        name: name.into(),
        trials: BATCHES,
        calls,
        median_ns: 1e9 * p50,
        best_ns: 1e9 * best,
        mean_seconds: mean,
        std_seconds: std,
        p50_seconds: p50,
        p95_seconds: p95,
        max_seconds: max,
        mean_work: (work > 0.0).then_some(work),
        per_second: None,
        note: String::new(),
    }
}

impl Kernel {
    /// The same kernel with a note.
    pub fn noted(self, note: impl Into<String>) -> Self {
        Self { note: note.into(), ..self }
    }

    /// One line of the table.
    pub fn line(&self) -> String {
        let work = self.mean_work.map_or("-".to_owned(), |work| format!("{work:.1}"));
        format!(
            "{:<52}{:>12.0}{:>12.0}{:>10}  {}",
            self.name, self.median_ns, self.best_ns, work, self.note
        )
    }
}
