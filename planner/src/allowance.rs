//! Pieces of work that are advanced side by side, a unit at a time, within one budget.
//!
//! Every piece is worked on by itself, and none is taken as done before all have ended. So neither the number of threads nor the size of
//! budgets can matter to what is made.

use crate::threads::Threads;

/// What a piece of work may spend now, and has spent of it, in units.
#[derive(Debug, Clone, Copy, Default)]
pub struct Allowance {
    allowed: u64,
    spent: u64,
}

/// Work that comes to an end by units.
pub trait Piece: Send {
    /// Whether nothing is left to do.
    fn has_ended(&self) -> bool;

    /// Where its allowance is kept.
    fn allowance(&mut self) -> &mut Allowance;
}

/// How many of at most so many items a budget allows, each one unit of work.
pub fn items_in(budget: u64, items_max: usize) -> usize {
    usize::try_from(budget).map_or(items_max, |budget| budget.min(items_max))
}

/// Advances all pieces by at most so many units together. Answers how many were spent: less than the budget means that all have ended.
pub fn advance<T: Piece>(pieces: &mut [T], budget: u64, threads: &Threads, unit: impl Fn(&mut T) + Sync) -> u64 {
    let advance_one = |piece: &mut T| {
        let allowed = std::mem::take(piece.allowance()).allowed;
        let mut spent = 0;
        while spent < allowed && !piece.has_ended() {
            unit(piece);
            spent += 1;
        }
        piece.allowance().spent = spent;
    };
    let mut spent = 0;
    while spent < budget && allot(pieces, budget - spent) {
        threads.each(pieces, advance_one);
        spent += pieces.iter_mut().map(|piece| piece.allowance().spent).sum::<u64>();
    }
    spent
}

/// Shares a budget out among the pieces that have not ended; `false` where there are none.
fn allot<T: Piece>(pieces: &mut [T], budget: u64) -> bool {
    let active = pieces.iter().filter(|piece| !piece.has_ended()).count() as u64;
    for (index, piece) in pieces.iter_mut().filter(|piece| !piece.has_ended()).enumerate() {
        piece.allowance().allowed = budget / active + u64::from((index as u64) < budget % active);
    }
    active > 0
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts down to its end.
    struct Countdown(u64, Allowance);

    impl Piece for Countdown {
        fn has_ended(&self) -> bool {
            self.0 == 0
        }

        fn allowance(&mut self) -> &mut Allowance {
            &mut self.1
        }
    }

    #[test]
    fn a_budget_is_spent_to_its_last_unit_or_until_all_have_ended() {
        let mut pieces = [5, 0, 1, 9].map(|units| Countdown(units, Allowance::default()));
        let mut advance = |budget| advance(&mut pieces, budget, &Threads::default(), |piece| piece.0 -= 1);
        assert_eq!([advance(1), advance(7), advance(0), advance(100), advance(100)], [1, 7, 0, 7, 0]);
    }
}
