//! Makes the smooth path of a complete plan: the motion that is timed and executed.

use crate::base::capacity::ArenaFull;
use crate::pipeline::search::Search;
use crate::pipeline::stage::Event;
use crate::preparation::planning_context::PlanningContext;
use crate::smooth_path::smoother::{SearchedPlan, Smoother, SmoothingInputs};
use crate::timing::path_point::Path;

/// Makes the smooth path, one configuration for each unit of work. A plan without smooth motion
/// passes the stage without work.
#[derive(Debug)]
pub(crate) struct SmoothPathStage {
    /// The path; none where plans keep the searched motion.
    smoother: Option<Smoother>,
    has_begun: bool,
}

impl SmoothPathStage {
    /// Reserves memory for plans of `edges_max` edges and paths of `points_max` points, if plans
    /// are smoothed.
    pub fn new(is_smooth: bool, edges_max: usize, points_max: usize) -> Self {
        Self { smoother: is_smooth.then(|| Smoother::new(edges_max, points_max)), has_begun: false }
    }

    /// Makes configurations within `budget` units of work.
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
            smoother.begin(&inputs);
            self.has_begun = true;
        }
        let work_left = (inputs.plan.nodes.len() + roadmap.waypoints_len()) as u64;
        let (begin, smoothed_until) = (stats.work, limits.work_max.saturating_sub(work_left));
        while !smoother.is_over() && stats.work - begin < budget {
            if stats.work >= smoothed_until {
                smoother.abandon();
            }
            if let Some(rejection) = smoother.advance(&inputs)? {
                stats.rejections[rejection as usize] += 1;
            }
            stats.work += 1;
        }
        if !smoother.is_over() {
            return Ok(Event::Continue);
        }
        self.has_begun = false;
        stats.searched_phases = smoother.searched_phases();
        Ok(Event::Done)
    }

    /// The path of a plan; none where plans keep the searched motion.
    pub fn path(&self) -> Option<Path<'_>> {
        let smoother = self.smoother.as_ref()?;
        Some(Path { points: smoother.points(), spans: smoother.spans() })
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.smoother.as_ref().map_or(0, Smoother::bytes)
    }
}
