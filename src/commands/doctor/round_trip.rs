//! Chunks through shared memory and acknowledgements back, both ends in this process.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use bytemuck::Zeroable;
use surefoot_controller_sim::channel::plan_subscriber::{ChunkDecision, PlanSubscriber};
use surefoot_planner::channel::plan_publisher::PlanPublisher;
use surefoot_planner::channel::send_window::DeliveryOutcome;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::instance::error::ChannelError;
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::sender::random_id;
use surefoot_shared_types::message::chunk::{CHUNK_SCHEMA, FLAG_FIRST, FLAG_LAST};
use surefoot_shared_types::message::{Margins, PlanChunk};

use crate::system::clock::Stopwatch;

/// Chunks that make the trip.
const CHUNKS: u64 = 64;
/// How long to wait for the receiving end.
const WAIT_MAX: Duration = Duration::from_secs(5);

/// Sends chunks through the instance; returns a description, or why it failed.
pub(crate) fn run(instance: &Instance) -> Result<String, String> {
    let watch = Stopwatch::start();
    let over = AtomicBool::new(false);
    let outcome = std::thread::scope(|scope| {
        let subscriber = scope.spawn(|| receive(instance, &over));
        let delivered = deliver(instance);
        over.store(true, Ordering::Relaxed);
        let received = subscriber.join().map_err(|_| "the receiving thread panicked".to_owned())?;
        received
            .map_err(|error| error.to_string())
            .and(delivered.map_err(|error| error.to_string()))
    })?;
    match outcome {
        DeliveryOutcome::Accepted => Ok(format!(
            "{CHUNKS} chunks delivered and acknowledged in {:.1} ms",
            1000.0 * watch.seconds()
        )),
        other => Err(format!(
            "chunks are not delivered ({other:?}); look for a full /dev/shm and for sandboxes that forbid shared memory"
        )),
    }
}

fn deliver(instance: &Instance) -> Result<DeliveryOutcome, ChannelError> {
    let mut sender = PlanPublisher::open(instance, random_id())?;
    sender.set_lost_after(WAIT_MAX);
    Ok(sender.deliver(&stream(), &mut |_| {}, &|| true)?.outcome)
}

fn receive(instance: &Instance, over: &AtomicBool) -> Result<(), ChannelError> {
    let mut subscriber = PlanSubscriber::open(instance, random_id())?;
    let keep_going = || !over.load(Ordering::Relaxed);
    let accept = &mut |chunk: &PlanChunk, _: &mut dyn FnMut()| {
        ChunkDecision::Accepted(Margins::UNMEASURED, chunk.stream_after())
    };
    subscriber.run(accept, &keep_going)?;
    subscriber.linger(accept, Some(WAIT_MAX), &keep_going).map(|_| ())
}

/// A stream of empty chunks.
fn stream() -> Vec<PlanChunk> {
    let mut chunks: Vec<PlanChunk> = Vec::new();
    for sequence in 0..CHUNKS {
        let stream = chunks.last().map_or(Digest::default(), PlanChunk::stream_after);
        let flags = if sequence == 0 { FLAG_FIRST } else { 0 }
            | if sequence + 1 == CHUNKS { FLAG_LAST } else { 0 };
        chunks.push(PlanChunk {
            schema: CHUNK_SCHEMA,
            plan_id: 1,
            sequence,
            stream,
            flags,
            ..PlanChunk::zeroed()
        });
    }
    chunks
}
