//! The report of `surefoot bench thesis`.

use serde::Serialize;

use crate::commands::bench::machine::Machine;
use crate::commands::bench::row::{Row, stages};
use crate::commands::bench::table::{aligned, count, seconds};
use crate::commands::bench::thesis::published::{Published, of_scenario};

/// Limits of the comparison.
const CAVEAT: &str = "The thesis prints no dimension of its worlds: the geometry is our reconstruction. Its times were taken on an Intel Xeon E3-1290 v2 \
                      (3.70 GHz, 16 GB) with a timeout of one hour; ours are of the machine above. A ratio compares whole systems, not algorithms.";

/// The whole report.
#[derive(Debug, Serialize)]
pub struct ThesisReport {
    schema: &'static str,
    machine: Machine,
    caveat: &'static str,
    rows: Vec<ThesisRow>,
}

/// Our row, and the thesis's if it has one.
#[derive(Debug, Serialize)]
struct ThesisRow {
    #[serde(flatten)]
    ours: Row,
    thesis: Option<ThesisFigures>,
}

#[derive(Debug, Serialize)]
struct ThesisFigures {
    table: &'static str,
    name: &'static str,
    mean_seconds: f64,
    std_seconds: f64,
    success: f64,
    /// The thesis's mean time divided by ours.
    speed_ratio: Option<f64>,
}

impl ThesisReport {
    /// The report of some rows.
    pub fn new(machine: Machine, rows: Vec<Row>) -> Self {
        let row = |ours: Row| ThesisRow {
            thesis: of_scenario(&ours.scenario).map(|published| figures(published, &ours)),
            ours,
        };
        Self {
            schema: "surefoot-bench-thesis/1",
            machine,
            caveat: CAVEAT,
            rows: rows.into_iter().map(row).collect(),
        }
    }

    /// Our rows.
    pub fn rows(&self) -> impl Iterator<Item = &Row> {
        self.rows.iter().map(|row| &row.ours)
    }

    /// As JSON.
    pub fn json(&self) -> String {
        serde_json::to_string_pretty(self).unwrap_or_else(|error| error.to_string())
    }

    /// For a person.
    pub fn text(&self) -> String {
        let mut parts = vec![
            format!("machine: {}", self.machine.describe()),
            String::new(),
            CAVEAT.to_owned(),
            String::new(),
        ];
        for (table, title) in [
            (Some("4.1"), "Table 4.1: the five scenarios"),
            (Some("4.2"), "Table 4.2: the parts of the jungle gym"),
            (None, "Not in the thesis"),
        ] {
            let rows: Vec<&ThesisRow> = self
                .rows
                .iter()
                .filter(|row| row.thesis.as_ref().map(|thesis| thesis.table) == table)
                .collect();
            if !rows.is_empty() {
                parts.extend([title.to_owned(), times(&rows), String::new()]);
            }
        }
        parts.extend([
            "Mean time of each stage (searched again stage by stage) and its share of the work"
                .to_owned(),
            stages(self.rows()),
        ]);
        parts.join("\n")
    }
}

fn figures(published: &Published, ours: &Row) -> ThesisFigures {
    ThesisFigures {
        table: published.table,
        name: published.name,
        mean_seconds: published.mean_seconds,
        std_seconds: published.std_seconds,
        success: f64::from(published.found_of_100) / 100.0,
        speed_ratio: ours.mean_seconds.map(|mean| published.mean_seconds / mean),
    }
}

fn times(rows: &[&ThesisRow]) -> String {
    let head = [
        "scenario",
        "thesis s",
        "success",
        "ours",
        "found",
        "p50",
        "p95",
        "max",
        "processor",
        "ready",
        "mean work",
        "ratio",
    ];
    let mut cells = vec![head.map(str::to_owned).to_vec()];
    cells.extend(rows.iter().map(|row| {
        let (ours, thesis) = (&row.ours, row.thesis.as_ref());
        let mut found = format!("{}/{}", ours.found, ours.trials);
        if ours.refused > 0 {
            found.push_str(&format!(" ({} REFUSED)", ours.refused));
        }
        vec![
            ours.scenario.clone(),
            thesis.map_or("-".to_owned(), |thesis| {
                format!("{:.2} ({:.2})", thesis.mean_seconds, thesis.std_seconds)
            }),
            thesis.map_or("-".to_owned(), |thesis| format!("{:.0} %", 100.0 * thesis.success)),
            format!("{} ({})", seconds(ours.mean_seconds), seconds(ours.std_seconds)),
            found,
            seconds(ours.p50_seconds),
            seconds(ours.p95_seconds),
            seconds(ours.max_seconds),
            seconds(ours.processor_mean_seconds),
            seconds(ours.ready_mean_seconds),
            count(ours.mean_work),
            thesis
                .and_then(|thesis| thesis.speed_ratio)
                .map_or("-".to_owned(), |ratio| format!("{ratio:.0} x")),
        ]
    }));
    aligned(&cells)
}
