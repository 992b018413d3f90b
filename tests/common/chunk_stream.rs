//! Streams of chunks without motion.

use bytemuck::Zeroable;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::message::chunk::{CHUNK_SCHEMA, FLAG_FIRST, FLAG_LAST};
use surefoot_shared_types::message::{PlanChunk, Waypoint};

/// A plan of `len` chunks.
pub fn plan(len: u64) -> Vec<PlanChunk> {
    let mut chunks: Vec<PlanChunk> = Vec::new();
    for sequence in 0..len {
        let stream = chunks.last().map_or(Digest::default(), PlanChunk::stream_after);
        let mut chunk =
            PlanChunk { schema: CHUNK_SCHEMA, plan_id: 1, sequence, stream, ..PlanChunk::zeroed() };
        chunk.flags = if sequence == 0 { FLAG_FIRST } else { 0 }
            | if sequence + 1 == len { FLAG_LAST } else { 0 };
        chunk.waypoints_len = 2;
        chunk.waypoints[1] = Waypoint { time: sequence as f64 + 1.0, ..chunk.waypoints[1] };
        chunks.push(chunk);
    }
    chunks
}
