//! `surefoot monitor`: listens to a pair and prints what passes, without taking part.

mod motion;
mod tally;

use std::time::Duration;

use surefoot_shared_types::instance::Instance;
use surefoot_shared_types::instance::observer::Observer;

use crate::arguments::MonitorArguments;
use crate::clock::Stopwatch;
use crate::failure::{Ending, Failure};
use crate::{signals, terminal};

use tally::{News, Tally};

/// Time between two looks; short enough that no reader's buffer overflows at the rates of a walk.
const LOOK_EVERY: Duration = Duration::from_micros(500);
/// Time between two summaries, s.
const SUMMARY_SECONDS: f64 = 1.0;
/// A pair that says nothing for so long is over, s.
const SILENCE_SECONDS_MAX: f64 = 5.0;

/// Runs the command.
///
/// # Errors
/// When there is no such instance, the transport fails, or a signal comes.
pub fn run(arguments: &MonitorArguments) -> Result<Ending, Failure> {
    signals::install();
    let name = match &arguments.instance {
        Some(name) => name.clone(),
        None => the_only_one(&Instance::living()?)?,
    };
    let observer = Observer::open(&Instance::attach(&name)?)?;
    let say = |news: &News| terminal::say(&if arguments.json { news.json() } else { news.line() });
    let mut tally = Tally::default();
    let watch = Stopwatch::start();
    let (mut heard_at, mut summed_up_at) = (0.0, 0.0);
    loop {
        let now = watch.seconds();
        let mut heard = false;
        while let Some(chunk) = observer.chunk()? {
            heard = true;
            tally.note_chunk(&chunk, now).iter().for_each(say);
        }
        while let Some(word) = observer.feedback()? {
            heard = true;
            tally.note_word(&word, now).iter().for_each(say);
        }
        while let Some(state) = observer.state()? {
            heard = true;
            tally.note_state(&state);
        }
        while let Some(status) = observer.status()? {
            heard = true;
            tally.note_status(&status, now).iter().for_each(say);
        }
        if heard {
            heard_at = now;
        }
        let over = observer.speakers() == 0 || now - heard_at > SILENCE_SECONDS_MAX;
        if (over && tally.has_heard()) || arguments.seconds.is_some_and(|seconds| now >= seconds) {
            say(&tally.summary(now, now - summed_up_at));
            return Ok(Ending::Done);
        }
        if let Some(signal) = signals::raised() {
            say(&tally.summary(now, now - summed_up_at));
            return Err(Failure::Interrupted(signal));
        }
        if now - summed_up_at >= SUMMARY_SECONDS {
            say(&tally.summary(now, now - summed_up_at));
            summed_up_at = now;
        }
        std::thread::sleep(LOOK_EVERY);
    }
}

fn the_only_one(living: &[String]) -> Result<String, Failure> {
    match living {
        [name] => Ok(name.clone()),
        [] => Err(Failure::Usage(
            "no pair is running; start one, or name its instance with --instance".into(),
        )),
        several => Err(Failure::Usage(format!(
            "several pairs are running; choose one with --instance: {}",
            several.join(", ")
        ))),
    }
}
