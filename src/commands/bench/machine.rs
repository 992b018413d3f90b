//! The machine and the program of a measurement.

use std::fmt::Write;

use serde::Serialize;
use surefoot_shared_types::base::digest::Digest;

use crate::report::command_error::CommandError;
use crate::system::cores;

/// The machine and the program.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Machine {
    /// The processor's name.
    pub processor: String,
    /// Cores that this process may use.
    pub cores: usize,
    /// Memory, MiB.
    pub memory_mib: u64,
    /// The kernel's version.
    pub kernel: String,
    /// Load average of the last minute before the bench began. More than a fraction of the cores
    /// disturbs the measurement.
    pub load: Option<f64>,
    /// The program's version.
    pub version: &'static str,
    /// SHA-256 of the program's file.
    pub program: String,
    /// Whether the program was built with optimisation.
    pub optimised: bool,
}

impl Machine {
    /// This machine and this program.
    ///
    /// # Errors
    /// When the program's own file cannot be read.
    pub fn this() -> Result<Self, CommandError> {
        let file = std::env::current_exe().unwrap_or_default();
        let program = std::fs::read(&file).map_err(|error| CommandError::Output {
            path: file,
            reason: format!("not even read: {error}"),
        })?;
        let field = |path, name| field(&read(path), name);
        let kib = field("/proc/meminfo", "MemTotal")
            .and_then(|value| value.split_whitespace().next()?.parse::<u64>().ok());
        Ok(Self {
            processor: field("/proc/cpuinfo", "model name")
                .unwrap_or_else(|| "unknown processor".to_owned()),
            cores: cores::cores(),
            memory_mib: kib.unwrap_or(0) / 1024,
            kernel: read("/proc/sys/kernel/osrelease").trim().to_owned(),
            load: read("/proc/loadavg")
                .split_whitespace()
                .next()
                .and_then(|load| load.parse().ok()),
            version: env!("CARGO_PKG_VERSION"),
            program: Digest::of(&[&program]).to_string(),
            optimised: !cfg!(debug_assertions),
        })
    }

    /// The program: version, commit, and the beginning of its file's digest.
    pub fn build(&self) -> String {
        let commit = env!("SUREFOOT_COMMIT");
        format!("surefoot {} ({commit}, {})", self.version, &self.program[..12])
    }

    /// One line of text.
    pub fn describe(&self) -> String {
        let mut text = format!(
            "{}, {} cores, {} MiB, Linux {}; surefoot {} ({})",
            self.processor,
            self.cores,
            self.memory_mib,
            self.kernel,
            self.version,
            &self.program[..12]
        );
        if let Some(load) = self.load {
            let _ = write!(text, "; load {load:.2} before the bench");
        }
        if !self.optimised {
            text.push_str("; a DEBUG build: its times mean nothing");
        }
        text
    }
}

fn read(path: &str) -> String {
    std::fs::read_to_string(path).unwrap_or_default()
}

/// The value of the first line `name : value`.
fn field(text: &str, name: &str) -> Option<String> {
    let mut lines = text.lines().filter_map(|line| line.split_once(':'));
    lines.find(|(found, _)| found.trim() == name).map(|(_, value)| value.trim().to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn fields_are_found_by_name() {
        let text = "vendor_id\t: A\nmodel name\t: B 7: turbo\nmodel name\t: C\n";
        assert_eq!(field(text, "model name").as_deref(), Some("B 7: turbo"));
        assert_eq!(field(text, "model"), None);
    }

    #[test]
    fn this_machine_has_a_name_and_memory() {
        let machine = Machine::this().unwrap();
        assert!(
            machine.cores > 0 && machine.memory_mib > 0 && machine.program.len() == 64,
            "{machine:?}"
        );
        assert!(machine.describe().contains(&machine.kernel));
    }
}
