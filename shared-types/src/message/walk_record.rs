//! The instant of a walk that a controller recorded last.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::message::crc::WithCrc;
use crate::message::layout::{Layout, layout};

/// How plan time passes, in a [`WalkRecord`].
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u64)]
pub enum RecordedPace {
    /// The robot stands where the stop of a chunk ends.
    AtRest = 0,
    /// Plan time passes at full speed.
    Walking = 1,
    /// The robot brakes as the stop of a chunk says.
    Braking = 2,
    /// The robot goes on after the stop of a chunk.
    GoingOn = 3,
}

impl RecordedPace {
    /// The pace with this value, if the value is valid.
    pub fn from_wire(value: u64) -> Option<Self> {
        let all = [Self::AtRest, Self::Walking, Self::Braking, Self::GoingOn];
        all.into_iter().find(|pace| *pace as u64 == value)
    }
}

/// Where in its accepted chunks the robot is, and when. A controller records it at every tick, so
/// that the next one continues from there. Part of the journal; never sent.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.WalkRecord.v1")]
pub struct WalkRecord {
    /// [`WalkRecord::HASH`].
    pub layout: u64,
    /// Number of this record in the instance, from 1.
    pub generation: u64,
    /// The plan.
    pub plan_id: u64,
    /// Its epoch.
    pub epoch: u64,
    /// A [`RecordedPace`] as its wire value.
    pub pace: u64,
    /// The chunk whose stop the pace names: its sequence number plus 1; 0 for the beginning of the
    /// plan.
    pub stop: u64,
    /// Plan time while the robot walks; while it brakes or goes on, the time since it began to, s.
    pub time: f64,
    /// When this was so, ns of the machine's monotonic clock.
    pub at_nanos: u64,
    /// How often the robot has braked, under all controllers.
    pub brakes: u64,
    /// How long it stood for want of a chunk, s.
    pub stood: f64,
    /// Always 0.
    pub reserved: u32,
    /// CRC-32 (IEEE) of all bytes of the record with this field zero.
    pub crc: u32,
}

layout!(WalkRecord {
    layout: u64,
    generation: u64,
    plan_id: u64,
    epoch: u64,
    pace: u64,
    stop: u64,
    time: f64,
    at_nanos: u64,
    brakes: u64,
    stood: f64,
    reserved: u32,
    crc: u32,
} with []);

const _: () = assert!(size_of::<WalkRecord>() == 88);

impl WithCrc for WalkRecord {
    const CRC_AT: usize = std::mem::offset_of!(Self, crc);

    fn crc_mut(&mut self) -> &mut u32 {
        &mut self.crc
    }
}

impl WalkRecord {
    /// Whether the record is undamaged and its numbers are valid.
    pub fn is_well_formed(&self) -> bool {
        self.layout == Self::HASH
            && self.generation > 0
            && self.crc_matches()
            && RecordedPace::from_wire(self.pace).is_some()
            && self.time.is_finite()
            && self.stood >= 0.0
    }
}
