//! What both ends do to trust the bytes: the same work as our transport does, for raw memory.

use surefoot_shared_types::digest::Digest;
use surefoot_shared_types::message::{Feedback, PlanChunk, Sealed};

/// The near end's part before it sends: the seal.
pub(super) fn seal(chunk: &mut PlanChunk) {
    chunk.seal();
}

/// The far end's part: checks the seal, chains the digest, seals its record and its word.
pub(super) fn check(chunk: &PlanChunk, word: &mut Feedback) {
    if chunk.is_intact() {
        word.stream = chunk.stream_after();
    }
    word.seal();
    // Our record holds the word once more, under a seal of its own.
    std::hint::black_box(word.computed_crc());
}

/// The near end's part when it hears the word.
pub(super) fn believe(word: &Feedback) -> Digest {
    if word.is_intact() { word.stream } else { Digest::default() }
}
