//! The rows of several methods, as a table, JSON and CSV.

use std::fmt::Write;
use std::path::Path;

use serde::Serialize;

use crate::commands::bench::machine::Machine;
use crate::commands::bench::methods::method_row::MethodRow;
use crate::commands::bench::table::{aligned, count, seconds};
use crate::input::output_files;
use crate::report::command_error::CommandError;

/// Everything that was measured.
#[derive(Debug, Serialize)]
pub struct MethodReport {
    /// Name and version of the report's format.
    pub schema: &'static str,
    /// The machine.
    pub machine: Machine,
    /// Work limit of each search, units.
    pub work_max: u64,
    /// A row for each scenario and method.
    pub rows: Vec<MethodRow>,
}

impl MethodReport {
    /// Writes `name.json` and `name.csv` into a folder.
    ///
    /// # Errors
    /// When a file cannot be written.
    pub fn save(&self, folder: &Path, name: &str) -> Result<(), CommandError> {
        output_files::write_json(self, &folder.join(format!("{name}.json")))?;
        output_files::write_text(&self.csv(), &folder.join(format!("{name}.csv")))
    }

    /// A table of the rows.
    pub fn table(&self) -> String {
        let head = [
            "scenario",
            "method",
            "rho/R_max",
            "growth",
            "found",
            "time",
            "work",
            "steps",
            "otherwise",
        ];
        let cells = |row: &MethodRow| {
            let text = |number: Option<f64>| number.map_or("-".to_owned(), |it| it.to_string());
            vec![
                row.scenario.clone(),
                row.method.clone(),
                text(row.disc_radius_share),
                text(row.disc_radius_growth),
                format!("{}/{}", row.found, row.trials),
                seconds(row.mean_seconds),
                count(row.mean_work),
                count(row.mean_steps),
                row.failures(),
            ]
        };
        let head = head.map(str::to_owned).to_vec();
        aligned(&std::iter::once(head).chain(self.rows.iter().map(cells)).collect::<Vec<_>>())
    }

    fn csv(&self) -> String {
        let number = |value: Option<f64>| value.map_or(String::new(), |value| value.to_string());
        let mut text =
            "scenario,method,rho_share,rho_growth,trials,found,mean_seconds,mean_work,mean_steps,\
                        checked,refused,otherwise\n"
                .to_owned();
        for row in &self.rows {
            let _ = writeln!(
                text,
                "{},{},{},{},{},{},{},{},{},{},{},{}",
                row.scenario,
                row.method,
                number(row.disc_radius_share),
                number(row.disc_radius_growth),
                row.trials,
                row.found,
                number(row.mean_seconds),
                number(row.mean_work),
                number(row.mean_steps),
                row.checked,
                row.refused,
                row.failures().replace(',', ";"),
            );
        }
        text
    }
}
