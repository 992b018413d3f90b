//! The part of the journal that records where in its chunks the robot is: at every tick, in place,
//! in two slots that are written in turn.

use memmap2::MmapMut;
use surefoot_shared_types::message::{Layout, WalkRecord, WithCrc};

/// Bytes of a record.
const RECORD: usize = size_of::<WalkRecord>();

/// Records where the robot is.
#[derive(Debug)]
pub struct WalkJournal {
    slots: MmapMut,
    /// Where the records begin in the file.
    at: usize,
    generation: u64,
    /// How often the robot braked, and how long it stood (s), under the controllers before.
    before: (u64, f64),
}

impl WalkJournal {
    /// The records from `at` on in a mapped journal. `before` is the last one.
    pub(crate) fn new(slots: MmapMut, at: usize, before: Option<&WalkRecord>) -> Self {
        let generation = before.map_or(0, |record| record.generation);
        let before = before.map_or((0, 0.0), |record| (record.brakes, record.stood));
        Self { slots, at, generation, before }
    }

    /// Writes where the robot is; the stops are those under this controller.
    pub fn write(&mut self, walk: WalkRecord) {
        self.generation += 1;
        let at = self.at + (self.generation % 2) as usize * RECORD;
        let record: &mut WalkRecord = bytemuck::from_bytes_mut(&mut self.slots[at..at + RECORD]);
        *record = WalkRecord {
            layout: WalkRecord::HASH,
            generation: self.generation,
            brakes: self.before.0 + walk.brakes,
            stood: self.before.1 + walk.stood,
            ..walk
        };
        record.write_crc();
    }
}
