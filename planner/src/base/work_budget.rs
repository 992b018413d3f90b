//! Tasks that share one budget of work units and advance in parallel, one unit at a time.
//!
//! Every task is independent, and results are used only when all tasks have ended. So they depend
//! neither on the number of threads nor on the size of budgets.
//!
//! When a thread finds no further task, the others stop after their current unit, and the rest of
//! the budget is distributed again.

use std::sync::atomic::{AtomicUsize, Ordering};

use crate::base::threads::Threads;

/// The work units that a task may spend, and has spent.
#[derive(Debug, Clone, Copy, Default)]
pub struct WorkBudget {
    allowed: u64,
    spent: u64,
}

/// A task that advances by work units until it ends.
pub trait BudgetedTask: Send {
    /// Whether the task has ended.
    fn has_ended(&self) -> bool;

    /// The budget of the task.
    fn work_budget(&mut self) -> &mut WorkBudget;
}

/// The number of items of one work unit each that a budget allows, at most `items_max`.
pub fn items_in(budget: u64, items_max: usize) -> usize {
    usize::try_from(budget).map_or(items_max, |budget| budget.min(items_max))
}

/// Advances all tasks by at most `budget` units together and returns the units spent. Less than the
/// budget means that all tasks have ended.
pub fn advance<T: BudgetedTask>(
    tasks: &mut [T],
    budget: u64,
    threads: &Threads,
    unit: impl Fn(&mut T) + Sync,
) -> u64 {
    advance_several(tasks, 1, budget, threads, unit)
}

/// Advances all tasks by at most `budget` units together until fewer than `tasks_min` of them have
/// not ended, and returns the units spent.
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

/// Distributes a budget among the `active` tasks that have not ended.
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
    fn a_budget_is_spent_unless_all_tasks_end() {
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
