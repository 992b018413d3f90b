//! The relaxed problem between start and goal: shows where there can be no plan, and gives stage P
//! a coarse path where there may be one.

use std::sync::Arc;

use glam::DVec3;
use heapless::Vec as BoundedVec;
use surefoot_shared_types::base::spatial::rotation_about;

use crate::base::capacity::ArenaFull;
use crate::motion::ids::{GOAL, START};
use crate::pipeline::outcome::Outcome;
use crate::pipeline::search::Search;
use crate::pipeline::stage::Event;
use crate::possibility::{MidFeetPose, RouteCondition, UpperBody, UpperBodyFit};
use crate::preparation::planning_context::PlanningContext;
use crate::relaxation::{
    Extent, Obstruction, PathSearch, RelaxedEnd, RelaxedOutcome, RelaxedProblem, RelaxedWorld,
};

fn relaxed(context: &PlanningContext) -> RelaxedWorld<'_> {
    RelaxedWorld {
        constraints: &context.constraints,
        surfaces: &context.surfaces,
        step_reach: context.preparation.step_limits().farthest(),
    }
}

/// Lateral distance from obstacles beyond which a path is as good as any, m.
const CLEARANCE: f64 = 0.25;

/// What the stage does next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Activity {
    /// Begins with the problem.
    Idle,
    Problem,
    Path,
    /// Goes on with the problem: a path was found, and no route along it.
    Paused,
}

/// Solves the relaxed problem, by bounded pieces of work. Where its steps reach the goal, a path is
/// tried before the rest of the problem.
#[derive(Debug)]
pub(crate) struct RelaxationStage {
    problem: RelaxedProblem,
    path: PathSearch,
    /// The robot above its legs.
    upper_body: Arc<UpperBody>,
    activity: Activity,
    /// Whether a path was searched.
    has_tried_path: bool,
}

impl RelaxationStage {
    /// A problem with reserved memory. Allocates.
    pub fn new(upper_body: Arc<UpperBody>) -> Self {
        Self {
            problem: RelaxedProblem::new(),
            path: PathSearch::new(),
            upper_body,
            activity: Activity::Idle,
            has_tried_path: false,
        }
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.problem.bytes() + self.path.bytes()
    }

    /// Advances the relaxed problem and the search for a path by at most `budget` units of work.
    ///
    /// # Errors
    /// None.
    pub fn step(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        budget: u64,
    ) -> Result<Event, ArenaFull> {
        self.begin(context, search);
        for _ in 0..budget.max(1) {
            search.stats.work += 1;
            let event = match self.activity {
                Activity::Path => self.advance_path(context, search),
                _ => self.advance_problem(context, search),
            };
            if event != Event::Continue {
                return Ok(event);
            }
        }
        Ok(Event::Continue)
    }

    /// Begins with the problem, or goes on with it. Where a route is doubtful, it is solved anew.
    fn begin(&mut self, context: &PlanningContext, search: &Search) {
        let is_doubtful = search.route.condition() == RouteCondition::Necessary;
        match self.activity {
            Activity::Paused if !is_doubtful => self.activity = Activity::Problem,
            Activity::Idle | Activity::Paused => {
                let ends = [START, GOAL].map(|end| relaxed_end(search, end));
                let extent = match (search.guide.is_ground_due, is_doubtful) {
                    (true, _) => Extent::Elements,
                    (false, true) => Extent::Whole,
                    (false, false) => Extent::Usual,
                };
                self.problem.begin(&relaxed(context), ends, extent);
                self.activity = Activity::Problem;
                self.has_tried_path |= is_doubtful;
            }
            Activity::Problem | Activity::Path => {}
        }
    }

    /// Does one unit of work on the problem.
    fn advance_problem(&mut self, context: &PlanningContext, search: &mut Search) -> Event {
        match self.problem.advance(&relaxed(context)) {
            None => {
                if !self.has_tried_path
                    && let Some((grid, _)) = self.problem.reached()
                {
                    self.path.begin(&grid, search.route.ends().map(|end| end.position));
                    (self.activity, self.has_tried_path) = (Activity::Path, true);
                }
                Event::Continue
            }
            Some(RelaxedOutcome::Open) => {
                self.activity = Activity::Idle;
                search.guide.is_relaxed |= !std::mem::take(&mut search.guide.is_ground_due);
                Event::Done
            }
            Some(RelaxedOutcome::Obstructed(obstruction)) => {
                search.outcome = Some(Outcome::Impossible(obstruction));
                Event::Impossible
            }
        }
    }

    /// Does one unit of work on the path. Once it is found, stage P follows it.
    fn advance_path(&mut self, context: &PlanningContext, search: &mut Search) -> Event {
        let Some((grid, reached)) = self.problem.reached() else { return Event::Continue };
        let cost = |position, way| cost(&self.upper_body, context, position, way);
        if !self.path.advance(&grid, reached, cost) {
            return Event::Continue;
        }
        self.activity = Activity::Problem;
        if self.path.path().is_empty() {
            return Event::Continue;
        }
        self.activity = Activity::Paused;
        search.route.follow(self.path.path());
        Event::Done
    }
}

/// The cost of a metre of a path at a point on the ground, relative to that of the upright robot
/// beside nothing; `None` where the robot does not fit.
fn cost(
    upper_body: &UpperBody,
    context: &PlanningContext,
    position: DVec3,
    way: DVec3,
) -> Option<f64> {
    let yaw = libm::atan2(way.y, way.x);
    let fit_at = |lateral: f64| {
        let position = position + rotation_about(DVec3::Z, yaw) * (lateral * DVec3::Y);
        upper_body.fit(&context.constraints.collision, &MidFeetPose { position, yaw })
    };
    match fit_at(0.0) {
        UpperBodyFit::None => None,
        UpperBodyFit::Core => Some(16.0),
        UpperBodyFit::Crouched => Some(4.0),
        UpperBodyFit::Upright => {
            let mut sides = [-CLEARANCE, CLEARANCE].into_iter();
            let is_clear = sides.all(|lateral| fit_at(lateral) == UpperBodyFit::Upright);
            Some(if is_clear { 1.0 } else { 2.0 })
        }
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
    problem.begin(&world, [START, GOAL].map(|end| relaxed_end(search, end)), Extent::Whole);
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
