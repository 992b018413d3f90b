//! The threads that share the work of a search.

use std::num::NonZeroUsize;
use std::ops::Range;
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::base::threads::cores;
use crate::base::threads::pool::Pool;
use crate::base::threads::tuning::ITEMS_MAX;

/// The threads that share work: the searching thread and helpers, or the searching thread alone.
#[derive(Debug, Clone, Default)]
pub struct Threads {
    pool: Option<Arc<Pool>>,
}

impl Threads {
    /// As many threads, at most one for each core that the process may use. The calling thread of
    /// [`Threads::run`] is one of them.
    ///
    /// # Errors
    /// The threads cannot be started.
    pub fn new(threads: NonZeroUsize) -> std::io::Result<Self> {
        Self::uncapped(threads.min(cores::available()))
    }

    /// As many threads, also where the process may use fewer cores: to test that no result depends
    /// on their number.
    ///
    /// # Errors
    /// The threads cannot be started.
    pub fn uncapped(threads: NonZeroUsize) -> std::io::Result<Self> {
        let helpers = NonZeroUsize::new(threads.get() - 1);
        Ok(Self { pool: helpers.map(Pool::new).transpose()?.map(Arc::new) })
    }

    /// Number of threads that share work at this moment. It changes while helpers stay away, so no
    /// result may depend on it.
    pub fn count(&self) -> usize {
        self.pool.as_ref().map_or(1, |pool| pool.attending())
    }

    /// Runs `work` on the calling thread while helpers poll for items. The other methods are called
    /// within `work`.
    pub fn run<T>(&self, work: impl FnOnce() -> T) -> T {
        match &self.pool {
            Some(pool) => pool.run(work),
            None => work(),
        }
    }

    /// Runs both functions: `first` on this thread, `second` on a helper if one is free.
    pub fn join<A, B: Send>(
        &self,
        first: impl FnOnce() -> A,
        second: impl FnOnce() -> B + Send,
    ) -> (A, B) {
        if self.pool.is_none() {
            return (first(), second());
        }
        let mut item = [(Some(second), None)];
        let made = self.for_each_beside(first, &mut item, |(second, made)| {
            *made = second.take().map(|second| second());
        });
        let [(_, Some(other))] = item else { unreachable!("every item has run") };
        (made, other)
    }

    /// Runs `work` on each item. Items are started in order; each thread takes the next one when it
    /// has finished one.
    pub fn for_each<T: Send>(&self, items: &mut [T], work: impl Fn(&mut T) + Sync) {
        self.for_each_beside(|| (), items, work);
    }

    /// Runs `work` on each item, in any order, while this thread runs `first`, after which it takes
    /// items too. Returns the result of `first`.
    pub fn for_each_beside<A, T: Send>(
        &self,
        first: impl FnOnce() -> A,
        items: &mut [T],
        work: impl Fn(&mut T) + Sync,
    ) -> A {
        let Some(pool) = &self.pool else {
            let made = first();
            items.iter_mut().for_each(work);
            return made;
        };
        let (offered, rest) = items.split_at_mut(items.len().min(ITEMS_MAX));
        let places = offered.as_mut_ptr().expose_provenance();
        let run = |index: usize| {
            let place = std::ptr::with_exposed_provenance_mut::<T>(places);
            // SAFETY: the index is that of an item, and every item is claimed by one thread only,
            // which may change it (`Send`), while this thread waits for all of them.
            work(unsafe { &mut *place.add(index) });
        };
        let made = pool.offer(offered.len(), &run, first);
        if !rest.is_empty() {
            self.for_each(rest, work);
        }
        made
    }

    /// The results of a function for all items, in order.
    pub fn map<T: Copy + Send, U: Default + Send, const N: usize>(
        &self,
        items: &heapless::Vec<T, N>,
        make: impl Fn(T) -> U + Sync,
    ) -> heapless::Vec<U, N> {
        self.map_beside(|| (), items, make).1
    }

    /// The results of a function for all items, in order, made while this thread runs `first`, after
    /// which it takes items too; before them the result of `first`.
    pub fn map_beside<A, T: Copy + Send, U: Default + Send, const N: usize>(
        &self,
        first: impl FnOnce() -> A,
        items: &heapless::Vec<T, N>,
        make: impl Fn(T) -> U + Sync,
    ) -> (A, heapless::Vec<U, N>) {
        let mut made: heapless::Vec<U, N> = items.iter().map(|_| U::default()).collect();
        let mut pairs: heapless::Vec<(&mut U, T), N> =
            made.iter_mut().zip(items.iter().copied()).collect();
        let first = self.for_each_beside(first, &mut pairs, |(made, item)| **made = make(*item));
        drop(pairs);
        (first, made)
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
}

#[cfg(test)]
mod tests {
    use super::*;

    fn threads(count: usize) -> Threads {
        Threads::uncapped(NonZeroUsize::new(count).unwrap()).unwrap()
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
