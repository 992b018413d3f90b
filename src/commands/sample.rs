//! `surefoot sample`: plays the accepted plan of an instance in real time and publishes set-points
//! for a joint controller; with `--loads` also contact wrenches, with `--ros` ROS 2 messages.

mod foot_schedule;
mod playback;
mod ros_topics;
mod sampled_loads;

use std::time::Duration;

use surefoot_shared_types::instance::observer::Observer;
use surefoot_shared_types::instance::sender::random_id;
use surefoot_shared_types::instance::set_points::SetPointPublisher;
use surefoot_shared_types::instance::{ChannelError, Instance};
use surefoot_shared_types::message::PlanChunk;

use crate::cli::arguments::SampleArguments;
use crate::commands::sample::playback::{Playback, PlaybackCounts};
use crate::commands::sample::ros_topics::RosTopics;
use crate::commands::sample::sampled_loads::SampledLoads;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::clock::Stopwatch;
use crate::system::{signals, terminal};

/// Time between two polls. A walk sends at most eight chunks before the sampler must have read
/// one.
const POLL_INTERVAL: Duration = Duration::from_micros(400);
/// Longest delay of the process that is made up for, s; after a longer one plan time has stood.
const LATE_SECONDS_MAX: f64 = 0.1;

/// Runs the command.
///
/// # Errors
/// There is no such instance, the transport fails, a chunk was missed, or a signal comes.
pub fn run(arguments: &SampleArguments) -> Result<CommandOutcome, CommandError> {
    CommandError::unless_limited()?;
    let _deferral = signals::defer();
    let loads = arguments.loads.as_deref().map(SampledLoads::load).transpose()?;
    let instance = attach(arguments)?;
    let observer = Observer::open(&instance)?;
    let publisher = SetPointPublisher::open(observer.participant())?;
    let ros = arguments.ros.then(|| RosTopics::open(observer.participant())).transpose()?;
    terminal::print_result(&format!("attached to {}", arguments.instance));
    let mut sampler = Sampler {
        observer,
        publisher,
        ros,
        loads,
        playback: Playback::default(),
        pace: Pace::new(arguments.hz, arguments.rate),
        id: random_id(),
        has_received: false,
    };
    let ended = sampler.run(arguments.seconds.unwrap_or(f64::INFINITY));
    let counts = sampler.playback.counts();
    terminal::print_result(&summary(&counts, arguments.hz));
    match ended? {
        () if counts.missed > 0 => Err(CommandError::MissedChunks { missed: counts.missed }),
        () => Ok(CommandOutcome::Done),
    }
}

/// Attaches to the instance; waits for it as long as the arguments say.
fn attach(arguments: &SampleArguments) -> Result<Instance, CommandError> {
    let watch = Stopwatch::start();
    let mut may_wait = || watch.seconds() < arguments.wait && signals::raised().is_none();
    let attached = Instance::attach_once_made(&arguments.instance, &mut may_wait);
    CommandError::unless_interrupted()?;
    Ok(attached?)
}

fn summary(counts: &PlaybackCounts, hz: f64) -> String {
    let PlaybackCounts { ticks, starved_ticks, missed } = *counts;
    let [played, starved] = [ticks, starved_ticks].map(|ticks| ticks as f64 / hz);
    format!(
        "{ticks} set-points, {played:.2} s; {starved:.2} s without a chunk; {missed} chunks missed"
    )
}

struct Sampler {
    observer: Observer,
    publisher: SetPointPublisher,
    ros: Option<RosTopics>,
    loads: Option<SampledLoads>,
    playback: Playback,
    pace: Pace,
    id: u64,
    has_received: bool,
}

impl Sampler {
    /// Publishes until the walk is over and played, `seconds` have passed, or a signal comes.
    fn run(&mut self, seconds: f64) -> Result<(), CommandError> {
        let watch = Stopwatch::start();
        loop {
            self.receive()?;
            for _ in 0..self.pace.ticks_due() {
                self.publish()?;
            }
            self.publisher.refill()?;
            let is_over = self.has_received
                && self.observer.publisher_count() == 0
                && self.playback.is_idle();
            if is_over || watch.seconds() >= seconds {
                return Ok(());
            }
            CommandError::unless_interrupted()?;
            std::thread::sleep(POLL_INTERVAL);
        }
    }

    /// Reads all new messages.
    fn receive(&mut self) -> Result<(), CommandError> {
        while let Some(chunk) = self.observer.chunk()? {
            self.has_received = true;
            self.playback.receive(&chunk);
        }
        if let Some(description) = self.observer.description()? {
            self.loads.as_ref().map_or(Ok(()), |loads| loads.check(&description))?;
            self.ros.as_mut().map_or(Ok(()), |ros| ros.describe(&description))?;
        }
        while let Some(feedback) = self.observer.feedback()? {
            self.playback.accept(&feedback);
        }
        let Some(ros) = self.ros.as_mut().filter(|ros| ros.is_described()) else { return Ok(()) };
        let mut result: Result<(), ChannelError> = Ok(());
        self.playback.take_announced(&mut |chunk: &PlanChunk, seconds| {
            if result.is_ok() {
                result = ros.publish_chunk(chunk, seconds);
            }
        });
        Ok(result?)
    }

    /// Publishes the next set-point; nothing before the first plan.
    fn publish(&mut self) -> Result<(), CommandError> {
        let Some(mut point) = self.playback.advance(self.id, self.pace.tick_seconds) else {
            return Ok(());
        };
        if let (Some(loads), Some(chunk)) = (&mut self.loads, self.playback.chunk_of(&point)) {
            loads.add(chunk, &mut point);
        }
        self.publisher.publish(&point)?;
        match &mut self.ros {
            Some(ros) => Ok(ros.publish_state(&point)?),
            None => Ok(()),
        }
    }
}

/// Keeps the ticks in step with real time.
struct Pace {
    watch: Stopwatch,
    /// Plan time between two ticks at full speed, s.
    tick_seconds: f64,
    /// Ticks each second of real time.
    ticks_per_second: f64,
    /// Ticks since the watch was started.
    ticks: u64,
}

impl Pace {
    fn new(hz: f64, rate: f64) -> Self {
        Self {
            watch: Stopwatch::start(),
            tick_seconds: 1.0 / hz,
            ticks_per_second: hz * rate,
            ticks: 0,
        }
    }

    /// The number of ticks that are due and not counted yet.
    fn ticks_due(&mut self) -> u64 {
        let due = (self.watch.seconds() * self.ticks_per_second) as u64;
        let late_max = (LATE_SECONDS_MAX * self.ticks_per_second) as u64;
        let count = (due - self.ticks).min(late_max.max(1));
        self.ticks = due;
        count
    }
}
