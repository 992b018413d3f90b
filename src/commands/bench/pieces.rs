//! A search in pieces, each timed and assigned to a stage.

use surefoot_planner::pipeline::WorkCategory;
use surefoot_planner::{Outcome, Planner, Status};

use crate::report::command_error::CommandError;
use crate::system::clock::Stopwatch;
use crate::system::signals;

/// A piece of a search.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Piece {
    /// The category of most of its work, as an index into [`WorkCategory::NAMES`]: a stage that
    /// ends without any work passes on to the next in the same piece.
    pub stage: usize,
    /// Work units.
    pub work: u64,
    /// Time, s.
    pub seconds: f64,
}

/// Searches to the end in pieces that `advance` makes, and emits each.
///
/// # Errors
/// When a signal comes.
pub fn search(
    planner: &mut Planner,
    advance: fn(&mut Planner) -> Status,
    emit: &mut dyn FnMut(Piece),
) -> Result<Outcome, CommandError> {
    loop {
        let before = planner.stats();
        let watch = Stopwatch::start();
        let status = advance(planner);
        let seconds = watch.seconds();
        let after = planner.stats();
        let stage = busiest(&before.work_by_category, &after.work_by_category);
        emit(Piece { stage, work: after.work - before.work, seconds });
        if let Status::Done(outcome) = status {
            return Ok(outcome);
        }
        if let Some(signal) = signals::raised() {
            return Err(CommandError::Interrupted(signal));
        }
    }
}

/// The stage whose work grew most.
fn busiest(before: &[u64; WorkCategory::COUNT], after: &[u64; WorkCategory::COUNT]) -> usize {
    (0..WorkCategory::COUNT).rev().max_by_key(|&stage| after[stage] - before[stage]).unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_piece_belongs_to_the_stage_that_grew_most() {
        let mut after = [0; WorkCategory::COUNT];
        assert_eq!(busiest(&[0; WorkCategory::COUNT], &after), 0);
        (after[1], after[3]) = (2, 5);
        assert_eq!(busiest(&[0; WorkCategory::COUNT], &after), 3);
        assert_eq!(busiest(&after, &after), 0);
    }
}
