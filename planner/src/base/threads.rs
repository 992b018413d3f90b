//! Work that the threads of a pool do in parallel, with nobody asleep between two short pieces of
//! it.
//!
//! Rayon's own loops split their items in two until each stands alone, and a thread that waits
//! falls asleep. Items take 20 us to some milliseconds here, so both cost much of what threads
//! bring. What is made depends on neither: each item is worked on by itself.

use std::num::NonZeroUsize;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use crate::base::idle_threads::{IdleThreads, poll};

/// How often a thread that waits for another one looks again before it lets rayon put it to sleep:
/// some 150 us.
const POLLS_MAX: u32 = 1024;

/// The threads that may share work: those of a pool, or the caller's alone.
#[derive(Debug, Clone, Default)]
pub struct Threads {
    workers: Option<Arc<Workers>>,
}

#[derive(Debug)]
struct Workers {
    pool: ThreadPool,
    idle: IdleThreads,
}

impl Threads {
    /// So many threads; where one is asked for, the caller's own.
    ///
    /// # Errors
    /// They cannot be started.
    pub fn new(threads: NonZeroUsize) -> Result<Self, ThreadPoolBuildError> {
        if threads.get() == 1 {
            return Ok(Self::default());
        }
        // Where there are as many threads as cores, each stays on its own: a round lasts less than
        // a scheduler takes to part two threads that it has woken on one core. Where there are more
        // cores, others may be using the first ones.
        let cores = core_affinity::get_core_ids()
            .filter(|cores| threads.get() == cores.len())
            .unwrap_or_default();
        let builder = ThreadPoolBuilder::new().num_threads(threads.get());
        let stay = move |index: usize| {
            if let Some(&core) = cores.get(index) {
                core_affinity::set_for_current(core);
            }
        };
        let pool = builder.start_handler(stay).build()?;
        // A thread allocates while it starts, and when it first looks for another one's work: wait
        // until each has done both.
        pool.broadcast(|_| rayon::yield_now());
        Ok(Self {
            workers: Some(Arc::new(Workers { pool, idle: IdleThreads::new(threads.get()) })),
        })
    }

    /// Whether there are several.
    pub fn is_parallel(&self) -> bool {
        self.workers.is_some()
    }

    /// How many there are.
    pub fn count(&self) -> usize {
        self.workers.as_ref().map_or(1, |workers| workers.pool.current_num_threads())
    }

    /// Works on one of them, while the others look for what it shares: all that follows is to be
    /// called within.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match &self.workers {
            Some(workers) => workers.pool.install(|| workers.idle.run_with_idle(work)),
            None => work(),
        }
    }

    /// Does both, in parallel where another thread is free.
    pub fn join<A: Send, B: Send>(
        &self,
        first: impl FnOnce() -> A + Send,
        second: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        let Some(workers) = &self.workers else { return (first(), second()) };
        let is_done = AtomicBool::new(false);
        rayon::join(
            || {
                workers.idle.wake();
                let made = first();
                wait_for(&is_done);
                made
            },
            || {
                let made = second();
                is_done.store(true, Ordering::Release);
                made
            },
        )
    }

    /// Does the same work on each item, which is begun in their order; each thread takes the next
    /// one when it is done with one.
    pub fn for_each<T: Send>(&self, items: &mut [T], work: impl Fn(&mut T) + Sync) {
        if !self.is_parallel() {
            return items.iter_mut().for_each(work);
        }
        let worker_count = self.count().min(items.len());
        let queue = Mutex::new(items.iter_mut());
        let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
        self.run_on(worker_count, &|| {
            while let Some(item) = next() {
                work(item);
            }
        });
    }

    /// What a function makes of each item, in order.
    pub fn map<T: Copy + Send, U: Default + Send, const N: usize>(
        &self,
        items: &heapless::Vec<T, N>,
        make: impl Fn(T) -> U + Sync,
    ) -> heapless::Vec<U, N> {
        let mut made: heapless::Vec<U, N> = items.iter().map(|_| U::default()).collect();
        let mut pairs: heapless::Vec<(&mut U, T), N> =
            made.iter_mut().zip(items.iter().copied()).collect();
        self.for_each(&mut pairs, |(made, item)| **made = make(*item));
        drop(pairs);
        made
    }

    /// The first of these numbers for which something can be made, and that. Two threads take them
    /// in order, each with a memory of its own.
    pub fn find_first<M: Send, U: Send>(
        &self,
        numbers: Range<usize>,
        memories: [&mut M; 2],
        make: impl Fn(usize, &mut M) -> Option<U> + Sync,
    ) -> Option<(usize, U)> {
        let next = AtomicUsize::new(numbers.start);
        let least = AtomicUsize::new(numbers.end);
        let search = |memory: &mut M| {
            loop {
                let number = next.fetch_add(1, Ordering::Relaxed);
                if number >= least.load(Ordering::Relaxed) {
                    return None;
                }
                if let Some(made) = make(number, memory) {
                    least.fetch_min(number, Ordering::Relaxed);
                    return Some((number, made));
                }
            }
        };
        let [memory, other_memory] = memories;
        let (found, also_found) = self.join(|| search(memory), || search(other_memory));
        found.into_iter().chain(also_found).min_by_key(|(number, _)| *number)
    }

    /// Does the work with so many threads.
    fn run_on(&self, worker_count: usize, work: &(dyn Fn() + Sync)) {
        if worker_count > 1 {
            self.join(work, || self.run_on(worker_count - 1, work));
        } else {
            work();
        }
    }
}

