//! `surefoot plan`: plans, and delivers the plan if an instance is named: its first chunks while
//! the rest of it is made. Also the planner process of a walk.
//!
//! If the controller encounters a world that differs from the planner's, the rest of the plan is
//! planned again from the robot's rest state in the corrected world.

pub mod planning_task;

mod described_publisher;
mod growing_plan;
mod request_queue;
mod serve;
mod totals;

use std::cell::{Cell, RefCell};
use std::num::NonZeroUsize;
use std::path::{Path, PathBuf};

use surefoot_planner::Planner;
use surefoot_planner::channel::plan_publisher::{Delivery, PlanPublisher};
use surefoot_planner::channel::send_window::DeliveryOutcome;
use surefoot_planner::preparation::Preparation;
use surefoot_shared_types::instance::sender::random_id;
use surefoot_shared_types::message::PlanChunk;
use surefoot_shared_types::plan_file::write::{plan_from_chunks, text_of};
use surefoot_shared_types::plan_format::blocks::PlanFile;

use crate::cli::arguments::PlanArguments;
use crate::commands::session::{FinishArguments, finish, prepare_process};
use crate::input::inputs::{Inputs, Overrides};
use crate::input::output_files;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::report::event::{Delivered, PlanResult, Planned, RoleEvent};
use crate::report::liveness;
use crate::report::reporter::Reporter;
use crate::report::run_report::Report;
use crate::system::clock::Stopwatch;
use crate::system::{memory, signals, terminal};

use crate::commands::plan::growing_plan::{Callbacks, GrowingPlan, OpenSearch};
use crate::commands::plan::planning_task::{PlanningTask, may_replan};
use crate::commands::plan::totals::Totals;

/// Runs the command.
///
/// # Errors
/// An input cannot be used, an output cannot be written, the transport fails, or a signal comes.
pub fn run(arguments: &PlanArguments) -> Result<CommandOutcome, CommandError> {
    prepare_process(&arguments.role);
    if arguments.search.lock_memory {
        lock_memory();
    }
    let inputs = Inputs::load(&arguments.search.scenario, Overrides::of(&arguments.search))?;
    output_files::check_run(&arguments.outputs, &inputs)?;
    let preparation = inputs.preparation(arguments.outputs.quiet || arguments.role.report_lines)?;
    let report = Report::new(inputs.names(), arguments.search.threads());
    let reporter = Reporter::new(arguments.role.report_lines, arguments.outputs.quiet);
    if arguments.serve && arguments.outputs.names_files() {
        return Err(CommandError::Usage(
            "--serve writes no files; leave out --export, --picture, --record and --json".into(),
        ));
    }
    if arguments.instance.is_some() {
        CommandError::unless_limited()?;
    }
    let deferral = signals::defer();
    if arguments.serve {
        return match serve::run(arguments, &inputs, preparation, reporter) {
            Err(CommandError::Interrupted(_)) => Ok(CommandOutcome::Done),
            ended => ended,
        };
    }
    let mut run = Run { arguments, inputs, preparation, report, reporter };
    let ended = run.plan_and_deliver();
    drop(deferral);
    let (result, drawable) = match ended {
        Ok(drawable) => (Ok(()), drawable),
        Err(error) => (Err(error), None),
    };
    let mut report = std::mem::take(&mut run.report);
    let end = FinishArguments { outputs: &arguments.outputs, is_role: arguments.role.report_lines };
    finish(&mut report, end, result, || match &drawable {
        Some((task, planner)) if !end.is_role => run.draw(task, planner),
        _ => Ok(()),
    })
}

/// Locks this process's memory, including the arenas that are reserved later.
fn lock_memory() {
    if let Err(reason) = memory::lock() {
        terminal::print_note(&format!(
            "warning: memory is not locked: {reason}; `ulimit -l` shows the limit"
        ));
    }
}

/// One run of the command.
struct Run<'a> {
    arguments: &'a PlanArguments,
    inputs: Inputs,
    preparation: Preparation,
    report: Report,
    reporter: Reporter,
}

/// A task and the planner that ended it.
type Ended = (PlanningTask, Planner);

