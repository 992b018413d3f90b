//! Our transport, with a controller that accepts every chunk, with or without computing the digest
//! of the stream.

use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use bytemuck::Zeroable;
use surefoot_controller_sim::channel::plan_subscriber::{ChunkDecision, PlanSubscriber, StreamEnd};
use surefoot_planner::channel::plan_publisher::PlanPublisher;
use surefoot_planner::channel::send_window::DeliveryOutcome;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::sender::random_id;
use surefoot_shared_types::instance::tuning::WINDOW_CHUNKS;
use surefoot_shared_types::message::chunk::{CHUNK_SCHEMA, FLAG_FIRST, FLAG_LAST};
use surefoot_shared_types::message::{Margins, PlanChunk};

use crate::commands::bench::ipc::drive::{Measured, chunk};
use crate::report::command_error::CommandError;
use crate::system::clock::Stopwatch;
use crate::system::{allocations, cores};

/// Chunks of one plan: as many as both ends have loaned beforehand.
const PLAN: usize = 48;
/// Plans before the measurement.
const WARM_PLANS: u64 = 4;
/// Longest wait for the controller.
const WAIT_MAX: Duration = Duration::from_secs(10);

/// The source of the stream's digests.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Digests {
    /// Computed before: the transport alone is measured.
    Known,
    /// Computed by the controller.
    Made,
}

/// The digests of the plan in flight, after each of its chunks.
type KnownDigests = Mutex<Vec<Digest>>;

/// Measures it.
pub(crate) fn measure(rounds: usize, digests: Digests) -> Result<Measured, CommandError> {
    let known = KnownDigests::default();
    let instance = Instance::create(&format!("bench-{}", std::process::id()))?;
    let over = AtomicBool::new(false);
    let (near_core, far_core) = cores::cores_of_roles(1);
    std::thread::scope(|scope| {
        let far = scope.spawn(|| {
            cores::pin(far_core);
            accept_all(&instance, &over, (digests == Digests::Known).then_some(&known))
        });
        let near = scope.spawn(|| {
            cores::pin(near_core);
            let driven = drive(&instance, rounds, &known);
            over.store(true, Ordering::Relaxed);
            driven
        });
        let panicked = |_| CommandError::Usage("a thread of the bench panicked".into());
        let driven = near.join().map_err(panicked)?;
        far.join().map_err(panicked)?.and(driven)
    })
}

fn accept_all(
    instance: &Instance,
    over: &AtomicBool,
    known: Option<&KnownDigests>,
) -> Result<(), CommandError> {
    let mut subscriber = PlanSubscriber::open(instance, random_id())?;
    let known = |chunk: &PlanChunk| known?.lock().ok()?.get(chunk.sequence as usize).copied();
    let mut accept = |chunk: &PlanChunk, _: &mut dyn FnMut()| {
        ChunkDecision::Accepted(
            Margins::UNMEASURED,
            known(chunk).unwrap_or_else(|| chunk.stream_after()),
        )
    };
    while subscriber.run(&mut accept, &|| !over.load(Ordering::Relaxed))? != StreamEnd::Stopped {}
    Ok(())
}

fn drive(
    instance: &Instance,
    rounds: usize,
    known: &KnownDigests,
) -> Result<Measured, CommandError> {
    let mut sender = PlanPublisher::open(instance, random_id())?;
    sender.set_lost_after(WAIT_MAX);
    sender.set_window_chunks(1);
    let plans = rounds.div_ceil(PLAN);
    let mut trips = Vec::with_capacity(plans * PLAN);
    let mut allocated = 0;
    for plan_id in 0..plans as u64 + WARM_PLANS {
        let chunks = plan(plan_id + 1, known);
        let mut received = (0, Stopwatch::start());
        let mut before = 0;
        let delivery = sender.deliver(
            &chunks,
            &mut |feedback| {
                if feedback.plan_id != plan_id + 1 || feedback.next_sequence <= received.0 {
                    return;
                }
                match received.0 {
                    0 => before = allocations::count(),
                    _ if plan_id >= WARM_PLANS => trips.push(received.1.seconds()),
                    _ => {}
                }
                received = (feedback.next_sequence, Stopwatch::start());
            },
            &|| true,
        )?;
        let after = allocations::count();
        check(delivery.outcome)?;
        if plan_id >= WARM_PLANS {
            allocated += after - before;
        }
    }
    sender.set_window_chunks(WINDOW_CHUNKS);
    let mut seconds = 0.0;
    for plan_id in plans as u64 + 5..2 * plans as u64 + 5 {
        let chunks = plan(plan_id, known);
        let watch = Stopwatch::start();
        check(sender.deliver(&chunks, &mut |_| {}, &|| true)?.outcome)?;
        seconds += watch.seconds();
    }
    Ok(Measured {
        round_trips: trips,
        chunks_per_second: (plans * PLAN) as f64 / seconds,
        allocations: allocated,
    })
}

fn check(outcome: DeliveryOutcome) -> Result<(), CommandError> {
    match outcome {
        DeliveryOutcome::Accepted => Ok(()),
        _ => Err(CommandError::ControllerLost),
    }
}

/// A stream of chunks with something in them, and its digests.
fn plan(plan_id: u64, known: &KnownDigests) -> Vec<PlanChunk> {
    let mut chunks: Vec<PlanChunk> = Vec::with_capacity(PLAN);
    let (mut stream, mut digests) = (Digest::default(), Vec::with_capacity(PLAN));
    for sequence in 0..PLAN as u64 {
        let flags = if sequence == 0 { FLAG_FIRST } else { 0 }
            | if sequence + 1 == PLAN as u64 { FLAG_LAST } else { 0 };
        let mut next = PlanChunk {
            schema: CHUNK_SCHEMA,
            plan_id,
            epoch: 0,
            mode: 2,
            sequence,
            flags,
            stream,
            ..chunk()
        };
        (next.contacts, next.contacts_len, next.waypoints_len) = (Zeroable::zeroed(), 0, 2);
        next.waypoints = Zeroable::zeroed();
        stream = next.stream_after();
        chunks.push(next);
        digests.push(stream);
    }
    if let Ok(mut known) = known.lock() {
        *known = digests;
    }
    chunks
}
