//! `surefoot monitor`: subscribes to the messages of an instance and prints them.

pub mod statistics;

mod motion;

use std::time::Duration;

use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::observer::Observer;

use crate::cli::arguments::MonitorArguments;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::clock::Stopwatch;
use crate::system::{signals, terminal};

use crate::commands::monitor::statistics::{MonitorEvent, MonitorStats};

/// Time between two looks; short enough that no reader's buffer overflows at the rates of a walk.
const POLL_INTERVAL: Duration = Duration::from_micros(500);
/// Time between two summaries, s.
const SUMMARY_SECONDS: f64 = 1.0;
/// An instance without messages for this long is over, s.
const SILENCE_SECONDS_MAX: f64 = 5.0;

/// Runs the command.
///
/// # Errors
/// When there is no such instance, the transport fails, or a signal comes.
pub fn run(arguments: &MonitorArguments) -> Result<CommandOutcome, CommandError> {
    signals::install();
    let name = match &arguments.instance {
        Some(name) => name.clone(),
        None => only_instance(&Instance::running()?)?,
    };
    let observer = Observer::open(&Instance::attach(&name)?)?;
    let print = |event: &MonitorEvent| {
        terminal::print_result(&if arguments.json { event.json() } else { event.line() })
    };
    let mut stats = MonitorStats::default();
    let watch = Stopwatch::start();
    let (mut received_at, mut summed_up_at) = (0.0, 0.0);
    loop {
        let now = watch.seconds();
        let mut received = false;
        while let Some(chunk) = observer.chunk()? {
            received = true;
            stats.record_chunk(&chunk, now).iter().for_each(print);
        }
        while let Some(feedback) = observer.feedback()? {
            received = true;
            stats.record_feedback(&feedback, now).iter().for_each(print);
        }
        while let Some(state) = observer.state()? {
            received = true;
            stats.record_state(&state);
        }
        while let Some(status) = observer.status()? {
            received = true;
            stats.record_status(&status, now).iter().for_each(print);
        }
        if received {
            received_at = now;
        }
        let over = observer.publisher_count() == 0 || now - received_at > SILENCE_SECONDS_MAX;
        if (over && stats.has_received()) || arguments.seconds.is_some_and(|seconds| now >= seconds)
        {
            print(&stats.summary(now, now - summed_up_at));
            return Ok(CommandOutcome::Done);
        }
        if let Some(signal) = signals::raised() {
            print(&stats.summary(now, now - summed_up_at));
            return Err(CommandError::Interrupted(signal));
        }
        if now - summed_up_at >= SUMMARY_SECONDS {
            print(&stats.summary(now, now - summed_up_at));
            summed_up_at = now;
        }
        std::thread::sleep(POLL_INTERVAL);
    }
}

fn only_instance(running: &[String]) -> Result<String, CommandError> {
    match running {
        [name] => Ok(name.clone()),
        [] => Err(CommandError::Usage(
            "no pair is running; start one, or name its instance with --instance".into(),
        )),
        several => Err(CommandError::Usage(format!(
            "several pairs are running; choose one with --instance: {}",
            several.join(", ")
        ))),
    }
}
