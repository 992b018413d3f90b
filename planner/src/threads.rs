//! Work that the threads of a pool do side by side, with nobody asleep between two short pieces of it.
//!
//! Rayon's own loops split their items in two until each stands alone, and a thread that waits falls asleep after some 15 us; waking it
//! takes as long again. Items take 20 us to some milliseconds here, so both cost much of what threads bring. What is made depends on
//! neither: each item is worked on by itself.

use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Mutex, PoisonError};

use rayon::Yield;

/// How often a thread that waits looks again before it lets rayon put it to sleep: some 150 us, several times what waking it takes.
const LOOKS_MAX: u32 = 1024;

/// Does both, side by side where another thread is free. To be called inside a thread pool.
pub fn both<A: Send, B: Send>(first: impl FnOnce() -> A + Send, second: impl FnOnce() -> B + Send) -> (A, B) {
    let is_done = AtomicBool::new(false);
    rayon::join(
        || {
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

/// Does the same work on each item, which is begun in their order; each thread takes the next one when it is done with one. To be
/// called inside a thread pool.
pub fn each<T: Send>(items: &mut [T], work: impl Fn(&mut T) + Sync) {
    let workers = rayon::current_num_threads().min(items.len());
    let queue = Mutex::new(items.iter_mut());
    let next = || queue.lock().unwrap_or_else(PoisonError::into_inner).next();
    do_with(workers, &|| {
        while let Some(item) = next() {
            work(item);
        }
    });
}

/// What a function makes of each item, in order; side by side where the caller is inside a thread pool, `parallel`.
pub fn map<T: Copy + Send, U: Default + Send, const N: usize>(
    parallel: bool,
    items: &heapless::Vec<T, N>,
    make: impl Fn(T) -> U + Sync,
) -> heapless::Vec<U, N> {
    let mut made: heapless::Vec<U, N> = items.iter().map(|_| U::default()).collect();
    if parallel {
        let mut pairs: heapless::Vec<(&mut U, T), N> = made.iter_mut().zip(items.iter().copied()).collect();
        each(&mut pairs, |(made, item)| **made = make(*item));
    } else {
        made.iter_mut().zip(items).for_each(|(made, &item)| *made = make(item));
    }
    made
}

/// Does the work with so many threads.
fn do_with(workers: usize, work: &(dyn Fn() + Sync)) {
    if workers > 1 {
        both(work, || do_with(workers - 1, work));
    } else {
        work();
    }
}

/// Waits for a while without sleep, and does what else there is to do. What takes longer, or panics, rayon waits for.
fn wait_for(is_done: &AtomicBool) {
    let mut looks = 0;
    while looks < LOOKS_MAX && !is_done.load(Ordering::Acquire) {
        if rayon::yield_now() == Some(Yield::Executed) {
            looks = 0;
        } else {
            looks += 1;
            std::hint::spin_loop();
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn inside_pool<T: Send>(threads: usize, work: impl FnOnce() -> T + Send) -> T {
        rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap().install(work)
    }

    #[test]
    fn each_item_is_worked_on_once_whatever_the_threads() {
        for threads in 1..=5 {
            let mut items: Vec<usize> = (0..1000).collect();
            for _ in 0..20 {
                inside_pool(threads, || each(&mut items, |item| *item += 1));
            }
            assert!(items.iter().enumerate().all(|(index, &item)| item == index + 20), "{threads} threads");
        }
        inside_pool(2, || each(&mut [], |item: &mut usize| *item += 1));
    }

    #[test]
    fn both_are_done_within_both() {
        fn leaves(depth: u32) -> u64 {
            if depth == 0 {
                return 1;
            }
            let (left, right) = both(|| leaves(depth - 1), || leaves(depth - 1));
            left + right
        }
        for threads in 1..=5 {
            assert_eq!(inside_pool(threads, || leaves(10)), 1024, "{threads} threads");
        }
    }

    #[test]
    fn a_panic_is_passed_on() {
        let caught = std::panic::catch_unwind(|| inside_pool(2, || each(&mut [1, 2, 3], |item| assert!(*item != 2))));
        assert!(caught.is_err());
    }
}
