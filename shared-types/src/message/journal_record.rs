//! The journal record of a controller: the state of the robot, which outlives the process.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::base::digest::Digest;
use crate::message::crc::WithCrc;
use crate::message::feedback::Feedback;
use crate::message::layout::{Layout, layout};

/// A controller's last feedback and the stream that it belongs to, for the next controller. A file
/// in the instance's folder; never sent.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.JournalRecord.v1")]
pub struct JournalRecord {
    /// [`JournalRecord::HASH`].
    pub layout: u64,
    /// Number of this record in the instance, from 1.
    pub generation: u64,
    /// Digest of the stream after its first chunk. It identifies the plan of another planner
    /// session.
    pub stream_after_first: Digest,
    /// The controller's last feedback.
    pub feedback: Feedback,
    /// Always 0.
    pub reserved: u32,
    /// CRC-32 (IEEE) of all bytes of the record with this field zero.
    pub crc: u32,
}

layout!(JournalRecord {
    layout: u64,
    generation: u64,
    stream_after_first: Digest,
    feedback: Feedback,
    reserved: u32,
    crc: u32,
} with [Feedback]);

const _: () = assert!(size_of::<JournalRecord>() == 56 + size_of::<Feedback>());

impl WithCrc for JournalRecord {
    const CRC_AT: usize = std::mem::offset_of!(Self, crc);

    fn crc_mut(&mut self) -> &mut u32 {
        &mut self.crc
    }
}

impl JournalRecord {
    /// Whether the record is undamaged and its feedback is well-formed.
    pub fn is_well_formed(&self) -> bool {
        self.layout == Self::HASH
            && self.generation > 0
            && self.crc_matches()
            && self.feedback.is_well_formed()
    }
}
