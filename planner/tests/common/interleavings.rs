//! Runs threads in every order of their accesses to shared words, up to a number of preemptions.
//!
//! One thread runs at a time. Before each access it may hand over to another one. A run follows a
//! list of choices; the next run changes the last choice that has alternatives left.

#![allow(clippy::unwrap_used, reason = "a lock that is poisoned fails the test")]

use std::cell::RefCell;
use std::io::Write;
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Condvar, Mutex};

use surefoot_planner::base::threads::word::Word;

thread_local! {
    /// The run that this thread is part of, and its number there.
    static RUN: RefCell<Option<(Arc<Scheduler>, usize)>> = const { RefCell::new(None) };
}

/// A word whose accesses may hand over to another thread.
pub struct ModelWord(AtomicU64);

/// Park and unpark of the threads of a run.
pub struct Parking(Vec<AtomicU64>);

#[derive(Clone, Copy, PartialEq)]
enum ThreadState {
    Ready,
    /// Waits for any access of another thread.
    Paused,
    Parked,
    Done,
}

struct Scheduler {
    state: Mutex<RunState>,
    changed: Condvar,
    preemptions_max: usize,
}

struct RunState {
    threads: Vec<ThreadState>,
    running: usize,
    /// The chosen alternative and the number of alternatives, of each choice so far.
    choices: Vec<(usize, usize)>,
    /// The number of choices made in this run.
    made: usize,
    preemptions: usize,
}

impl Word for ModelWord {
    fn new(value: u64) -> Self {
        Self(AtomicU64::new(value))
    }

    fn load(&self) -> u64 {
        hand_over(ThreadState::Ready);
        self.0.load(Ordering::SeqCst)
    }

    fn store(&self, value: u64) {
        hand_over(ThreadState::Ready);
        self.0.store(value, Ordering::SeqCst);
    }

    fn replace(&self, current: u64, new: u64) -> bool {
        hand_over(ThreadState::Ready);
        self.0.compare_exchange(current, new, Ordering::SeqCst, Ordering::SeqCst).is_ok()
    }

    fn decrement(&self) {
        hand_over(ThreadState::Ready);
        self.0.fetch_sub(1, Ordering::SeqCst);
    }

    fn pause(_count: u32) {
        hand_over(ThreadState::Paused);
    }
}

impl Parking {
    pub fn new(threads: usize) -> Self {
        Self((0..threads).map(|_| AtomicU64::new(0)).collect())
    }

    pub fn park(&self, thread: usize) {
        while self.0[thread].swap(0, Ordering::SeqCst) == 0 {
            hand_over(ThreadState::Parked);
        }
    }

    pub fn unpark(&self, thread: usize) {
        hand_over(ThreadState::Ready);
        self.0[thread].store(1, Ordering::SeqCst);
        RUN.with_borrow(|run| {
            let (scheduler, _) = run.as_ref().expect("a thread of a run");
            let mut state = scheduler.state.lock().unwrap();
            if state.threads[thread] == ThreadState::Parked {
                state.threads[thread] = ThreadState::Ready;
            }
        });
    }
}

/// Lets the scheduler choose who runs next. The calling thread is in the given state.
fn hand_over(own: ThreadState) {
    let run = RUN.with_borrow(Clone::clone);
    if let Some((scheduler, thread)) = run {
        scheduler.hand_over(thread, own);
    }
}

impl Scheduler {
    fn hand_over(&self, thread: usize, own: ThreadState) {
        let mut state = self.state.lock().unwrap();
        state.threads[thread] = own;
        state.choose(thread, self.preemptions_max);
        self.changed.notify_all();
        if own != ThreadState::Done {
            self.wait_for_turn(state, thread);
        }
    }

    fn wait_for_turn(&self, state: std::sync::MutexGuard<'_, RunState>, thread: usize) {
        drop(self.changed.wait_while(state, |state| state.running != thread).unwrap());
    }
}

impl RunState {
    /// Ends the process: the other threads of the run may wait for this one for ever.
    fn fail(&self, fault: &str) {
        let text = format!("{fault} after the choices {:?}\n", self.choices);
        let _ = std::io::stderr().write_all(text.as_bytes());
        std::process::exit(101);
    }

    /// Chooses the next thread: the same one where possible, the others as alternatives.
    fn choose(&mut self, thread: usize, preemptions_max: usize) {
        let is_ready = self.threads[thread] == ThreadState::Ready;
        if is_ready {
            let paused = |state: &&mut ThreadState| **state == ThreadState::Paused;
            self.threads.iter_mut().filter(paused).for_each(|state| *state = ThreadState::Ready);
        }
        let others = (0..self.threads.len())
            .filter(|&other| other != thread && self.threads[other] == ThreadState::Ready);
        let mut alternatives: Vec<usize> = is_ready.then_some(thread).into_iter().collect();
        if !is_ready || self.preemptions < preemptions_max {
            alternatives.extend(others);
        }
        if alternatives.is_empty() {
            if self.threads.iter().any(|state| *state != ThreadState::Done) {
                self.fail("no thread can proceed");
            }
            return;
        }
        if self.made == self.choices.len() {
            self.choices.push((0, alternatives.len()));
        }
        let (chosen, count) = self.choices[self.made];
        assert_eq!(count, alternatives.len(), "a run repeats the choices of the one before");
        self.made += 1;
        self.running = alternatives[chosen];
        self.preemptions += usize::from(is_ready && self.running != thread);
    }
}

/// Runs the threads that `begin` returns in every order; the first one begins. Returns the number
/// of orders.
///
/// The process ends where a thread panics, or no thread can proceed.
pub fn explore(
    preemptions_max: usize,
    mut begin: impl FnMut() -> Vec<Box<dyn FnOnce() + Send>>,
) -> usize {
    let mut choices = vec![];
    let mut orders = 0;
    loop {
        choices = run_once(preemptions_max, begin(), choices);
        orders += 1;
        while let Some((chosen, count)) = choices.pop() {
            if chosen + 1 < count {
                choices.push((chosen + 1, count));
                break;
            }
        }
        if choices.is_empty() {
            return orders;
        }
    }
}

fn run_once(
    preemptions_max: usize,
    threads: Vec<Box<dyn FnOnce() + Send>>,
    choices: Vec<(usize, usize)>,
) -> Vec<(usize, usize)> {
    let state = RunState {
        threads: vec![ThreadState::Ready; threads.len()],
        running: 0,
        choices,
        made: 0,
        preemptions: 0,
    };
    let scheduler =
        Arc::new(Scheduler { state: Mutex::new(state), changed: Condvar::new(), preemptions_max });
    std::thread::scope(|scope| {
        for (thread, run) in threads.into_iter().enumerate() {
            let scheduler = Arc::clone(&scheduler);
            scope.spawn(move || run_thread(&scheduler, thread, run));
        }
    });
    let mut state = scheduler.state.lock().unwrap();
    std::mem::take(&mut state.choices)
}

fn run_thread(scheduler: &Arc<Scheduler>, thread: usize, run: Box<dyn FnOnce() + Send>) {
    RUN.set(Some((Arc::clone(scheduler), thread)));
    let run = std::panic::AssertUnwindSafe(|| {
        let state = scheduler.state.lock().unwrap();
        scheduler.wait_for_turn(state, thread);
        run();
    });
    let outcome = std::panic::catch_unwind(run);
    RUN.set(None);
    if let Err(panic) = outcome {
        let words = panic.downcast_ref::<String>().map_or("a thread panicked", String::as_str);
        scheduler.state.lock().unwrap().fail(words);
    }
    scheduler.hand_over(thread, ThreadState::Done);
}
