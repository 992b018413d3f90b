//! Tasks that are advanced in parallel, a unit at a time, within one budget.
//!
//! Every task is worked on by itself, and none is taken as done before all have ended. So neither
//! the number of threads nor the size of budgets can matter to what is made.
//!
//! A thread that finds nothing left to take up need not wait until the others have used up what
//! they were allowed: they leave off after the unit they are at, and what is left is shared anew.

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::base::threads::Threads;

/// What a task may spend now, and has spent of it, in units.
#[derive(Debug, Clone, Copy, Default)]
pub struct WorkBudget {
    allowed: u64,
    spent: u64,
}

/// Work that comes to an end by units.
pub trait BudgetedTask: Send {
    /// Whether nothing is left to do.
    fn has_ended(&self) -> bool;

    /// Where its allowance is kept.
    fn work_budget(&mut self) -> &mut WorkBudget;
}

/// How many of at most so many items a budget allows, each one unit of work.
pub fn items_in(budget: u64, items_max: usize) -> usize {
    usize::try_from(budget).map_or(items_max, |budget| budget.min(items_max))
}

/// Advances all tasks by at most so many units together. Answers how many were spent: less than
/// the budget means that all have ended.
pub fn advance<T: BudgetedTask>(
    tasks: &mut [T],
    budget: u64,
    threads: &Threads,
    unit: impl Fn(&mut T) + Sync,
) -> u64 {
    advance_several(tasks, 1, budget, threads, unit)
}

/// The same, but no farther once fewer than `tasks_min` are left that have not ended.
pub fn advance_several<T: BudgetedTask>(
    tasks: &mut [T],
    tasks_min: usize,
    budget: u64,
    threads: &Threads,
    unit: impl Fn(&mut T) + Sync,
) -> u64 {
    let mut spent = 0;
    loop {
        let active = tasks.iter().filter(|task| !task.has_ended()).count();
        if spent == budget || active < tasks_min {
            return spent;
        }
        distribute(tasks, active as u64, budget - spent);
        let enough = threads.count().min(active);
        let busy = AtomicUsize::new(active);
        threads.for_each(tasks, |task| {
            let allowed = std::mem::take(task.work_budget()).allowed;
            let mut spent = 0;
            while spent < allowed
                && !task.has_ended()
                && (spent == 0 || busy.load(Ordering::Relaxed) >= enough)
            {
                unit(task);
                spent += 1;
            }
            busy.fetch_sub(usize::from(spent > 0), Ordering::Relaxed);
            task.work_budget().spent = spent;
        });
        spent += tasks.iter_mut().map(|task| task.work_budget().spent).sum::<u64>();
    }
}

/// Shares a budget out among the tasks that have not ended, which are so many.
fn distribute<T: BudgetedTask>(tasks: &mut [T], active: u64, budget: u64) {
    for (index, task) in tasks.iter_mut().filter(|task| !task.has_ended()).enumerate() {
        task.work_budget().allowed = budget / active + u64::from((index as u64) < budget % active);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Counts down to its end.
    struct Countdown(u64, WorkBudget);

    impl BudgetedTask for Countdown {
        fn has_ended(&self) -> bool {
            self.0 == 0
        }

        fn work_budget(&mut self) -> &mut WorkBudget {
            &mut self.1
        }
    }

    #[test]
    fn a_budget_is_spent_to_its_last_unit_or_until_all_have_ended() {
        let mut tasks = [5, 0, 1, 9].map(|units| Countdown(units, WorkBudget::default()));
        let mut advance =
            |budget| advance(&mut tasks, budget, &Threads::default(), |task| task.0 -= 1);
        assert_eq!(
            [advance(1), advance(7), advance(0), advance(100), advance(100)],
            [1, 7, 0, 7, 0]
        );
    }

    #[test]
    fn the_last_task_is_left_to_the_caller() {
        for threads in [1, 2, 3].map(|count| Threads::new(count.try_into().unwrap()).unwrap()) {
            let mut tasks = [3, 40, 0, 7].map(|units| Countdown(units, WorkBudget::default()));
            let mut advance = |tasks_min| {
                let spent = threads.run(|| {
                    advance_several(&mut tasks, tasks_min, 100, &threads, |task| task.0 -= 1)
                });
                (spent, tasks.iter().filter(|task| !task.has_ended()).count())
            };
            let (spent, left) = advance(2);
            assert!(left == 1 && (10..50).contains(&spent), "{spent} units, {left} left");
            assert_eq!(advance(2), (0, 1));
            assert_eq!(advance(1), (50 - spent, 0));
        }
    }
}
