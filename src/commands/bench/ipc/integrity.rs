//! CRC and digests over raw memory, the same work as in our transport.

use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::message::{Feedback, PlanChunk, WithCrc};

/// The near end's part before it sends: the CRC.
pub(crate) fn write_crc(chunk: &mut PlanChunk) {
    chunk.write_crc();
}

/// The far end's part: checks the CRC, chains the digest, writes the CRCs of its record and
/// feedback.
pub(crate) fn check(chunk: &PlanChunk, feedback: &mut Feedback) {
    if chunk.crc_matches() {
        feedback.stream = chunk.stream_after();
    }
    feedback.write_crc();
    // The journal record holds the feedback once more, with a CRC of its own.
    std::hint::black_box(feedback.computed_crc());
}

/// The near end's part when it receives the feedback.
pub(crate) fn verified_digest(feedback: &Feedback) -> Digest {
    if feedback.crc_matches() { feedback.stream } else { Digest::default() }
}
