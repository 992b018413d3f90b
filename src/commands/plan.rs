//! `surefoot plan`: plans, and delivers the plan where an instance is named. Also the planner
//! process of a walk.
//!
//! Where the controller encounters another world than the plan was made for, the rest of the way is
//! planned again from where the robot stands, in the world as it turned out to be.

pub mod planning_task;

mod serve;

use std::num::NonZeroUsize;

use surefoot_planner::Planner;
use surefoot_planner::channel::plan_publisher::{Delivery, PlanPublisher};
use surefoot_planner::channel::send_window::DeliveryOutcome;
use surefoot_planner::preparation::build::Preparation;
use surefoot_shared_types::instance::random_id;
use surefoot_shared_types::message::{Check, PlanChunk};
use surefoot_shared_types::plan_file::write::{plan_from_chunks, save};
use surefoot_shared_types::plan_format::blocks::PlanFile;

use crate::cli::arguments::PlanArguments;
use crate::commands::search_loop;
use crate::commands::session::{enter_instance, prepare_process, write_report};
use crate::input::inputs::Inputs;
use crate::input::output_files;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::report::event::{Delivered, PlanResult, RoleEvent};
use crate::report::reporter::Reporter;
use crate::report::run_report::Report;
use crate::report::summary;
use crate::system::clock::Stopwatch;
use crate::system::{memory, signals, terminal};

use crate::commands::plan::planning_task::PlanningTask;

/// Runs the command.
///
/// # Errors
/// When an input cannot be used, an output cannot be written, the transport fails, or a signal
/// comes.
pub fn run(arguments: &PlanArguments) -> Result<CommandOutcome, CommandError> {
    prepare_process(&arguments.role);
    if arguments.search.lock_memory {
        lock_memory();
    }
    let inputs = Inputs::load(&arguments.search.scenario, arguments.search.seed)?;
    output_files::check(&arguments.outputs)?;
    let preparation = inputs.preparation(arguments.outputs.quiet || arguments.role.report_lines)?;
    let report = Report::new(&inputs, arguments.search.threads());
    let reporter = Reporter::new(arguments.role.report_lines, arguments.outputs.quiet);
    if arguments.serve {
        return serve::run(arguments, &inputs, preparation, reporter);
    }
    let mut run = Run { arguments, inputs, preparation, report, reporter };
    run.plan_and_deliver()?;
    let outcome = write_report(&run.report, arguments.outputs.json.as_deref())?;
    run.reporter.print(|| summary::text(&run.report));
    Ok(outcome)
}

/// Before anything large is reserved: what comes later is locked as it is reserved.
fn lock_memory() {
    if let Err(reason) = memory::lock() {
        terminal::print_note(&format!(
            "warning: memory is not locked: {reason}; `ulimit -l` says how much may be"
        ));
    }
}

struct Run<'a> {
    arguments: &'a PlanArguments,
    inputs: Inputs,
    preparation: Preparation<'static>,
    report: Report,
    reporter: Reporter,
}