impl Run<'_> {
    /// Plans and delivers; returns the last search.
    fn plan_and_deliver(&mut self) -> Result<Option<Ended>, CommandError> {
        let mut publisher = match &self.arguments.instance {
            Some(name) => Some(described_publisher::open(name, random_id(), &self.inputs)?),
            None => None,
        };
        let mut task = PlanningTask::first(&self.inputs);
        task.method = (self.arguments.method, self.arguments.samples.parameters());
        task.improve = self.arguments.search.improve;
        task.in_parts = publisher.is_some();
        let mut totals = Totals::default();
        loop {
            let mut open = self.search(&mut task)?;
            if open.is_without_chunks() {
                self.report_failure(&task, open.planned.take(), &open.planner)?;
                return Ok(Some((task, open.planner)));
            }
            let Some(publisher) = publisher.as_mut().filter(|_| !open.is_stopped()) else {
                self.finish(&task, &mut open)?;
                return Ok(Some((task, open.planner)));
            };
            let (delivery, first_chunk_seconds) = self.deliver(publisher, &task, &mut open)?;
            totals.add(&delivery);
            let feedback = delivery.feedback.filter(|_| {
                totals.replans < self.arguments.search.replans_max
                    && may_replan(&delivery, task.rest_state.is_some())
            });
            let Some(feedback) = feedback else {
                let delivered = Delivered { first_chunk_seconds, ..totals.delivered(&delivery) };
                self.emit(&RoleEvent::Delivered(delivered))?;
                self.report_failure(&task, open.planned.take(), &open.planner)?;
                return Ok(Some((task, open.planner)));
            };
            totals.withdraw(&delivery);
            let OpenSearch { planner, .. } = open;
            let retraced = planner.retrace().chunks;
            task = task.after(&self.inputs, &feedback, planner.final_chunks(), retraced)?;
            self.emit(&RoleEvent::Replanning {
                epoch: task.epoch,
                corrections: feedback.corrections().len() as u64,
            })?;
        }
    }

    /// Searches until the first chunk is final, or to the end. If no plan is found, searches again
    /// from a state that the robot retraces to.
    fn search(&mut self, task: &mut PlanningTask) -> Result<OpenSearch, CommandError> {
        let threads =
            NonZeroUsize::new(self.arguments.search.threads()).unwrap_or(NonZeroUsize::MIN);
        loop {
            let watch = Stopwatch::start();
            let planner = task.planner(&self.inputs.model, self.preparation.clone(), threads)?;
            let arena_bytes = planner.arena_bytes().iter().map(|(_, bytes)| *bytes as u64).sum();
            self.emit(&RoleEvent::PlannerReady { ready_seconds: watch.seconds(), arena_bytes })?;
            let mut open = OpenSearch::begin(planner, task.scenario.planner.work_max);
            if !open.make_first_chunk(&mut |event| self.emit(event), &mut || false)? {
                self.emit(&RoleEvent::Planned(open.search.interrupted(&open.planner)))?;
                return Err(CommandError::interrupted());
            }
            if !open.is_without_chunks() || !task.may_retrace_further(&open.planner) {
                return Ok(open);
            }
            self.emit(&RoleEvent::Retracing)?;
            task.retrace_further(&open.planner);
        }
    }

    /// Reports how a search ended without a plan, if it did.
    fn report_failure(
        &mut self,
        task: &PlanningTask,
        planned: Option<Planned>,
        planner: &Planner,
    ) -> Result<(), CommandError> {
        let Some(mut planned) = planned.filter(|planned| planned.result != PlanResult::Found)
        else {
            return Ok(());
        };
        if task.epoch > 0
            && matches!(planned.result, PlanResult::StartInvalid | PlanResult::GoalInvalid)
        {
            // The scenario's stances were valid for the first plan, so this is a failed search.
            planned.result = PlanResult::NoPlan;
        }
        if self.arguments.role.report_lines {
            // The supervisor ends this process when it knows that there is no plan.
            self.draw(task, planner)?;
        }
        self.emit(&RoleEvent::Planned(planned))
    }

    /// Ends the search of a plan that is not delivered. A signal that only stopped its improvement
    /// ends the process where the plan was to be delivered.
    fn finish(&mut self, task: &PlanningTask, open: &mut OpenSearch) -> Result<(), CommandError> {
        if open.is_stopped() && self.arguments.instance.is_none() {
            signals::take();
        }
        let run = RefCell::new(&mut *self);
        open.finish(&mut Callbacks {
            emit: &mut |event| run.borrow_mut().emit(event),
            on_found: &mut |planner, planned| run.borrow_mut().record_found(task, planner, planned),
        })?;
        self.report_failure(task, open.planned.take(), &open.planner)
    }

    /// Reports a complete plan and writes its files.
    fn record_found(
        &mut self,
        task: &PlanningTask,
        planner: &Planner,
        planned: &Planned,
    ) -> Result<(), CommandError> {
        self.emit(&RoleEvent::Planned(planned.clone()))?;
        self.export(task, planner.chunks())
    }

    /// Delivers the chunks while they are made. Returns the delivery, and the time from the
    /// beginning of the search until the first chunk was sent (s).
    fn deliver(
        &mut self,
        publisher: &mut PlanPublisher,
        task: &PlanningTask,
        open: &mut OpenSearch,
    ) -> Result<(Delivery, Option<f64>), CommandError> {
        let begun = open.search.seconds();
        let (mut accepted, total) = (0, Cell::new(0));
        let run = RefCell::new(&mut *self);
        let mut emit = |event: &RoleEvent| run.borrow_mut().emit(event);
        let mut on_found = |planner: &Planner, planned: &Planned| {
            total.set(planned.chunks);
            run.borrow_mut().record_found(task, planner, planned)
        };
        let callbacks = Callbacks { emit: &mut emit, on_found: &mut on_found };
        let mut plan = GrowingPlan::new(open, callbacks)?;
        let delivery = publisher.deliver_from(
            &mut plan,
            &mut |feedback| {
                let is_of_plan = (feedback.plan_id, feedback.epoch) == (task.plan_id, task.epoch);
                if is_of_plan && feedback.next_sequence != accepted {
                    accepted = feedback.next_sequence;
                    let chunks = total.get().max(accepted);
                    // The final event repeats the number, so a lost one does no harm.
                    let _ = run.borrow_mut().emit(&RoleEvent::Delivering { accepted, chunks });
                }
            },
            &liveness::keep_going,
        )?;
        plan.finish(delivery.outcome == DeliveryOutcome::Stopped)?;
        let first_sent = delivery.first_sent.map(|sent| begun + sent.as_secs_f64());
        Ok((delivery, first_sent))
    }

    fn export(&self, task: &PlanningTask, chunks: &[PlanChunk]) -> Result<(), CommandError> {
        let export = self.arguments.outputs.export.as_deref();
        if let Some(number) = self.arguments.role.plan_descriptor {
            let place = export.unwrap_or(Path::new("-"));
            let text = text_of(&self.plan_file(task, chunks, place), place)?;
            let path = PathBuf::from(format!("/proc/self/fd/{number}"));
            return std::fs::write(&path, text)
                .map_err(|error| CommandError::Output { path, reason: error.to_string() });
        }
        match export {
            Some(path) => {
                output_files::write(&text_of(&self.plan_file(task, chunks, path), path)?, path)
            }
            None => Ok(()),
        }
    }

    /// Draws and records the plan, or draws the search that found none. The supervisor draws and
    /// records the plan of a walk.
    fn draw(&self, task: &PlanningTask, planner: &Planner) -> Result<(), CommandError> {
        let outputs = &self.arguments.outputs;
        if planner.chunks().is_empty() {
            let draw = |path: &PathBuf| {
                output_files::draw_search(&self.inputs, &task.scenario, &planner.trace(), path)
            };
            return outputs.picture.as_ref().map_or(Ok(()), draw);
        }
        if self.arguments.role.report_lines || !outputs.shows_plan() {
            return Ok(());
        }
        let place = Path::new("-");
        let plan = self.plan_file(task, planner.chunks(), place);
        output_files::show_plan(&self.inputs, &plan, &output_files::plan_folder(place), outputs)
    }

    /// The plan as a file in the folder of `path`.
    fn plan_file(&self, task: &PlanningTask, chunks: &[PlanChunk], path: &Path) -> PlanFile {
        plan_from_chunks(
            &self.inputs.model,
            &task.world,
            &task.scenario,
            chunks,
            &output_files::plan_folder(path),
        )
    }

    fn emit(&mut self, event: &RoleEvent) -> Result<(), CommandError> {
        self.report.record(event);
        self.reporter.emit(event)
    }
}
