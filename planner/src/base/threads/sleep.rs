//! Sleep of a helper thread until there are items.

use crate::base::threads::word::Word;

/// Whether a helper thread sleeps.
#[derive(Debug)]
pub struct Sleep<W> {
    is_asleep: W,
}

impl<W: Word> Default for Sleep<W> {
    fn default() -> Self {
        Self { is_asleep: W::new(0) }
    }
}

impl<W: Word> Sleep<W> {
    /// Calls `park` until the thread is woken, unless `has_work`. `park` returns after a call of
    /// the other side's `unpark`, also of an earlier one, and perhaps without one.
    pub fn sleep(&self, has_work: impl Fn() -> bool, park: impl Fn()) {
        self.is_asleep.store(1);
        // Work that was offered before this thread counted as asleep did not wake it.
        while !has_work() && self.is_asleep.load() == 1 {
            park();
        }
        self.is_asleep.store(0);
    }

    /// Whether the thread sleeps.
    pub fn is_asleep(&self) -> bool {
        self.is_asleep.load() == 1
    }

    /// Wakes the thread if it sleeps. Called after work was offered.
    pub fn wake(&self, unpark: impl Fn()) {
        if self.is_asleep.load() == 1 && self.is_asleep.replace(1, 0) {
            unpark();
        }
    }
}
