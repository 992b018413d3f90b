//! Chunks through shared memory and acknowledgements back, both ends in this process.

use std::sync::atomic::{AtomicBool, Ordering};
use std::time::Duration;

use bytemuck::Zeroable;
use surefoot_controller_sim::channel::{ChunkReceiver, Judgement};
use surefoot_planner::channel::{ChunkSender, Outcome};
use surefoot_shared_types::digest::Digest;
use surefoot_shared_types::instance::{ChannelError, Instance, draw_id};
use surefoot_shared_types::message::chunk::{CHUNK_SCHEMA, FLAG_FIRST, FLAG_LAST};
use surefoot_shared_types::message::{Margins, PlanChunk};

use crate::clock::Stopwatch;

/// Chunks that make the trip.
const CHUNKS: u64 = 64;
/// How long to wait for the receiving end.
const PATIENCE: Duration = Duration::from_secs(5);

/// Sends chunks through the instance; says how it went, or why it did not.
pub(super) fn run(instance: &Instance) -> Result<String, String> {
    let watch = Stopwatch::start();
    let over = AtomicBool::new(false);
    let outcome = std::thread::scope(|scope| {
        let receiver = scope.spawn(|| receive(instance, &over));
        let delivered = deliver(instance);
        over.store(true, Ordering::Relaxed);
        let received = receiver.join().map_err(|_| "the receiving thread panicked".to_owned())?;
        received
            .map_err(|error| error.to_string())
            .and(delivered.map_err(|error| error.to_string()))
    })?;
    match outcome {
        Outcome::Accepted => Ok(format!(
            "{CHUNKS} chunks delivered and acknowledged in {:.1} ms",
            1000.0 * watch.seconds()
        )),
        other => Err(format!(
            "chunks are not delivered ({other:?}); look for a full /dev/shm and for sandboxes that forbid shared memory"
        )),
    }
}

fn deliver(instance: &Instance) -> Result<Outcome, ChannelError> {
    let mut sender = ChunkSender::open(instance, draw_id())?;
    sender.set_lost_after(PATIENCE);
    Ok(sender.deliver(&stream(), &mut |_| {}, &|| true)?.outcome)
}

fn receive(instance: &Instance, over: &AtomicBool) -> Result<(), ChannelError> {
    let mut receiver = ChunkReceiver::open(instance, draw_id())?;
    let keep_going = || !over.load(Ordering::Relaxed);
    let accept = &mut |chunk: &PlanChunk, _: &mut dyn FnMut()| {
        Judgement::Accepted(Margins::UNMEASURED, chunk.stream_after())
    };
    receiver.run(accept, &keep_going)?;
    receiver.linger(accept, Some(PATIENCE), &keep_going).map(|_| ())
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