/// Waits for a while without sleep, and does what else there is to do. What takes longer, or
/// panics, rayon waits for.
fn wait_for(is_done: &AtomicBool) {
    let is_done = || is_done.load(Ordering::Acquire);
    while !is_done() && poll(POLLS_MAX, is_done) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    fn threads(count: usize) -> Threads {
        Threads::new(NonZeroUsize::new(count).unwrap()).unwrap()
    }

    #[test]
    fn each_item_is_worked_on_once_whatever_the_threads() {
        for count in 1..=5 {
            let mut items: Vec<usize> = (0..1000).collect();
            let threads = threads(count);
            for _ in 0..20 {
                threads.run(|| threads.for_each(&mut items, |item| *item += 1));
            }
            assert!(
                items.iter().enumerate().all(|(index, &item)| item == index + 20),
                "{count} threads"
            );
            threads.run(|| threads.for_each(&mut [], |item: &mut usize| *item += 1));
        }
    }

    #[test]
    fn nested_joins_do_both() {
        fn leaves(threads: &Threads, depth: u32) -> u64 {
            if depth == 0 {
                return 1;
            }
            let (left, right) =
                threads.join(|| leaves(threads, depth - 1), || leaves(threads, depth - 1));
            left + right
        }
        for count in 1..=5 {
            let threads = threads(count);
            assert_eq!(threads.run(|| leaves(&threads, 10)), 1024, "{count} threads");
        }
    }

    #[test]
    fn the_first_of_all_is_found_whatever_the_threads() {
        for count in 1..=3 {
            let threads = threads(count);
            for first in 0..40 {
                let mut tried = [0, 0];
                let [one, other] = &mut tried;
                let make = |number: usize, tried: &mut usize| {
                    *tried += 1;
                    (number == first || number > first && number.is_multiple_of(3))
                        .then_some(10 * number)
                };
                let found = threads.run(|| threads.find_first(2..30, [one, other], make));
                let expected = if first < 2 { 3 } else { first };
                assert_eq!(
                    found,
                    (expected < 30).then_some((expected, 10 * expected)),
                    "{count} threads, {first}"
                );
                assert!(
                    count > 1 || tried == [expected.min(29) - 1, 0],
                    "one thread tries no more than it must: {tried:?}"
                );
            }
        }
    }

    #[test]
    fn sleeping_threads_are_woken() {
        let threads = threads(3);
        let long = || (0..2_000_000_u64).fold(0, |sum, item| std::hint::black_box(sum + item));
        for _ in 0..20 {
            let sums = threads.run(|| [(); 5].map(|()| (long(), threads.join(long, long))));
            assert!(sums.iter().all(|&(alone, (first, second))| alone == first && first == second));
        }
    }

    #[test]
    fn a_panic_is_passed_on_and_the_threads_work_on() {
        let threads = threads(2);
        for _ in 0..3 {
            let run =
                || threads.run(|| threads.for_each(&mut [1, 2, 3], |item| assert!(*item != 2)));
            assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).is_err());
        }
        assert_eq!(threads.run(|| threads.join(|| 1, || 2)), (1, 2));
    }
}
