//! Other postures at the goal, for a goal whose first one cannot be reached.

use crate::base::capacity::ArenaFull;
use crate::constraints::mode_state::ModeState;
use crate::motion::ids::{GOAL, boundary_node};
use crate::pipeline::recovery_policy::ALTERNATIVE_FAILURES;
use crate::pipeline::search::Search;
use crate::preparation::planning_context::PlanningContext;
use crate::primitives::transition_configuration::sample_double;
use crate::primitives::transition_pair::TransitionPair;

/// Attempts at another posture in one recovery action.
const ATTEMPTS: u64 = 16;

/// Replaces the posture at the goal.
#[derive(Debug, Default)]
pub(crate) struct GoalPostures {
    /// Attempts made so far.
    attempts: u64,
}

impl GoalPostures {
    /// Replaces the posture at the goal if motions to it have failed again and again, where one of
    /// a few attempts gives another. One work unit for each attempt.
    ///
    /// # Errors
    /// An arena is full.
    pub fn replace(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
    ) -> Result<(), ArenaFull> {
        let current = search.segments.current();
        let segment = search.segmentation.segment(current.segment, &current.sequence);
        let last = segment.edge(current.sequence.len());
        let record = search.roadmap.edges.get(last.from, last.to);
        let has_failed = record.motion.is_none() && record.failures >= ALTERNATIVE_FAILURES;
        if last.to != boundary_node(GOAL) || !has_failed {
            return Ok(());
        }
        let footholds = search
            .roadmap
            .boundary(GOAL)
            .footholds
            .map(|id| &search.roadmap.graph.footholds()[id as usize]);
        let random = (context.seed, u64::from(last.to));
        let first = self.attempts;
        let found = (first..first + ATTEMPTS).find_map(|attempt| {
            self.attempts = attempt + 1;
            sample_double(&context.constraints, footholds, random, attempt).ok()
        });
        search.stats.work += self.attempts - first;
        let Some(configuration) = found else { return Ok(()) };
        let [stance, other] = footholds;
        let world_from_soles = TransitionPair { stance, other }.world_from_soles();
        let state = ModeState { configuration, world_from_soles };
        search.stats.goal_postures += u64::from(search.roadmap.replace_goal(state)?);
        Ok(())
    }
}
