//! Every order in which the searching thread and its helpers may access the words of their
//! protocol, up to a number of preemptions, on the protocol's own code.

#[path = "common/interleavings.rs"]
mod interleavings;

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};

use interleavings::{ModelWord, Parking, explore};
use surefoot_planner::base::threads::job_stack::JobStack;
use surefoot_planner::base::threads::sleep::Sleep;
use surefoot_planner::base::threads::word::Word;

/// Most jobs of a run; the work of a job is its index here.
const JOBS: usize = 2;
const ITEMS: usize = 2;

/// What the threads of a run share.
struct Run {
    jobs: JobStack<ModelWord>,
    sleeps: Vec<Sleep<ModelWord>>,
    is_over: ModelWord,
    parking: Parking,
    /// By job: whether its work is valid, as the stack of the opening thread is.
    is_valid: [AtomicUsize; JOBS],
    /// By job: how often each item has run.
    ended: [[AtomicU64; ITEMS]; JOBS],
}

impl Run {
    fn new(helpers: usize) -> Self {
        Self {
            jobs: JobStack::default(),
            sleeps: (0..helpers).map(|_| Sleep::default()).collect(),
            is_over: ModelWord::new(0),
            parking: Parking::new(helpers + 1),
            is_valid: Default::default(),
            ended: Default::default(),
        }
    }

    fn run_item(&self, work: usize, item: usize) {
        assert_eq!(self.is_valid[work].load(Ordering::SeqCst), 1, "job {work} is open");
        // Another thread may proceed while the item runs.
        self.is_over.load();
        assert_eq!(self.is_valid[work].load(Ordering::SeqCst), 1, "job {work} stays open");
        self.ended[work][item].fetch_add(1, Ordering::SeqCst);
    }

    /// Offers a job, runs `first`, then items that no helper has claimed.
    fn offer(&self, work: usize, first: impl FnOnce()) {
        self.is_valid[work].store(1, Ordering::SeqCst);
        let job = self.jobs.open(work as u64, ITEMS).expect("the stack has space");
        self.wake();
        first();
        while let Some(item) = job.claim() {
            self.run_item(work, item);
        }
        drop(job);
        self.is_valid[work].store(0, Ordering::SeqCst);
        let ended = self.ended[work].each_ref().map(|count| count.load(Ordering::SeqCst));
        assert_eq!(ended, [1; ITEMS], "each item of job {work} has run once");
    }

    fn wake(&self) {
        for (index, sleep) in self.sleeps.iter().enumerate() {
            sleep.wake(|| self.parking.unpark(index + 1));
        }
    }

    /// A helper: claims items, and sleeps where there is none.
    fn help(&self, index: usize) {
        while self.is_over.load() == 0 {
            if let Some(claim) = self.jobs.claim_as_helper() {
                self.run_item(claim.work as usize, claim.item);
                self.jobs.finish(claim);
            } else {
                let has_work = || self.is_over.load() == 1 || self.jobs.has_items();
                self.sleeps[index].sleep(has_work, || self.parking.park(index + 1));
            }
        }
    }

    fn end(&self) {
        self.is_over.store(1);
        (1..=self.sleeps.len()).for_each(|thread| self.parking.unpark(thread));
    }
}

/// Explores a search beside some helpers; returns the number of orders.
fn orders(helpers: usize, preemptions_max: usize, search: fn(&Run)) -> usize {
    explore(preemptions_max, || {
        let run = Arc::new(Run::new(helpers));
        let mut threads: Vec<Box<dyn FnOnce() + Send>> = vec![];
        let searching = Arc::clone(&run);
        threads.push(Box::new(move || {
            search(&searching);
            searching.end();
        }));
        for index in 0..helpers {
            let helping = Arc::clone(&run);
            threads.push(Box::new(move || helping.help(index)));
        }
        threads
    })
}

#[test]
fn every_item_runs_once_while_its_job_is_open() {
    let explored = orders(1, 2, |run| {
        run.offer(0, || ());
        run.offer(1, || ());
    });
    assert!(explored > 600, "{explored} orders");
}

#[test]
fn jobs_within_a_job_are_closed_before_it() {
    let explored = orders(1, 2, |run| run.offer(0, || run.offer(1, || ())));
    assert!(explored > 100, "{explored} orders");
}

#[test]
fn two_helpers_claim_different_items() {
    let explored = orders(2, 1, |run| run.offer(0, || ()));
    assert!(explored > 100, "{explored} orders");
}

#[test]
fn a_panic_of_the_search_waits_for_the_items_of_helpers() {
    let explored = orders(1, 2, |run| {
        run.is_valid[0].store(1, Ordering::SeqCst);
        let search = || {
            let _job = run.jobs.open(0, ITEMS);
            run.wake();
            std::panic::resume_unwind(Box::new(()));
        };
        assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(search)).is_err());
        run.is_valid[0].store(0, Ordering::SeqCst);
    });
    assert!(explored > 50, "{explored} orders");
}

#[test]
fn the_stack_is_bounded() {
    let jobs = JobStack::<AtomicU64>::default();
    let mut open = vec![];
    while let Some(job) = jobs.open(0, 1) {
        open.push(job);
    }
    assert!(open.len() >= 3, "{} jobs", open.len());
    while open.pop().is_some() {}
    assert!(!jobs.has_items() && jobs.open(0, 1).is_some());
}
