//! Planning tasks: start, goal, world, plan id and epoch of one search.

use std::num::NonZeroUsize;

use surefoot_planner::channel::plan_publisher::Delivery;
use surefoot_planner::channel::send_window::DeliveryOutcome;
use surefoot_planner::methods::method::{Method, MethodParameters};
use surefoot_planner::preparation::Preparation;
use surefoot_planner::{Planner, PlannerError};
use surefoot_shared_types::config::scenario::{Scenario, StancePose};
use surefoot_shared_types::message::{
    Check, CorrectionKind, Feedback, PlanChunk, RestState, WorldCorrection,
};
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::correction::CorrectionError;
use surefoot_shared_types::world::world::World;

use crate::input::inputs::Inputs;
use crate::report::command_error::CommandError;

/// Most executed chunks that a task keeps; they hold more than 48 steps.
const WALKED_MAX: usize = 256;
/// Most lift-offs that a plan retraces.
const RETRACE_LIFT_OFFS_MAX: usize = 16;
/// Work limit of a search that may be followed by one that retraces further, units per chunk of the
/// preceding plan. It is several times the work that the preceding plan took.
const WORK_PER_CHUNK: u64 = 300;
/// Smallest such work limit, units.
const WORK_MIN: u64 = 20_000;

/// A planning task.
#[derive(Debug, Clone)]
pub(crate) struct PlanningTask {
    /// The scenario with this task's start, goal and seed. Its digest stays that of the file, which
    /// planner and controller have in common.
    pub(crate) scenario: Scenario,
    /// The world as the planner knows it.
    pub(crate) world: World,
    /// Differences from the world file that the controller has encountered.
    pub(crate) corrections: Vec<WorldCorrection>,
    /// The robot's rest state; `None` before the first plan is executed.
    pub(crate) rest_state: Option<RestState>,
    /// Number of chunks of the preceding plan.
    chunks: u64,
    /// The chunks that the robot executed last; the final one ends at the rest state.
    walked: Vec<PlanChunk>,
    /// Number of lift-offs that the plan retraces first.
    retrace_depth: usize,
    /// The plan's id.
    pub(crate) plan_id: u64,
    /// Number of times that the plan was replanned.
    pub(crate) epoch: u64,
    /// The method that searches, with its parameters.
    pub(crate) method: (Method, MethodParameters),
    /// Work units that improve each plan.
    pub(crate) improve: u64,
    /// Whether chunks are sent while the plan is made.
    pub(crate) in_parts: bool,
}

impl PlanningTask {
    /// The task of the scenario itself.
    pub(crate) fn first(inputs: &Inputs) -> Self {
        Self {
            scenario: inputs.scenario.clone(),
            world: inputs.world.clone(),
            corrections: vec![],
            rest_state: None,
            chunks: 0,
            walked: vec![],
            retrace_depth: 0,
            plan_id: 1,
            epoch: 0,
            method: (Method::Rpg, MethodParameters::default()),
            improve: 0,
            in_parts: false,
        }
    }

    /// Whether this task may find a plan by retracing further than its `planner` did.
    pub(crate) fn may_retrace_further(&self, planner: &Planner) -> bool {
        let gone = planner.retrace().depth;
        let is_farthest =
            gone < self.retrace_depth || gone >= RETRACE_LIFT_OFFS_MAX || self.walked.is_empty();
        self.rest_state.is_some() && !is_farthest
    }

    /// Retraces further than a `planner` of this task did.
    pub(crate) fn retrace_further(&mut self, planner: &Planner) {
        self.retrace_depth = (2 * planner.retrace().depth).max(1);
    }

    /// The rest of the plan from the rest state in the controller's `feedback`, in the world that
    /// it describes, under a new epoch. `chunks` are this task's; the first `back` of them retrace
    /// executed chunks.
    ///
    /// # Errors
    /// The feedback's corrections concern another world, or its epoch is the last one possible.
    pub(crate) fn after(
        self,
        inputs: &Inputs,
        feedback: &Feedback,
        chunks: &[PlanChunk],
        back: usize,
    ) -> Result<Self, CommandError> {
        let is_own = (feedback.plan_id, feedback.epoch) == (self.plan_id, self.epoch);
        let epoch = next_id(
            if feedback.plan_id == self.plan_id {
                feedback.epoch.max(self.epoch)
            } else {
                feedback.epoch
            },
            feedback,
        )?;
        let accepted = usize::try_from(feedback.next_sequence)
            .map_or(chunks, |count| &chunks[..count.min(chunks.len())]);
        let walked = if is_own { walked_after(self.walked, accepted, back) } else { vec![] };
        let (plan_id, chunks) = (feedback.plan_id, chunks.len() as u64);
        let method = (Method::Rpg, MethodParameters::default());
        Ok(Self { plan_id, epoch, chunks, walked, retrace_depth: 0, method, ..self }
            .at_rest_state(inputs, feedback)?)
    }

