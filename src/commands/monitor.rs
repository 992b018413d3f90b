//! `surefoot monitor`: subscribes to the messages of an instance and prints them.

pub mod statistics;

mod motion;
mod seen_plan;

use std::time::Duration;

use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::observer::Observer;

use crate::cli::arguments::MonitorArguments;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::clock::Stopwatch;
use crate::system::{signals, terminal};

use crate::commands::monitor::statistics::{MonitorEvent, MonitorStats};

/// Time between two polls. It is short enough that no reader's buffer overflows during a walk.
const POLL_INTERVAL: Duration = Duration::from_micros(500);
/// Time between two summaries, s.
const SUMMARY_SECONDS: f64 = 1.0;
/// An instance without messages for this long has ended, s.
const SILENCE_SECONDS_MAX: f64 = 5.0;

/// Runs the command.
///
/// # Errors
/// There is no such instance, the transport fails, or a signal comes.
pub fn run(arguments: &MonitorArguments) -> Result<CommandOutcome, CommandError> {
    CommandError::unless_limited()?;
    let _deferral = signals::defer();
    let name = match &arguments.instance {
        Some(name) => name.clone(),
        None => only_instance(&Instance::running()?)?,
    };
    let instance =
        if arguments.create { Instance::create(&name)? } else { Instance::attach(&name)? };
    let observer = Observer::open(&instance)?;
    let mut monitor =
        Monitor { observer, json: arguments.json, stats: MonitorStats::default(), summary_at: 0.0 };
    monitor.run(arguments.seconds.unwrap_or(f64::INFINITY))
}

struct Monitor {
    observer: Observer,
    /// Whether events are printed as JSON.
    json: bool,
    stats: MonitorStats,
    /// Time of the last summary, s.
    summary_at: f64,
}

impl Monitor {
    /// Prints messages until the instance is silent, `seconds` have passed, or a signal comes.
    fn run(&mut self, seconds: f64) -> Result<CommandOutcome, CommandError> {
        let watch = Stopwatch::start();
        let mut received_at = 0.0;
        loop {
            let now = watch.seconds();
            if self.receive(now)? {
                received_at = now;
            }
            let is_silent =
                self.observer.publisher_count() == 0 || now - received_at > SILENCE_SECONDS_MAX;
            if (is_silent && self.stats.has_received()) || now >= seconds {
                self.print_summary(now);
                return Ok(CommandOutcome::Done);
            }
            if let Some(signal) = signals::raised() {
                self.print_summary(now);
                return Err(CommandError::Interrupted(signal));
            }
            if now - self.summary_at >= SUMMARY_SECONDS {
                self.print_summary(now);
            }
            std::thread::sleep(POLL_INTERVAL);
        }
    }

    /// Reads all new messages. Returns whether there was one.
    fn receive(&mut self, now: f64) -> Result<bool, CommandError> {
        let mut received = false;
        while let Some(description) = self.observer.description()? {
            self.stats.record_description(description);
        }
        while let Some(chunk) = self.observer.chunk()? {
            received = true;
            let events = self.stats.record_chunk(&chunk, now);
            self.print(&events);
        }
        while let Some(feedback) = self.observer.feedback()? {
            received = true;
            let events = self.stats.record_feedback(&feedback, now);
            self.print(&events);
        }
        while let Some(state) = self.observer.state()? {
            received = true;
            self.stats.record_state(&state);
        }
        while let Some(status) = self.observer.status()? {
            received = true;
            let event = self.stats.record_status(&status, now);
            self.print(event.as_slice());
        }
        Ok(received)
    }

    fn print_summary(&mut self, now: f64) {
        let missed = self.observer.missed_chunks();
        let summary = self.stats.summary(now, now - self.summary_at, missed);
        self.summary_at = now;
        self.print(&[summary]);
    }

    fn print(&self, events: &[MonitorEvent]) {
        for event in events {
            terminal::print_result(&if self.json { event.json() } else { event.line() });
        }
    }
}

fn only_instance(running: &[String]) -> Result<String, CommandError> {
    match running {
        [name] => Ok(name.clone()),
        [] => Err(CommandError::Usage(
            "no instance is running; start one, or name it with --instance".into(),
        )),
        several => Err(CommandError::Usage(format!(
            "several instances are running; choose one with --instance: {}",
            several.join(", ")
        ))),
    }
}
