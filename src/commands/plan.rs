//! `surefoot plan`: plans, and delivers the plan where an instance is named. Also the planner
//! process of a walk.
//!
//! Where the controller meets another world than the plan was made for, the rest of the way is
//! planned again from where the robot stands, in the world as it turned out to be.

mod serve;
pub(super) mod task;

use std::num::NonZeroUsize;

use surefoot_planner::Planner;
use surefoot_planner::channel::{ChunkSender, Delivery, Outcome};
use surefoot_planner::prepare::Preparation;
use surefoot_shared_types::instance::draw_id;
use surefoot_shared_types::message::{Check, PlanChunk};
use surefoot_shared_types::plan_file::PlanFile;
use surefoot_shared_types::plan_file::write::{plan_from_chunks, save};

use super::{conclude, enter, settle};
use crate::arguments::PlanArguments;
use crate::audience::Audience;
use crate::clock::Stopwatch;
use crate::failure::{Ending, Failure};
use crate::inputs::Inputs;
use crate::line::{Delivered, Line, PlanEnd};
use crate::report::Report;
use crate::{memory, outputs, search, signals, terminal, verdict};

use task::Task;

/// Runs the command.
///
/// # Errors
/// When an input cannot be used, an output cannot be written, the transport fails, or a signal
/// comes.
pub fn run(arguments: &PlanArguments) -> Result<Ending, Failure> {
    settle(&arguments.role);
    if arguments.search.lock_memory {
        lock_memory();
    }
    let inputs = Inputs::load(&arguments.search.scenario, arguments.search.seed)?;
    outputs::check(&arguments.outputs)?;
    let preparation = inputs.preparation(arguments.outputs.quiet || arguments.role.report_lines)?;
    let report = Report::new(&inputs, arguments.search.threads());
    let audience = Audience::new(arguments.role.report_lines, arguments.outputs.quiet);
    if arguments.serve {
        return serve::run(arguments, &inputs, preparation, audience);
    }
    let mut run = Run { arguments, inputs, preparation, report, audience };
    run.plan_and_deliver()?;
    let ending = conclude(&run.report, arguments.outputs.json.as_deref())?;
    run.audience.say(|| verdict::text(&run.report));
    Ok(ending)
}

/// Before anything large is reserved: what comes later is locked as it is reserved.
fn lock_memory() {
    if let Err(reason) = memory::lock() {
        terminal::remark(&format!(
            "warning: memory is not locked: {reason}; `ulimit -l` says how much may be"
        ));
    }
}

struct Run<'a> {
    arguments: &'a PlanArguments,
    inputs: Inputs,
    preparation: Preparation<'static>,
    report: Report,
    audience: Audience,
}