    /// A new plan from the rest state in the controller's `feedback`, or from the scenario's start
    /// where there is none yet.
    ///
    /// # Errors
    /// The feedback's corrections concern another world, or its plan is the last one possible.
    pub(crate) fn fresh(
        inputs: &Inputs,
        feedback: Option<&Feedback>,
    ) -> Result<Self, CommandError> {
        let first = Self::first(inputs);
        match feedback {
            Some(feedback) => Ok(Self { plan_id: next_id(feedback.plan_id, feedback)?, ..first }
                .at_rest_state(inputs, feedback)?),
            None => Ok(first),
        }
    }

    /// The same task towards another goal, with another seed and at most this much work.
    pub(crate) fn towards(mut self, goal: StancePose, seed: u64, work_max: u64) -> Self {
        self.scenario.goal = goal;
        self.scenario.seed = seed;
        if work_max > 0 {
            self.scenario.planner.work_max = work_max.min(self.scenario.planner.work_max);
        }
        self
    }

    /// The same task from a stance, wherever the robot stands.
    pub(crate) fn starting_at(mut self, start: StancePose) -> Self {
        self.scenario.start = start;
        self.rest_state = None;
        self
    }

    /// A planner that is ready for this task. If the rest state violates the constraints, its plan
    /// retraces first.
    ///
    /// # Errors
    /// The planner cannot use the robot or the world.
    pub(crate) fn planner(
        &self,
        model: &RobotModel,
        preparation: Preparation,
        threads: NonZeroUsize,
    ) -> Result<Planner, PlannerError> {
        let mut builder = Planner::builder(model, &self.world, &self.scenario, preparation)
            .threads(threads)
            .method(self.method.0, self.method.1)
            .improve(self.improve)
            .plan_name(self.plan_id, self.epoch);
        if self.in_parts {
            builder = builder.in_parts();
        }
        if let Some(rest_state) = &self.rest_state {
            builder = builder.start_in(rest_state).retrace(&self.walked, self.retrace_depth);
        }
        for missing in self
            .corrections
            .iter()
            .filter(|correction| correction.known_kind() == Some(CorrectionKind::ContactMissing))
        {
            let [half_length, half_width, _] = missing.half_extents;
            builder = builder.keep_out(missing.pose(), [half_length, half_width]);
        }
        let mut planner = builder.build()?;
        if self.may_retrace_further(&planner) {
            planner.limit_work(WORK_MIN.max(WORK_PER_CHUNK * self.chunks));
        }
        Ok(planner)
    }

    /// This task with its history of executed chunks, which stays behind without it.
    pub(crate) fn take(&mut self) -> Self {
        let walked = std::mem::take(&mut self.walked);
        Self { walked, ..self.clone() }
    }

    fn at_rest_state(
        mut self,
        inputs: &Inputs,
        feedback: &Feedback,
    ) -> Result<Self, CorrectionError> {
        self.world = inputs.world.corrected(feedback.corrections())?;
        self.corrections = feedback.corrections().to_vec();
        self.rest_state = feedback.rest_state.is_known().then_some(feedback.rest_state);
        Ok(self)
    }
}

/// The executed chunks after the `accepted` ones, of which the first `back` retrace.
fn walked_after(mut walked: Vec<PlanChunk>, accepted: &[PlanChunk], back: usize) -> Vec<PlanChunk> {
    let (retraced, onward) = accepted.split_at(back.min(accepted.len()));
    walked.truncate(walked.len().saturating_sub(retraced.len()));
    walked.extend_from_slice(onward);
    walked.drain(..walked.len().saturating_sub(WALKED_MAX));
    walked
}

