//! The relaxed problem between start and goal: shows where there can be no plan.

use heapless::Vec as BoundedVec;

use crate::base::capacity::ArenaFull;
use crate::motion::ids::{GOAL, START};
use crate::pipeline::outcome::Outcome;
use crate::pipeline::search::Search;
use crate::pipeline::stage::Event;
use crate::possibility::RouteCondition;
use crate::preparation::planning_context::PlanningContext;
use crate::relaxation::{Obstruction, RelaxedEnd, RelaxedOutcome, RelaxedProblem, RelaxedWorld};

fn relaxed(context: &PlanningContext) -> RelaxedWorld<'_> {
    RelaxedWorld {
        constraints: &context.constraints,
        surfaces: &context.surfaces,
        step_reach: context.preparation.step_limits().farthest(),
    }
}

/// Solves the relaxed problem, by bounded pieces of work.
#[derive(Debug)]
pub(crate) struct RelaxationStage {
    problem: RelaxedProblem,
    is_begun: bool,
}

impl RelaxationStage {
    /// A problem with reserved memory. Allocates.
    pub fn new() -> Self {
        Self { problem: RelaxedProblem::new(), is_begun: false }
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.problem.bytes()
    }

    /// Advances the relaxed problem by at most `budget` units of work.
    ///
    /// # Errors
    /// None.
    pub fn step(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        budget: u64,
    ) -> Result<Event, ArenaFull> {
        if !std::mem::replace(&mut self.is_begun, true) {
            let ends = [START, GOAL].map(|end| relaxed_end(search, end));
            let is_doubtful = search.route.condition() == RouteCondition::Necessary;
            self.problem.begin(&relaxed(context), ends, is_doubtful);
        }
        for _ in 0..budget.max(1) {
            search.stats.work += 1;
            match self.problem.advance(&relaxed(context)) {
                None => {}
                Some(RelaxedOutcome::Open) => {
                    self.is_begun = false;
                    return Ok(Event::Done);
                }
                Some(RelaxedOutcome::Obstructed(obstruction)) => {
                    search.outcome = Some(Outcome::Impossible(obstruction));
                    return Ok(Event::Impossible);
                }
            }
        }
        Ok(Event::Continue)
    }
}

/// Why no plan is possible, if the relaxed problem shows it; `None` before start and goal are
/// known.
pub(crate) fn obstruction(context: &PlanningContext, search: &Search) -> Option<Obstruction> {
    if search.roadmap.boundaries_len() <= GOAL {
        return None;
    }
    let world = relaxed(context);
    let mut problem = RelaxedProblem::new();
    problem.begin(&world, [START, GOAL].map(|end| relaxed_end(search, end)), true);
    loop {
        match problem.advance(&world) {
            None => {}
            Some(RelaxedOutcome::Open) => return None,
            Some(RelaxedOutcome::Obstructed(obstruction)) => return Some(obstruction),
        }
    }
}

/// The robot at a boundary: its root, and the soles of the feet that carry it.
fn relaxed_end(search: &Search, end: usize) -> RelaxedEnd {
    let boundary = search.roadmap.boundary(end);
    let standing = (0..2).filter(|&limb| boundary.support.carries(limb));
    let soles = standing.map(|limb| boundary.state.world_from_soles[limb].translation);
    let soles: BoundedVec<_, 2> = soles.collect();
    RelaxedEnd { soles, world_from_root: boundary.state.configuration.world_from_root }
}