impl Run<'_> {
    fn plan_and_deliver(&mut self) -> Result<(), Failure> {
        let mut sender = match &self.arguments.instance {
            Some(name) => Some(ChunkSender::open(&enter(name)?, draw_id())?),
            None => None,
        };
        let mut task = Task::first(&self.inputs);
        let mut totals = Totals::default();
        loop {
            let Some(planner) = self.plan(&mut task)? else { return Ok(()) };
            self.export(&task, planner.chunks())?;
            let Some(sender) = &mut sender else { return self.draw(&task, planner.chunks()) };
            let delivery = self.deliver(sender, planner.chunks())?;
            totals.add(&delivery);
            let word = delivery.feedback.filter(|_| {
                totals.replans < self.arguments.search.replans_max
                    && may_go_on(&delivery, task.standing.is_some())
            });
            let Some(word) = word else {
                self.tell(&Line::Delivered(totals.delivered(&delivery)))?;
                return self.draw(&task, planner.chunks());
            };
            totals.give_up(&delivery);
            task = task.after(&self.inputs, &word, planner.chunks(), planner.way_back().chunks)?;
            self.tell(&Line::Replanning {
                epoch: task.epoch,
                corrections: word.corrections().len() as u64,
            })?;
        }
    }

    /// Searches, from farther back where nothing leads on; a planner with a plan, if there is one.
    fn plan(&mut self, task: &mut Task) -> Result<Option<Planner>, Failure> {
        let threads =
            NonZeroUsize::new(self.arguments.search.threads()).unwrap_or(NonZeroUsize::MIN);
        loop {
            let watch = Stopwatch::start();
            let mut planner = task.planner(&self.inputs.model, self.preparation, threads)?;
            let arena_bytes = planner.arena_bytes().iter().map(|(_, bytes)| *bytes as u64).sum();
            self.tell(&Line::PlannerReady { ready_seconds: watch.seconds(), arena_bytes })?;
            let mut planned =
                search::run(&mut planner, task.scenario.planner.work_max, &mut |line| {
                    self.tell(line)
                })?;
            let found = planned.end == PlanEnd::Found;
            if !found && task.may_go_back(&planner) {
                self.tell(&Line::WalkingBack)?;
                task.go_back(&planner);
                continue;
            }
            if task.epoch > 0 && matches!(planned.end, PlanEnd::StartInvalid | PlanEnd::GoalInvalid)
            {
                // The scenario's marks were good enough for the first plan: there is no way on from
                // here.
                planned.end = PlanEnd::NoPlan;
            }
            self.tell(&Line::Planned(planned))?;
            return Ok(found.then_some(planner));
        }
    }

    fn deliver(
        &mut self,
        sender: &mut ChunkSender,
        chunks: &[PlanChunk],
    ) -> Result<Delivery, Failure> {
        let mut accepted = 0;
        let total = chunks.len() as u64;
        let delivery = sender.deliver(
            chunks,
            &mut |feedback| {
                if feedback.next_sequence != accepted {
                    accepted = feedback.next_sequence;
                    // Whoever does not hear this does not hear the end either, and that one counts.
                    let _ = self.tell(&Line::Delivering { accepted, chunks: total });
                }
            },
            &|| signals::raised().is_none(),
        )?;
        Ok(delivery)
    }

    fn export(&self, task: &Task, chunks: &[PlanChunk]) -> Result<(), Failure> {
        match &self.arguments.outputs.export {
            Some(path) => Ok(save(&self.plan_file(task, chunks, path), path)?),
            None => Ok(()),
        }
    }

    fn draw(&self, task: &Task, chunks: &[PlanChunk]) -> Result<(), Failure> {
        match &self.arguments.outputs.picture {
            Some(path) => outputs::draw(&self.inputs, &self.plan_file(task, chunks, path), path),
            None => Ok(()),
        }
    }

    /// The plan as a file that stands beside `path`.
    fn plan_file(&self, task: &Task, chunks: &[PlanChunk], path: &std::path::Path) -> PlanFile {
        plan_from_chunks(
            &self.inputs.model,
            &task.world,
            &task.scenario,
            chunks,
            &outputs::folder_of(path),
        )
    }

    fn tell(&mut self, line: &Line) -> Result<(), Failure> {
        self.report.note(line);
        self.audience.tell(line)
    }
}

/// Whether planning again from where the robot stands may help: the world turned out to be another,
/// the feet stand elsewhere than planned, another planner has planned again meanwhile, or the
/// robot, which `was_walking`, has walked on along the plan before.
fn may_go_on(delivery: &Delivery, was_walking: bool) -> bool {
    let differs = matches!(delivery.outcome, Outcome::Refused { check: Check::WorldDiffers, .. });
    let word = delivery.feedback.as_ref();
    let corrected = differs && word.is_some_and(|word| word.corrections_len > 0);
    let misplaced =
        matches!(delivery.outcome, Outcome::Refused { check: Check::FootMisplaced, .. });
    let stands = word.is_some_and(|word| word.standing.is_known());
    let is_out_of_date = matches!(
        delivery.outcome,
        Outcome::Refused { check: Check::Continuity | Check::World, sequence: 0, .. }
    );
    corrected
        || stands
            && (misplaced
                || was_walking && is_out_of_date
                || delivery.outcome == Outcome::Superseded)
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

    /// The plan of this delivery is given up for another one.
    fn give_up(&mut self, delivery: &Delivery) {
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
    use surefoot_shared_types::message::{Feedback, Standing};

    use super::*;

    #[test]
    fn a_plan_is_made_again_for_a_robot_that_walked_on_along_the_one_before() {
        let standing = Standing { contacts_len: 2, ..Standing::zeroed() };
        let refused = |check, sequence, standing| Delivery {
            outcome: Outcome::Refused { sequence, check, waypoint: 0 },
            sent: 8,
            resent: 0,
            accepted: 0,
            feedback: Some(Feedback { standing, ..Feedback::zeroed() }),
        };
        for check in [Check::Continuity, Check::World] {
            assert!(may_go_on(&refused(check, 0, standing), true));
            assert!(
                !may_go_on(&refused(check, 0, standing), false),
                "the scenario's mark is where it was asked to begin"
            );
            assert!(
                !may_go_on(&refused(check, 3, standing), true),
                "a chunk does not continue the one before it"
            );
            assert!(!may_go_on(&refused(check, 0, Standing::zeroed()), true));
        }
        assert!(!may_go_on(&refused(Check::Torque, 0, standing), true));
    }
}
