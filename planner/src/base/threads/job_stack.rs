//! Jobs whose items several threads claim in order.
//!
//! One thread opens jobs: a stack of them, since an item may open a job. It claims items itself,
//! and closes the job once no claimed item is running. Other threads claim items of the newest job
//! first. A claim counts the item as running in the same word in which it takes its number, so a
//! job with a claimed item stays open, and its work stays valid, until the item has ended.

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::base::threads::tuning::{ITEMS_MAX, JOBS_MAX};
use crate::base::threads::word::Word;

const FIELD_BITS: u32 = 16;
const FIELD_MASK: u64 = (1 << FIELD_BITS) - 1;
const _: () = assert!(ITEMS_MAX < FIELD_MASK as usize);

/// The jobs that are open.
#[derive(Debug)]
pub struct JobStack<W> {
    jobs: [Job<W>; JOBS_MAX],
    /// Jobs that are open. Only the opening thread uses it.
    depth: AtomicUsize,
}

/// A job that the opening thread has opened. Dropped, also by a panic, it withdraws the items that
/// nobody has claimed, and waits for those that helper threads run.
#[derive(Debug)]
pub struct OpenJob<'a, W: Word> {
    stack: &'a JobStack<W>,
    depth: usize,
}

/// A job. Aligned, so that claims in one job do not slow down another one.
#[derive(Debug)]
#[repr(align(128))]
struct Job<W> {
    /// The next item, the number of items, and the items that other threads run: a [`JobState`].
    state: W,
    /// What the items are part of, as the opening thread named it.
    work: W,
}

/// The fields of a job's word.
#[derive(Debug, Clone, Copy)]
struct JobState {
    next: u64,
    count: u64,
    running: u64,
}

/// An item that a helper thread has claimed and must finish.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Claim {
    /// Depth of the job in the stack.
    pub depth: usize,
    /// The job's work.
    pub work: u64,
    /// Index of the item.
    pub item: usize,
}

impl JobState {
    fn unpack(word: u64) -> Self {
        let field = |index: u32| word >> (index * FIELD_BITS) & FIELD_MASK;
        Self { running: field(0), next: field(1), count: field(2) }
    }

    fn pack(self) -> u64 {
        self.running | self.next << FIELD_BITS | self.count << (2 * FIELD_BITS)
    }
}

impl<W: Word> Default for JobStack<W> {
    fn default() -> Self {
        let job = |_| Job { state: W::new(0), work: W::new(0) };
        Self { jobs: std::array::from_fn(job), depth: AtomicUsize::new(0) }
    }
}

impl<W: Word> JobStack<W> {
    /// Opens a job on top of the others; `None` if the stack is full.
    ///
    /// # Panics
    /// There are more items than a job may have.
    pub fn open(&self, work: u64, count: usize) -> Option<OpenJob<'_, W>> {
        assert!(count <= ITEMS_MAX, "{count} items");
        let depth = self.depth.load(Ordering::Relaxed);
        let job = self.jobs.get(depth)?;
        job.work.store(work);
        job.state.store(JobState { next: 0, count: count as u64, running: 0 }.pack());
        self.depth.store(depth + 1, Ordering::Relaxed);
        Some(OpenJob { stack: self, depth })
    }

    /// Claims an item of the newest job that has one, for a helper thread.
    pub fn claim_as_helper(&self) -> Option<Claim> {
        (0..JOBS_MAX).rev().find_map(|depth| {
            let item = self.claim_counted(depth, 1)?;
            Some(Claim { depth, work: self.jobs[depth].work.load(), item })
        })
    }

    /// Ends an item that a helper thread claimed.
    pub fn finish(&self, claim: Claim) {
        // The number of running items is the lowest field, and at least one.
        self.jobs[claim.depth].state.decrement();
    }

    /// Whether any job has an item to claim.
    pub fn has_items(&self) -> bool {
        self.jobs.iter().any(|job| {
            let state = JobState::unpack(job.state.load());
            state.next < state.count
        })
    }

    /// Claims the next item of a job, and counts it as running on a helper if `running` is 1.
    fn claim_counted(&self, depth: usize, running: u64) -> Option<usize> {
        let word = &self.jobs[depth].state;
        loop {
            let known = word.load();
            let state = JobState::unpack(known);
            if state.next >= state.count {
                return None;
            }
            let claimed =
                JobState { next: state.next + 1, running: state.running + running, ..state };
            if word.replace(known, claimed.pack()) {
                return Some(state.next as usize);
            }
        }
    }
}

impl<W: Word> OpenJob<'_, W> {
    /// Claims the next item for the opening thread.
    pub fn claim(&self) -> Option<usize> {
        self.stack.claim_counted(self.depth, 0)
    }
}

impl<W: Word> Drop for OpenJob<'_, W> {
    fn drop(&mut self) {
        while self.claim().is_some() {}
        let is_running = || JobState::unpack(self.stack.jobs[self.depth].state.load()).running > 0;
        let mut count = 0;
        while is_running() {
            W::pause(count);
            count = count.saturating_add(1);
        }
        self.stack.depth.store(self.depth, Ordering::Relaxed);
    }
}
