//! Makes the smooth path of a complete plan: the motion that is timed and executed.

use crate::base::capacity::ArenaFull;
use crate::pipeline::outcome::Outcome;
use crate::pipeline::search::Search;
use crate::pipeline::stage::Event;
use crate::preparation::planning_context::PlanningContext;
use crate::smooth_path::smoother::{SearchedPlan, Smoother, SmoothingInputs};
use crate::timing::path_point::Path;

/// Makes the smooth path, one configuration for each unit of work, and pauses where a further part
/// of it can be timed. A plan without smooth motion passes the stage without work.
#[derive(Debug)]
pub(crate) struct SmoothPathStage {
    /// The path; none where plans keep the searched motion.
    smoother: Option<Smoother>,
    /// Whether its first part is needed before the last one is made.
    in_parts: bool,
    has_begun: bool,
}

/// The smooth path so far.
#[derive(Debug, Clone, Copy)]
pub(crate) struct SmoothPath<'a> {
    /// The part that does not change any more.
    pub path: Path<'a>,
    /// Whether that is all of it.
    pub is_complete: bool,
}

impl SmoothPathStage {
    /// Reserves memory for plans of `edges_max` edges and paths of `points_max` points, if plans
    /// are smoothed. `in_parts`: whether the first part of a path is needed before the last one is
    /// made.
    pub fn new(is_smooth: bool, in_parts: bool, edges_max: usize, points_max: usize) -> Self {
        let smoother = is_smooth.then(|| Smoother::new(edges_max, points_max));
        Self { smoother, in_parts, has_begun: false }
    }

    /// Begins the path of another plan with the next step.
    pub fn begin_another(&mut self) {
        self.has_begun = false;
    }

    /// Makes configurations within `budget` units of work, until another span does not change any
    /// more.
    ///
    /// # Errors
    /// The arena of points is full.
    pub fn step(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        budget: u64,
    ) -> Result<Event, ArenaFull> {
        let Some(smoother) = &mut self.smoother else { return Ok(Event::Done) };
        let Search { roadmap, segmentation, stats, limits, .. } = search;
        let inputs = SmoothingInputs {
            constraints: &context.constraints,
            plan: SearchedPlan { roadmap, nodes: segmentation.plan() },
            leg_extension: context.preparation.gait().leg_extension,
        };
        if !self.has_begun {
            smoother.begin(&inputs, self.in_parts);
            self.has_begun = true;
        }
        let work_left = (inputs.plan.nodes.len() + roadmap.waypoints_len()) as u64;
        let (begin, smoothed_until) = (stats.work, limits.work_max.saturating_sub(work_left));
        let final_spans = smoother.path().spans.len();
        let is_paused =
            |smoother: &Smoother| smoother.is_over() || smoother.path().spans.len() > final_spans;
        while !is_paused(smoother) && stats.work - begin < budget {
            if smoother.is_blocked() {
                search.outcome = Some(Outcome::NoContinuation);
                return Ok(Event::Blocked);
            }
            if stats.work >= smoothed_until {
                smoother.abandon();
            }
            if let Some(rejection) = smoother.advance(&inputs)? {
                stats.rejections[rejection as usize] += 1;
            }
            stats.work += 1;
        }
        if smoother.is_over() {
            stats.searched_phases = smoother.searched_phases();
        }
        Ok(if is_paused(smoother) { Event::Done } else { Event::Continue })
    }

    /// The path of a plan; none where plans keep the searched motion.
    pub fn path(&self) -> Option<SmoothPath<'_>> {
        let smoother = self.smoother.as_ref()?;
        Some(SmoothPath { path: smoother.path(), is_complete: smoother.is_over() })
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.smoother.as_ref().map_or(0, Smoother::bytes)
    }
}