impl Run<'_> {
    fn plan_and_deliver(&mut self) -> Result<(), CommandError> {
        let mut sender = match &self.arguments.instance {
            Some(name) => Some(PlanPublisher::open(&enter_instance(name)?, random_id())?),
            None => None,
        };
        let mut task = PlanningTask::first(&self.inputs);
        let mut totals = Totals::default();
        loop {
            let Some(planner) = self.plan(&mut task)? else { return Ok(()) };
            self.export(&task, planner.chunks())?;
            let Some(sender) = &mut sender else { return self.draw(&task, planner.chunks()) };
            let delivery = self.deliver(sender, planner.chunks())?;
            totals.add(&delivery);
            let feedback = delivery.feedback.filter(|_| {
                totals.replans < self.arguments.search.replans_max
                    && may_replan(&delivery, task.rest_state.is_some())
            });
            let Some(feedback) = feedback else {
                self.emit(&RoleEvent::Delivered(totals.delivered(&delivery)))?;
                return self.draw(&task, planner.chunks());
            };
            totals.withdraw(&delivery);
            task =
                task.after(&self.inputs, &feedback, planner.chunks(), planner.retrace().chunks)?;
            self.emit(&RoleEvent::Replanning {
                epoch: task.epoch,
                corrections: feedback.corrections().len() as u64,
            })?;
        }
    }

    /// Searches, from farther back where nothing leads on; a planner with a plan, if there is one.
    fn plan(&mut self, task: &mut PlanningTask) -> Result<Option<Planner>, CommandError> {
        let threads =
            NonZeroUsize::new(self.arguments.search.threads()).unwrap_or(NonZeroUsize::MIN);
        loop {
            let watch = Stopwatch::start();
            let mut planner = task.planner(&self.inputs.model, self.preparation, threads)?;
            let arena_bytes = planner.arena_bytes().iter().map(|(_, bytes)| *bytes as u64).sum();
            self.emit(&RoleEvent::PlannerReady { ready_seconds: watch.seconds(), arena_bytes })?;
            let mut planned =
                search_loop::run(&mut planner, task.scenario.planner.work_max, &mut |event| {
                    self.emit(event)
                })?;
            let found = planned.result == PlanResult::Found;
            if !found && task.may_retrace_further(&planner) {
                self.emit(&RoleEvent::Retracing)?;
                task.retrace_further(&planner);
                continue;
            }
            if task.epoch > 0
                && matches!(planned.result, PlanResult::StartInvalid | PlanResult::GoalInvalid)
            {
                // The scenario's stances were valid for the first plan: no plan leads on from here.
                planned.result = PlanResult::NoPlan;
            }
            self.emit(&RoleEvent::Planned(planned))?;
            return Ok(found.then_some(planner));
        }
    }

    fn deliver(
        &mut self,
        sender: &mut PlanPublisher,
        chunks: &[PlanChunk],
    ) -> Result<Delivery, CommandError> {
        let mut accepted = 0;
        let total = chunks.len() as u64;
        let delivery = sender.deliver(
            chunks,
            &mut |feedback| {
                if feedback.next_sequence != accepted {
                    accepted = feedback.next_sequence;
                    // A supervisor that misses this misses the final event too, which counts.
                    let _ = self.emit(&RoleEvent::Delivering { accepted, chunks: total });
                }
            },
            &|| signals::raised().is_none(),
        )?;
        Ok(delivery)
    }

    fn export(&self, task: &PlanningTask, chunks: &[PlanChunk]) -> Result<(), CommandError> {
        match &self.arguments.outputs.export {
            Some(path) => Ok(save(&self.plan_file(task, chunks, path), path)?),
            None => Ok(()),
        }
    }

    fn draw(&self, task: &PlanningTask, chunks: &[PlanChunk]) -> Result<(), CommandError> {
        match &self.arguments.outputs.picture {
            Some(path) => {
                output_files::draw(&self.inputs, &self.plan_file(task, chunks, path), path)
            }
            None => Ok(()),
        }
    }

    /// The plan as a file that stands beside `path`.
    fn plan_file(
        &self,
        task: &PlanningTask,
        chunks: &[PlanChunk],
        path: &std::path::Path,
    ) -> PlanFile {
        plan_from_chunks(
            &self.inputs.model,
            &task.world,
            &task.scenario,
            chunks,
            &output_files::folder_of(path),
        )
    }

    fn emit(&mut self, event: &RoleEvent) -> Result<(), CommandError> {
        self.report.record(event);
        self.reporter.emit(event)
    }
}

/// Whether planning again from where the robot stands may help: the world turned out to be another,
/// the feet stand elsewhere than planned, another planner has planned again meanwhile, or the
/// robot, which `was_executing`, has walked on along the plan before.
fn may_replan(delivery: &Delivery, was_executing: bool) -> bool {
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
                || delivery.outcome == DeliveryOutcome::Superseded)
}

/// What became of the chunks of all epochs together.
#[derive(Debug, Default)]
struct Totals {
    sent: u64,
    resent: u64,
    accepted: u64,
    withdrawn: u64,
    replans: u32,
}

impl Totals {
    fn add(&mut self, delivery: &Delivery) {
        self.sent += delivery.sent;
        self.resent += delivery.resent;
        self.accepted += delivery.accepted;
    }

    /// Counts a plan that is replaced by another one.
    fn withdraw(&mut self, delivery: &Delivery) {
        self.withdrawn += delivery.sent.saturating_sub(delivery.resent + delivery.accepted);
        self.replans += 1;
    }

    fn delivered(&self, last: &Delivery) -> Delivered {
        let Self { sent, resent, accepted, withdrawn, .. } = *self;
        Delivered { sent, resent, accepted, withdrawn, ..Delivered::from(last) }
    }
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;
    use surefoot_shared_types::message::{Feedback, RestState};

    use super::*;

    #[test]
    fn a_plan_is_made_again_for_a_robot_that_walked_on_along_the_one_before() {
        let rest_state = RestState { contacts_len: 2, ..RestState::zeroed() };
        let refused = |check, sequence, rest_state| Delivery {
            outcome: DeliveryOutcome::Refused { sequence, check, waypoint: 0 },
            sent: 8,
            resent: 0,
            accepted: 0,
            feedback: Some(Feedback { rest_state, ..Feedback::zeroed() }),
        };
        for check in [Check::Continuity, Check::World] {
            assert!(may_replan(&refused(check, 0, rest_state), true));
            assert!(
                !may_replan(&refused(check, 0, rest_state), false),
                "the scenario's mark is where it was asked to begin"
            );
            assert!(
                !may_replan(&refused(check, 3, rest_state), true),
                "a chunk does not continue the one before it"
            );
            assert!(!may_replan(&refused(check, 0, RestState::zeroed()), true));
        }
        assert!(!may_replan(&refused(Check::Torque, 0, rest_state), true));
    }
}
