//! How long a process has emitted no event, without the time that it waited for a processor.

use std::fs;

use crate::system::clock::Stopwatch;

/// Longest silence of a process that has emitted an event, s. It emits one every second.
const SECONDS_MAX: f64 = 20.0;
/// Longest silence before the first event, s: the process reads its inputs and prepares the robot.
const STARTING_SECONDS_MAX: f64 = 300.0;

/// Time since a process's start or its last event.
#[derive(Debug)]
pub(crate) struct Silence {
    process: u32,
    watch: Stopwatch,
    /// What the process had waited for a processor when the silence began, s.
    waited_before: f64,
    seconds_max: f64,
}

impl Silence {
    /// The silence of a process that starts.
    pub(crate) fn of_start(process: u32) -> Self {
        Self {
            process,
            watch: Stopwatch::start(),
            waited_before: processor_wait(process),
            seconds_max: STARTING_SECONDS_MAX,
        }
    }

    /// Begins anew, at an event.
    pub(crate) fn end(&mut self) {
        *self = Self { seconds_max: SECONDS_MAX, ..Self::of_start(self.process) };
    }

    /// The longest silence, if this one is longer, s.
    pub(crate) fn exceeded(&self) -> Option<f64> {
        if self.watch.seconds() <= self.seconds_max {
            return None;
        }
        let waited = processor_wait(self.process) - self.waited_before;
        is_longer(self.watch.seconds(), waited, self.seconds_max).then_some(self.seconds_max)
    }
}

fn is_longer(seconds: f64, waited: f64, seconds_max: f64) -> bool {
    seconds - waited.max(0.0) > seconds_max
}

/// How long a process's first thread has been ready to run without a processor, s; 0 where the
/// system does not say.
fn processor_wait(process: u32) -> f64 {
    let text = fs::read_to_string(format!("/proc/{process}/schedstat")).unwrap_or_default();
    let nanoseconds: Option<f64> =
        text.split_whitespace().nth(1).and_then(|text| text.parse().ok());
    nanoseconds.map_or(0.0, |nanoseconds| 1e-9 * nanoseconds)
}

#[cfg(test)]
mod tests {
    use super::{is_longer, processor_wait};

    #[test]
    fn time_without_a_processor_is_no_silence() {
        assert!(is_longer(21.0, 0.0, 20.0));
        assert!(!is_longer(100.0, 90.0, 20.0));
        assert!(is_longer(120.0, 90.0, 20.0));
        // The kernel's counter of another process that got the number.
        assert!(is_longer(21.0, -5.0, 20.0));
    }

    #[test]
    fn the_wait_of_this_process_grows_and_of_no_process_is_none() {
        let before = processor_wait(std::process::id());
        assert!(before >= 0.0 && processor_wait(std::process::id()) >= before);
        assert_eq!(processor_wait(u32::MAX), 0.0);
    }
}
