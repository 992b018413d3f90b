//! Drives a transport: round trips one by one, then as many chunks on their way as it allows.

use std::sync::atomic::{AtomicBool, Ordering};

use surefoot_shared_types::message::feedback::FEEDBACK_SCHEMA;
use surefoot_shared_types::message::{Feedback, PlanChunk};

use crate::commands::bench::statistics::Summary;
use crate::report::command_error::CommandError;
use crate::system::allocations;
use crate::system::clock::Stopwatch;
use crate::system::{cores, signals};

/// The end that sends chunks.
pub(crate) trait Near {
    /// Sends chunk number `number`, counted from 1.
    fn send(&mut self, chunk: &PlanChunk, number: u64) -> Result<(), CommandError>;
    /// The number of the newest chunk that was answered.
    fn answered(&mut self) -> Result<u64, CommandError>;
}

/// The end that answers.
pub(crate) trait Far {
    /// Takes the next chunk out, if one came, and answers it.
    fn serve(&mut self) -> Result<(), CommandError>;
}

/// The measurements.
#[derive(Debug)]
pub(crate) struct Measured {
    /// Each round trip, s.
    pub(crate) round_trips: Vec<f64>,
    /// With many on their way.
    pub(crate) chunks_per_second: f64,
    /// During the round trips.
    pub(crate) allocations: u64,
}

impl Measured {
    /// The statistics of the round trips.
    pub(crate) fn round_trip(&self) -> Summary {
        let none = Summary {
            mean: f64::NAN,
            std: f64::NAN,
            p50: f64::NAN,
            p95: f64::NAN,
            p99: f64::NAN,
            max: f64::NAN,
        };
        Summary::of(&self.round_trips).unwrap_or(none)
    }
}

/// Feedback as a controller would answer.
pub(crate) fn feedback(number: u64) -> Feedback {
    Feedback {
        schema: FEEDBACK_SCHEMA,
        controller_id: 1,
        next_sequence: number,
        ..bytemuck::Zeroable::zeroed()
    }
}

/// A chunk with something in it.
pub(crate) fn chunk() -> PlanChunk {
    let mut chunk: PlanChunk = bytemuck::Zeroable::zeroed();
    bytemuck::bytes_of_mut(&mut chunk)
        .iter_mut()
        .enumerate()
        .for_each(|(at, byte)| *byte = (at % 251) as u8);
    chunk
}

/// Measures a transport of which up to `window` chunks may be on their way. Each end is made on the
/// core where it runs.
pub(crate) fn measure<N: Near, F: Far>(
    rounds: usize,
    window: u64,
    near: impl FnOnce() -> Result<N, CommandError> + Send,
    far: impl FnOnce() -> Result<F, CommandError> + Send,
) -> Result<Measured, CommandError> {
    let over = AtomicBool::new(false);
    let (near_core, far_core) = cores::cores_of_roles(1);
    std::thread::scope(|scope| {
        let served = scope.spawn(|| {
            cores::pin(far_core);
            let mut far = far()?;
            while !over.load(Ordering::Relaxed) {
                far.serve()?;
            }
            Ok(())
        });
        let driven = scope.spawn(|| {
            cores::pin(near_core);
            let driven = near()
                .and_then(|mut near| both(&mut near, rounds, window, &|| served_ended(&over)));
            over.store(true, Ordering::Relaxed);
            driven
        });
        let driven = driven.join().map_err(|_| broken())?;
        served.join().map_err(|_| broken())?.and(driven)
    })
}

fn served_ended(over: &AtomicBool) -> bool {
    over.load(Ordering::Relaxed) || signals::raised().is_some()
}

fn broken() -> CommandError {
    CommandError::Usage("a thread of the bench panicked".into())
}

fn both(
    near: &mut impl Near,
    rounds: usize,
    window: u64,
    is_over: &dyn Fn() -> bool,
) -> Result<Measured, CommandError> {
    let chunk = chunk();
    let mut trips = vec![0.0; rounds];
    let warm = rounds / 4 + 64;
    let mut number = 0;
    run(near, &chunk, &mut number, warm as u64, 1, &mut |_, _| {}, is_over)?;
    let before = allocations::count();
    let first = number;
    run(
        near,
        &chunk,
        &mut number,
        rounds as u64,
        1,
        &mut |at, seconds| trips[(at - first - 1) as usize] = seconds,
        is_over,
    )?;
    let allocations = allocations::count() - before;
    let watch = Stopwatch::start();
    run(near, &chunk, &mut number, rounds as u64, window, &mut |_, _| {}, is_over)?;
    Ok(Measured {
        round_trips: trips,
        chunks_per_second: rounds as f64 / watch.seconds(),
        allocations,
    })
}

/// Sends `count` chunks with at most `window` on their way; notes the number and time of each round
/// trip where `window` is 1.
fn run(
    near: &mut impl Near,
    chunk: &PlanChunk,
    number: &mut u64,
    count: u64,
    window: u64,
    note: &mut dyn FnMut(u64, f64),
    is_over: &dyn Fn() -> bool,
) -> Result<(), CommandError> {
    let end = *number + count;
    let mut answered = *number;
    let mut watch = Stopwatch::start();
    while answered < end && !is_over() {
        if *number < end && *number < answered + window {
            *number += 1;
            watch = Stopwatch::start();
            near.send(chunk, *number)?;
            continue;
        }
        let newest = near.answered()?;
        if newest > answered {
            answered = newest;
            note(answered, watch.seconds());
        } else {
            std::hint::spin_loop();
        }
    }
    Ok(())
}
