//! The controller's handling of a chunk: checks it and executes it in the actual world.

use std::cell::RefCell;

use surefoot_controller_sim::channel::ReceiverStats;
use surefoot_controller_sim::channel::plan_subscriber::{ChunkDecision, ChunkExecution};
use surefoot_controller_sim::execution::disturbance::DisturbedExecution;
use surefoot_controller_sim::missing_contact;
use surefoot_controller_sim::{ChunkExecutor, Disturbance, GroundTruth, Violation};
use surefoot_shared_types::base::limits::CORRECTIONS_MAX;
use surefoot_shared_types::instance::error::ChannelError;
use surefoot_shared_types::message::{Check, Feedback, Margins, PlanChunk, WorldCorrection};
use surefoot_shared_types::robot::model::RobotModel;

use crate::commands::control::paced_walk::PacedWalk;
use crate::report::event::{CheckSummary, Refusal};
use crate::report::margins::WorstMargins;
use crate::system::clock::Stopwatch;

/// Checks and executes chunks, and sums the checking time.
pub(crate) struct ChunkHandler {
    executor: ChunkExecutor,
    ground_truth: Option<GroundTruth>,
    disturbance: Option<Disturbance>,
    robot: PacedWalk,
    corrections: usize,
    seconds: f64,
    detail: String,
}

/// A handler that is shared with the loop that moves the robot between two chunks.
pub(crate) struct SharedHandler<'a, 'b>(pub(crate) &'a RefCell<&'b mut ChunkHandler>);

impl ChunkExecution for SharedHandler<'_, '_> {
    fn check(&mut self, chunk: &PlanChunk, heartbeat: &mut dyn FnMut()) -> ChunkDecision {
        self.0.borrow_mut().check(chunk, heartbeat)
    }

    fn execute(
        &mut self,
        chunk: &PlanChunk,
        decision: &ChunkDecision,
        heartbeat: &mut dyn FnMut(),
    ) {
        self.0.borrow_mut().execute(chunk, decision, heartbeat);
    }
}

impl ChunkHandler {
    /// A handler that has checked nothing yet.
    pub(crate) fn new(
        executor: ChunkExecutor,
        ground_truth: Option<GroundTruth>,
        disturbance: Option<Disturbance>,
        robot: PacedWalk,
    ) -> Self {
        Self {
            executor,
            ground_truth,
            disturbance,
            robot,
            corrections: 0,
            seconds: 0.0,
            detail: String::new(),
        }
    }

    /// Leaves out corrections that an earlier controller has reported.
    pub(crate) fn mark_reported(&mut self, reported: &[WorldCorrection]) {
        self.corrections = reported.len();
        if let Some(ground_truth) = &mut self.ground_truth {
            ground_truth.mark_reported(reported);
        }
    }

    /// Why the last chunk was refused.
    pub(crate) fn detail(&self) -> &str {
        &self.detail
    }

    /// The error of publishing the robot's state, if one occurred.
    pub(crate) fn error(&mut self) -> Result<(), ChannelError> {
        self.robot.error()
    }

    /// The robot.
    pub(crate) fn model(&self) -> &RobotModel {
        self.executor.checker().model()
    }

    /// The motion as executed so far; nothing if it is not recorded.
    pub(crate) fn executed(&self) -> Vec<PlanChunk> {
        self.robot.executed()
    }

    /// Checks a chunk when the robot is due to have it. Calls `heartbeat` repeatedly meanwhile.
    fn check(&mut self, chunk: &PlanChunk, heartbeat: &mut dyn FnMut()) -> ChunkDecision {
        self.robot.await_chunk(chunk, self.executor.checker_mut(), heartbeat);
        let watch = Stopwatch::start();
        let decision = match self.executor.check_chunk(chunk, heartbeat) {
            Ok(margins) => self.walk(chunk, margins, heartbeat),
            Err(violation) => self.refuse(chunk, violation),
        };
        self.seconds += watch.seconds();
        decision
    }

