//! The robot's rest state and its last chunks, stored in the instance's folder so that they outlive
//! the controller's process.
//!
//! A chunk counts as executed once its record is complete here, before the robot moves along it and
//! before feedback is published. So a controller that takes over neither executes a chunk again nor
//! misses one, whenever its predecessor was killed. Two slots are written in turn: a record torn by
//! a kill leaves the one before. The chunks are in a ring with a slot more than a record needs, so
//! the record before finds its chunks too; each is known by the digest of the stream with it. The
//! file is written once before it is mapped, so that writing a record allocates nothing and cannot
//! fail on a full file system. The lock on it allows one controller at a time.

use std::fs::File;
use std::io::Write;

use memmap2::MmapMut;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::instance::error::ChannelError;
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::role_lock;
use surefoot_shared_types::message::{
    Feedback, JournalRecord, Layout, PlanChunk, WalkRecord, WithCrc,
};

use crate::channel::tuning::JOURNAL_CHUNKS;
use crate::channel::walk_journal::WalkJournal;

/// The file's name in the instance's folder.
const FILE: &str = "robot";
/// Bytes of a record.
const RECORD: usize = size_of::<JournalRecord>();
/// Where the records of the walk begin in the file.
const WALK_AT: usize = 2 * RECORD;
/// Where the ring of chunks begins.
const CHUNKS_AT: usize = WALK_AT + 2 * size_of::<WalkRecord>();
/// Bytes of a chunk.
const CHUNK: usize = size_of::<PlanChunk>();
/// Slots of the ring.
const SLOTS: usize = JOURNAL_CHUNKS + 1;
/// Bytes of the file.
const LENGTH: usize = CHUNKS_AT + SLOTS * CHUNK;

/// The record of one robot.
#[derive(Debug)]
pub(crate) struct Journal {
    slots: MmapMut,
    generation: u64,
    file: File,
}

/// What the last controller of a robot recorded.
#[derive(Debug)]
pub(crate) struct LastRecord {
    /// Its progress.
    pub(crate) record: JournalRecord,
    /// The last accepted chunks of the plan in execution, in their order.
    pub(crate) chunks: Vec<PlanChunk>,
    /// Where in them the robot was.
    pub(crate) walk: Option<WalkRecord>,
}

impl Journal {
    /// Opens the journal of an instance and locks it; returns the last controller's record.
    pub(crate) fn open(instance: &Instance) -> Result<(Self, Option<LastRecord>), ChannelError> {
        let mut file = role_lock::acquire(instance, FILE)?.ok_or(ChannelError::Taken)?;
        if file.metadata().map_err(failed)?.len() != LENGTH as u64 {
            file.set_len(0).map_err(failed)?;
            for _ in 0..LENGTH / CHUNK {
                file.write_all(&[0; CHUNK]).map_err(failed)?;
            }
            file.write_all(&[0; CHUNK][..LENGTH % CHUNK]).map_err(failed)?;
        }
        let slots = map(&file)?;
        let records = [0, 1].map(|slot| read::<JournalRecord>(&slots, slot * RECORD));
        let newest = records
            .into_iter()
            .filter(JournalRecord::is_well_formed)
            .max_by_key(|record| record.generation);
        let generation = newest.map_or(0, |record| record.generation);
        let journal = Self { slots, generation, file };
        let last = newest.map(|record| LastRecord {
            chunks: journal.chunks_of(&record.feedback),
            walk: journal.walk(),
            record,
        });
        Ok((journal, last))
    }

    /// The part of the journal that records where the robot is. `before` is its last record.
    pub(crate) fn walk_journal(
        &self,
        before: Option<&WalkRecord>,
    ) -> Result<WalkJournal, ChannelError> {
        Ok(WalkJournal::new(map(&self.file)?, WALK_AT, before))
    }

