//! Runs short work items in parallel. Idle threads poll for about 2 ms before they sleep, because
//! waking one takes 50 µs.
//!
//! Rayon's own loops split their items in halves down to single items, and their waiting threads
//! sleep. Items take 20 µs to some milliseconds here, so both cost much of the gain. Results do not
//! depend on the threads: each item is computed independently.

use std::num::NonZeroUsize;
use std::ops::Range;
use std::sync::atomic::{AtomicBool, AtomicUsize, Ordering};
use std::sync::{Arc, Mutex, PoisonError};

use rayon::{ThreadPool, ThreadPoolBuildError, ThreadPoolBuilder};

use crate::base::idle_threads::{IdleThreads, poll};
use crate::base::tuning::WAIT_POLLS_MAX;

/// The threads that share work: those of a pool, or the calling thread alone.
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
    /// A pool of threads; for one thread the calling thread alone.
    ///
    /// # Errors
    /// The threads cannot be started.
    pub fn new(threads: NonZeroUsize) -> Result<Self, ThreadPoolBuildError> {
        if threads.get() == 1 {
            return Ok(Self::default());
        }
        // With as many threads as cores each thread is pinned to a core: a batch lasts less than
        // the scheduler takes to separate two threads on one core. With more cores than threads
        // other processes may use the first ones.
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
        // A thread allocates memory when it starts and when it first steals work. Both happen here.
        pool.broadcast(|_| rayon::yield_now());
        Ok(Self {
            workers: Some(Arc::new(Workers { pool, idle: IdleThreads::new(threads.get()) })),
        })
    }

    /// Whether there are several threads.
    pub fn is_parallel(&self) -> bool {
        self.workers.is_some()
    }

    /// Number of threads.
    pub fn count(&self) -> usize {
        self.workers.as_ref().map_or(1, |workers| workers.pool.current_num_threads())
    }

    /// Runs `work` on one thread while the others poll for shared parts of it. The other methods
    /// are called within `work`.
    pub fn run<T: Send>(&self, work: impl FnOnce() -> T + Send) -> T {
        match &self.workers {
            Some(workers) => workers.pool.install(|| workers.idle.run_with_idle(work)),
            None => work(),
        }
    }

    /// Runs both functions, in parallel if another thread is free.
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

    /// Runs `work` on each item. Items are started in order; each thread takes the next one when it
    /// has finished one.
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

    /// The results of a function for all items, in order.
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

    /// The first number of a range for which `make` returns a result, with that result. Two threads
    /// take the numbers in order, each with its own memory.
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

    /// Runs `work` on `worker_count` threads.
    fn run_on(&self, worker_count: usize, work: &(dyn Fn() + Sync)) {
        if worker_count > 1 {
            self.join(work, || self.run_on(worker_count - 1, work));
        } else {
            work();
        }
    }
}

/// Waits without sleep for a while and runs other shared work meanwhile. Rayon waits for longer
/// work and for work that panics.
fn wait_for(is_done: &AtomicBool) {
    let is_done = || is_done.load(Ordering::Acquire);
    while !is_done() && poll(WAIT_POLLS_MAX, is_done) {}
}

#[cfg(test)]
mod tests {
    use super::*;

    fn threads(count: usize) -> Threads {
        Threads::new(NonZeroUsize::new(count).unwrap()).unwrap()
    }

    #[test]
    fn each_item_is_processed_once_with_any_number_of_threads() {
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
    fn nested_joins_run_both_functions() {
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
    fn the_first_number_is_found_with_any_number_of_threads() {
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
                    "one thread tries no further number: {tried:?}"
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
    fn a_panic_propagates_and_the_pool_stays_usable() {
        let threads = threads(2);
        for _ in 0..3 {
            let run =
                || threads.run(|| threads.for_each(&mut [1, 2, 3], |item| assert!(*item != 2)));
            assert!(std::panic::catch_unwind(std::panic::AssertUnwindSafe(run)).is_err());
        }
        assert_eq!(threads.run(|| threads.join(|| 1, || 2)), (1, 2));
    }
}
