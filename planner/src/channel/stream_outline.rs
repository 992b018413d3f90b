//! What the sender knows of the stream of chunks that it sends: enough to compare it with the
//! controller's feedback, without the chunks.

use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::instance::error::ChannelError;
use surefoot_shared_types::message::PlanChunk;

use crate::channel::chunk_source::SourceState;

/// The beginning of a chunk.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ChunkBegin {
    /// Time of its first waypoint, s.
    pub time: f64,
    /// Digest of the stream before it.
    pub stream: Digest,
}

/// The outline of a stream.
#[derive(Debug, Clone)]
pub(crate) struct StreamOutline {
    /// Plan id and epoch; none before the first chunk.
    pub name: Option<(u64, u64)>,
    /// The beginnings of the chunks so far.
    pub begins: Vec<ChunkBegin>,
    /// Digest of the stream after them.
    pub end: Digest,
    /// Whether more chunks are to follow.
    pub state: SourceState,
}

impl Default for StreamOutline {
    fn default() -> Self {
        let (begins, end) = (Vec::new(), Digest::default());
        Self { name: None, begins, end, state: SourceState::Open }
    }
}

impl StreamOutline {
    /// Number of chunks so far.
    pub fn len(&self) -> usize {
        self.begins.len()
    }

    /// Digest of the stream before the chunk of an index.
    pub fn digest_at(&self, index: usize) -> Digest {
        self.begins.get(index).map_or(self.end, |begin| begin.stream)
    }

    /// Takes the chunks that are new among all `chunks` made so far.
    ///
    /// # Errors
    /// [`ChannelError::Stream`] if they do not continue the stream, or it is complete without one.
    pub fn extend(&mut self, chunks: &[PlanChunk], state: SourceState) -> Result<(), ChannelError> {
        for chunk in &chunks[self.len().min(chunks.len())..] {
            let index = self.len();
            let name = *self.name.get_or_insert((chunk.plan_id, chunk.epoch));
            let is_first = index == 0;
            let is_next = (chunk.plan_id, chunk.epoch) == name
                && chunk.sequence == index as u64
                && (is_first || chunk.stream == self.end);
            if !is_next {
                return Err(ChannelError::Stream { index });
            }
            self.begins.push(ChunkBegin { time: chunk.waypoints[0].time, stream: chunk.stream });
            self.end = chunk.stream_after();
        }
        self.state = state;
        let is_empty = state == SourceState::Complete && self.begins.is_empty();
        if is_empty { Err(ChannelError::Stream { index: 0 }) } else { Ok(()) }
    }
}