    /// Walks an accepted chunk until the robot needs the next one, or comes to rest.
    fn execute(
        &mut self,
        chunk: &PlanChunk,
        decision: &ChunkDecision,
        heartbeat: &mut dyn FnMut(),
    ) {
        let (robot, checker) = (&mut self.robot, self.executor.checker_mut());
        match decision {
            ChunkDecision::Accepted(..) => robot.accept(chunk, checker, heartbeat),
            ChunkDecision::AcceptedAs(_, _, walked) => robot.accept(walked, checker, heartbeat),
            ChunkDecision::Refused { .. } => robot.come_to_rest(checker, heartbeat),
        }
    }

    /// Where the robot walks in real time, walks up to now.
    pub(crate) fn catch_up(&mut self) {
        self.robot.catch_up(self.executor.checker_mut());
    }

    /// The robot brakes, where it moves, and stands.
    pub(crate) fn come_to_rest(&mut self) {
        self.robot.come_to_rest(self.executor.checker_mut(), &mut || {});
    }

    /// Summary at the end of a plan, of a controller that has published `feedback`.
    pub(crate) fn summary(
        &self,
        stats: ReceiverStats,
        feedback: &Feedback,
        refusal: Option<Refusal>,
    ) -> CheckSummary {
        let margins = WorstMargins::from(&self.executor.margins());
        CheckSummary {
            check_seconds: self.seconds,
            accepted: self.executor.next_sequence(),
            duplicated: stats.duplicates,
            damaged: stats.damaged,
            other_senders: stats.other_senders,
            late_chunks: self.robot.late_chunks(),
            brakes: feedback.brakes,
            stood_seconds: feedback.stood,
            margins,
            refusal,
        }
    }

    fn walk(
        &mut self,
        chunk: &PlanChunk,
        margins: Margins,
        heartbeat: &mut dyn FnMut(),
    ) -> ChunkDecision {
        let Some(disturbance) = &mut self.disturbance else {
            self.executor.execute(chunk, &margins);
            return ChunkDecision::Accepted(margins, self.executor.stream());
        };
        match disturbance.execute(&mut self.executor, chunk, heartbeat) {
            DisturbedExecution::Executed(actual, margins) => {
                ChunkDecision::AcceptedAs(margins, self.executor.stream(), actual)
            }
            DisturbedExecution::Infeasible(why) => self.hold(Check::FootMisplaced, 0, None, why),
            DisturbedExecution::Unsupported(contact) => {
                let correction = missing_contact(self.executor.checker().model(), &contact);
                self.hold(
                    Check::WorldDiffers,
                    0,
                    Some(correction),
                    format!("the ground does not support foot {} where it lands", contact.limb),
                )
            }
        }
    }

    /// A refusal, for its own reason or because the world differs.
    fn refuse(&mut self, chunk: &PlanChunk, violation: Violation) -> ChunkDecision {
        let correction = self
            .ground_truth
            .as_mut()
            .and_then(|ground_truth| ground_truth.encountered(&self.executor, chunk, &violation));
        let check = match violation.check {
            _ if correction.is_some() => Check::WorldDiffers,
            // A predecessor of this controller knew the feet's displacements; this one does not.
            Check::Continuity if self.disturbance.is_some() => Check::FootMisplaced,
            check => check,
        };
        self.hold(check, violation.waypoint as u32, correction, violation.detail)
    }

    /// Holds the robot at its actual pose. Adds the encountered difference to the world, as long as
    /// a feedback message has a slot for it.
    fn hold(
        &mut self,
        check: Check,
        waypoint: u32,
        correction: Option<WorldCorrection>,
        detail: String,
    ) -> ChunkDecision {
        self.detail = detail;
        self.executor.hold_position();
        let correction = correction.filter(|_| self.corrections < CORRECTIONS_MAX);
        if let Some(correction) = &correction {
            self.corrections += 1;
            self.executor.correct(correction);
        }
        ChunkDecision::Refused { check, waypoint, correction }
    }
}
