//! The robot's rest state, stored in the instance's folder so that it outlives the controller's
//! process.
//!
//! A chunk counts as executed once its record is complete here, before feedback is published. So a
//! controller that takes over neither executes a chunk again nor misses one, whenever its
//! predecessor was killed. Two slots are written in turn: a record torn by a kill leaves the one
//! before. The file is written once before it is mapped, so that writing a record allocates
//! nothing and cannot fail on a full file system. The lock on it allows one controller at a time.

use std::fs::File;
use std::io::Write;

use memmap2::MmapMut;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::instance::error::ChannelError;
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::role_lock;
use surefoot_shared_types::message::{Feedback, JournalRecord, Layout, WithCrc};

/// The file's name in the instance's folder.
const FILE: &str = "robot";
/// Bytes of a record.
const RECORD: usize = size_of::<JournalRecord>();

/// The record of one robot.
#[derive(Debug)]
pub(crate) struct Journal {
    slots: MmapMut,
    generation: u64,
    /// Held as long as this controller moves the robot.
    _lock: File,
}

impl Journal {
    /// Opens the journal of an instance and locks it; returns the last controller's record.
    pub(crate) fn open(instance: &Instance) -> Result<(Self, Option<JournalRecord>), ChannelError> {
        let failed =
            |error: std::io::Error| ChannelError::transport("keeping the robot's record", error);
        let mut file = role_lock::acquire(instance, FILE)?.ok_or(ChannelError::Taken)?;
        if file.metadata().map_err(failed)?.len() != 2 * RECORD as u64 {
            file.set_len(0).map_err(failed)?;
            file.write_all(&[0; 2 * RECORD]).map_err(failed)?;
        }
        // SAFETY: only the holder of the lock writes the file, and no process shortens it.
        let slots = unsafe { MmapMut::map_mut(&file) }.map_err(failed)?;
        let records = [0, 1].map(|slot| {
            bytemuck::pod_read_unaligned::<JournalRecord>(
                &slots[slot * RECORD..(slot + 1) * RECORD],
            )
        });
        let newest = records
            .into_iter()
            .filter(JournalRecord::is_well_formed)
            .max_by_key(|record| record.generation);
        let generation = newest.map_or(0, |record| record.generation);
        Ok((Self { slots, generation, _lock: file }, newest))
    }

    /// Writes the robot's rest state, in place. The record is complete once this returns.
    pub(crate) fn write(&mut self, stream_after_first: Digest, feedback: &Feedback) {
        self.generation += 1;
        let slot = (self.generation % 2) as usize;
        let record: &mut JournalRecord =
            bytemuck::from_bytes_mut(&mut self.slots[slot * RECORD..(slot + 1) * RECORD]);
        (record.layout, record.generation) = (JournalRecord::HASH, self.generation);
        (record.stream_after_first, record.feedback) = (stream_after_first, *feedback);
        record.write_crc();
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::FileExt;

    use bytemuck::Zeroable;
    use surefoot_shared_types::message::feedback::FEEDBACK_SCHEMA;

    use super::*;

    fn instance(base: &std::path::Path) -> Instance {
        Instance::create_in(&base.join("base"), "journal").unwrap()
    }

    fn feedback(walked: u64) -> Feedback {
        let mut feedback =
            Feedback { schema: FEEDBACK_SCHEMA, controller_id: 7, walked, ..Feedback::zeroed() };
        feedback.write_crc();
        feedback
    }

    #[test]
    fn a_successor_finds_the_newest_whole_record() {
        let base = tempfile::tempdir_in("/dev/shm").unwrap();
        let instance = instance(base.path());
        let (mut journal, found) = Journal::open(&instance).unwrap();
        assert!(found.is_none());
        for walked in 1..=5 {
            journal.write(Digest::default(), &feedback(walked));
        }
        drop(journal);
        let found = Journal::open(&instance).unwrap().1.unwrap();
        assert_eq!((found.feedback.walked, found.generation), (5, 5));
        let file = File::options().read(true).write(true).open(instance.root().join(FILE)).unwrap();
        file.write_at(&[0xff; 9], RECORD as u64 + 900).unwrap();
        assert_eq!(
            Journal::open(&instance).unwrap().1.unwrap().feedback.walked,
            4,
            "the fifth is torn"
        );
        file.write_at(&[0xff; 9], 900).unwrap();
        assert!(Journal::open(&instance).unwrap().1.is_none());
        file.set_len(100).unwrap();
        assert!(Journal::open(&instance).unwrap().1.is_none());
    }

    #[test]
    fn a_robot_has_one_controller_at_a_time() {
        let base = tempfile::tempdir_in("/dev/shm").unwrap();
        let instance = instance(base.path());
        let first = Journal::open(&instance).unwrap();
        assert!(matches!(Journal::open(&instance), Err(ChannelError::Taken)));
        drop(first);
        assert!(Journal::open(&instance).is_ok());
    }
}