    /// Stores an accepted chunk, the `walked`th of the robot. It is not the robot's until the
    /// record with it is written.
    pub(crate) fn store(&mut self, walked: u64, chunk: &PlanChunk) {
        let at = slot_at(walked);
        self.slots[at..at + CHUNK].copy_from_slice(bytemuck::bytes_of(chunk));
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

    /// The last chunks of the stream that this feedback acknowledges, in their order.
    fn chunks_of(&self, feedback: &Feedback) -> Vec<PlanChunk> {
        let mut chunks = Vec::new();
        let mut stream = feedback.stream;
        let count = feedback.next_sequence.min(feedback.walked).min(JOURNAL_CHUNKS as u64);
        for back in 0..count {
            let chunk = read::<PlanChunk>(&self.slots, slot_at(feedback.walked - back));
            let is_next = chunk.sequence + back + 1 == feedback.next_sequence
                && chunk.waypoints_len > 0
                && chunk.crc_matches()
                && chunk.stream_after() == stream;
            if !is_next {
                break;
            }
            stream = chunk.stream;
            chunks.push(chunk);
        }
        chunks.reverse();
        chunks
    }

    /// The newest record of where the robot is.
    fn walk(&self) -> Option<WalkRecord> {
        let size = size_of::<WalkRecord>();
        let records = [0, 1].map(|slot| read::<WalkRecord>(&self.slots, WALK_AT + slot * size));
        let whole = records.into_iter().filter(WalkRecord::is_well_formed);
        whole.max_by_key(|record| record.generation)
    }
}

fn failed(error: std::io::Error) -> ChannelError {
    ChannelError::transport("keeping the robot's record", error)
}

fn map(file: &File) -> Result<MmapMut, ChannelError> {
    // SAFETY: only the holder of the lock writes the file, and no process shortens it.
    unsafe { MmapMut::map_mut(file) }.map_err(failed)
}

/// Where in the file the `walked`th chunk of the robot is.
fn slot_at(walked: u64) -> usize {
    CHUNKS_AT + (walked % SLOTS as u64) as usize * CHUNK
}

fn read<T: bytemuck::Pod>(slots: &MmapMut, at: usize) -> T {
    bytemuck::pod_read_unaligned(&slots[at..at + size_of::<T>()])
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::FileExt;

    use bytemuck::Zeroable;
    use surefoot_shared_types::message::RecordedPace;
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

    /// Stores the next chunk of a stream and, if `is_recorded`, the record with it.
    fn accept(journal: &mut Journal, stream: &mut Digest, sequence: u64, is_recorded: bool) {
        let mut chunk =
            PlanChunk { sequence, stream: *stream, waypoints_len: 1, ..PlanChunk::zeroed() };
        chunk.write_crc();
        let walked = sequence + 11;
        journal.store(walked, &chunk);
        *stream = chunk.stream_after();
        if is_recorded {
            let accepted =
                Feedback { next_sequence: sequence + 1, stream: *stream, ..feedback(walked) };
            let mut accepted = Feedback { session: 1, verdict: 1, ..accepted };
            accepted.write_crc();
            journal.write(Digest::default(), &accepted);
        }
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
        let found = Journal::open(&instance).unwrap().1.unwrap().record;
        assert_eq!((found.feedback.walked, found.generation), (5, 5));
        let file = File::options().read(true).write(true).open(instance.root().join(FILE)).unwrap();
        file.write_at(&[0xff; 9], RECORD as u64 + 900).unwrap();
        assert_eq!(
            Journal::open(&instance).unwrap().1.unwrap().record.feedback.walked,
            4,
            "the fifth is torn"
        );
        file.write_at(&[0xff; 9], 900).unwrap();
        assert!(Journal::open(&instance).unwrap().1.is_none());
        file.set_len(100).unwrap();
        assert!(Journal::open(&instance).unwrap().1.is_none());
    }

    #[test]
    fn a_successor_finds_the_chunks_of_the_record_and_none_beyond() {
        let base = tempfile::tempdir_in("/dev/shm").unwrap();
        let instance = instance(base.path());
        let (mut journal, mut stream) = (Journal::open(&instance).unwrap().0, Digest::default());
        let found = |journal: Journal| -> (Journal, Vec<u64>) {
            drop(journal);
            let (journal, last) = Journal::open(&instance).unwrap();
            (journal, last.unwrap().chunks.iter().map(|chunk| chunk.sequence).collect())
        };
        let all: Vec<u64> = (0..3 * SLOTS as u64).collect();
        for &sequence in &all {
            // Killed between chunk and record, the record before has all of its chunks.
            accept(&mut journal, &mut stream.clone(), sequence, false);
            if sequence > 0 {
                let (reopened, chunks) = found(journal);
                let first = sequence.saturating_sub(JOURNAL_CHUNKS as u64) as usize;
                assert_eq!(chunks, all[first..sequence as usize]);
                journal = reopened;
            }
            accept(&mut journal, &mut stream, sequence, true);
        }
        let torn = slot_at(all[all.len() - 3] + 11) + 300;
        journal.slots[torn] ^= 1;
        assert_eq!(found(journal).1, all[all.len() - 2..], "the third last is torn");
    }

    #[test]
    fn a_successor_finds_where_the_robot_is() {
        let base = tempfile::tempdir_in("/dev/shm").unwrap();
        let instance = instance(base.path());
        let mut journal = Journal::open(&instance).unwrap().0;
        journal.write(Digest::default(), &feedback(1));
        let mut walk = journal.walk_journal(None).unwrap();
        let at = |time: f64| WalkRecord {
            pace: RecordedPace::Walking as u64,
            time,
            brakes: 2,
            stood: 0.5,
            ..WalkRecord::zeroed()
        };
        walk.write(at(1.5));
        walk.write(at(2.5));
        drop((journal, walk));
        let (journal, last) = Journal::open(&instance).unwrap();
        let found = last.unwrap().walk.unwrap();
        assert_eq!((found.time, found.brakes, found.stood), (2.5, 2, 0.5));
        // The next controller counts its own stops in addition, and a torn record is left out.
        let mut walk = journal.walk_journal(Some(&found)).unwrap();
        walk.write(at(3.5));
        let found = journal.walk().unwrap();
        assert_eq!((found.time, found.brakes, found.stood, found.generation), (3.5, 4, 1.0, 3));
        let file = File::options().write(true).open(instance.root().join(FILE)).unwrap();
        file.write_at(&[0xff; 3], (WALK_AT + size_of::<WalkRecord>() + 50) as u64).unwrap();
        assert_eq!(journal.walk().unwrap().time, 2.5);
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