/// Whether a new plan from the robot's rest state can help: the world differs, the feet stand
/// elsewhere than planned, the plan ends on the way, another planner has replanned, or the robot
/// has executed more chunks of the preceding plan. `was_executing` says whether there was one.
pub(crate) fn may_replan(delivery: &Delivery, was_executing: bool) -> bool {
    let differs =
        matches!(delivery.outcome, DeliveryOutcome::Refused { check: Check::WorldDiffers, .. });
    let feedback = delivery.feedback.as_ref();
    let corrected = differs && feedback.is_some_and(|feedback| feedback.corrections_len > 0);
    let misplaced =
        matches!(delivery.outcome, DeliveryOutcome::Refused { check: Check::FootMisplaced, .. });
    let stands = feedback.is_some_and(|feedback| feedback.rest_state.is_known());
    let is_out_of_date = matches!(
        delivery.outcome,
        DeliveryOutcome::Refused { check: Check::Continuity | Check::World, sequence: 0, .. }
    );
    corrected
        || stands
            && (misplaced
                || was_executing && is_out_of_date
                || matches!(
                    delivery.outcome,
                    DeliveryOutcome::Incomplete | DeliveryOutcome::Superseded
                ))
}

/// The id after `number`, which the `feedback` holds.
fn next_id(number: u64, feedback: &Feedback) -> Result<u64, CommandError> {
    number
        .checked_add(1)
        .ok_or(CommandError::IdsExhausted { plan_id: feedback.plan_id, epoch: feedback.epoch })
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;
    use crate::input::inputs::Overrides;

    #[test]
    fn retraced_chunks_are_removed_with_the_chunks_that_they_retrace() {
        let chunk = |sequence| PlanChunk { sequence, ..PlanChunk::zeroed() };
        let sequences =
            |walked: Vec<PlanChunk>| walked.iter().map(|chunk| chunk.sequence).collect::<Vec<_>>();
        let walked = [1, 2, 3].map(chunk).to_vec();
        assert_eq!(
            sequences(walked_after(walked.clone(), &[10, 11].map(chunk), 0)),
            [1, 2, 3, 10, 11]
        );
        assert_eq!(sequences(walked_after(walked.clone(), &[10, 11, 12].map(chunk), 2)), [1, 12]);
        assert_eq!(
            sequences(walked_after(walked.clone(), &[10].map(chunk), 2)),
            [1, 2],
            "it was stopped while it retraced"
        );
        let many: Vec<PlanChunk> = (0..WALKED_MAX as u64).map(chunk).collect();
        assert_eq!(walked_after(walked, &many, 0), many, "the oldest are removed first");
    }

    #[test]
    fn a_robot_that_executed_more_of_the_preceding_plan_is_replanned() {
        let rest_state = RestState { contacts_len: 2, ..RestState::zeroed() };
        let refused = |check, sequence, rest_state| Delivery {
            outcome: DeliveryOutcome::Refused { sequence, check, waypoint: 0 },
            sent: 8,
            resent: 0,
            accepted: 0,
            first_sent: None,
            other_senders: 0,
            feedback: Some(Feedback { rest_state, ..Feedback::zeroed() }),
        };
        for check in [Check::Continuity, Check::World] {
            assert!(may_replan(&refused(check, 0, rest_state), true));
            assert!(
                !may_replan(&refused(check, 0, rest_state), false),
                "the scenario's start is the start that was asked for"
            );
            assert!(
                !may_replan(&refused(check, 3, rest_state), true),
                "a chunk does not continue the one before it"
            );
            assert!(!may_replan(&refused(check, 0, RestState::zeroed()), true));
        }
        assert!(!may_replan(&refused(Check::Torque, 0, rest_state), true));
    }

    #[test]
    fn no_plan_follows_the_last_id() {
        let inputs =
            Inputs::load("configs/scenarios/flat_walk.toml".as_ref(), Overrides::default())
                .unwrap();
        let feedback = |plan_id, epoch| Feedback { plan_id, epoch, ..Feedback::zeroed() };
        let first = PlanningTask::first(&inputs);
        let name = |task: Result<PlanningTask, CommandError>| {
            task.map(|task| (task.plan_id, task.epoch)).map_err(|failure| failure.to_string())
        };
        assert_eq!(name(PlanningTask::fresh(&inputs, Some(&feedback(4, u64::MAX)))), Ok((5, 0)));
        assert_eq!(
            name(first.clone().after(&inputs, &feedback(u64::MAX, 4), &[], 0)),
            Ok((u64::MAX, 5))
        );
        let last = |feedback: Feedback| {
            Err(CommandError::IdsExhausted { plan_id: feedback.plan_id, epoch: feedback.epoch }
                .to_string())
        };
        assert_eq!(
            name(PlanningTask::fresh(&inputs, Some(&feedback(u64::MAX, 0)))),
            last(feedback(u64::MAX, 0))
        );
        assert_eq!(
            name(first.after(&inputs, &feedback(4, u64::MAX), &[], 0)),
            last(feedback(4, u64::MAX))
        );
    }
}
