//! `surefoot plan --serve`: plans and delivers what clients request, until a signal comes.
//!
//! [`Server::step`] runs one stage; [`TRANSITIONS`] holds the stage that follows. A newer request
//! replaces the one that is planned or delivered. The robot and the world stay loaded.

use std::cell::RefCell;
use std::num::NonZeroUsize;
use std::time::Duration;

use surefoot_planner::Planner;
use surefoot_planner::channel::plan_publisher::{Delivery, PlanPublisher};
use surefoot_planner::channel::send_window::DeliveryOutcome;
use surefoot_planner::preparation::Preparation;
use surefoot_shared_types::instance::requests::RequestServer;
use surefoot_shared_types::instance::sender::random_id;
use surefoot_shared_types::message::{
    Feedback, PlanRequest, RequestKind, RequestRecord, RequestState,
};

use crate::cli::arguments::PlanArguments;
use crate::commands::plan::described_publisher;
use crate::commands::plan::growing_plan::{Callbacks, GrowingPlan, OpenSearch};
use crate::commands::plan::planning_task::{PlanningTask, may_replan};
use crate::commands::plan::request_queue::RequestQueue;
use crate::input::inputs::Inputs;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::report::event::{Delivered, PlanResult, Planned, RoleEvent};
use crate::report::reporter::Reporter;
use crate::report::summary;
use crate::system::clock::Stopwatch;
use crate::system::signals;

/// Time between two polls of the request server.
const POLL_INTERVAL: Duration = Duration::from_millis(5);
/// Silence after which the planner looks whether a controller is connected.
const SILENCE_MAX: Duration = Duration::from_millis(300);
/// Silence of a connected controller after which it counts as lost, s.
const LOST_SECONDS: f64 = 30.0;
/// Longest time until the robot rests at the end of the chunks on their way, s. These take some
/// seconds each, at the slowest rate of simulation longer.
const REST_SECONDS_MAX: f64 = 300.0;

/// A stage of serving.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// Wait for a request.
    Wait,
    /// Search for a plan until its first chunk is final.
    Plan,
    /// Deliver the plan to the controller while the rest of it is made.
    Deliver,
    /// Publish the request's final state.
    Report,
}

/// The event that ends a stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Event {
    /// A request asks for a plan.
    Requested,
    /// There are chunks to deliver.
    Found,
    /// The rest of the plan must be planned again.
    Replan,
    /// The request has its final state.
    Finished,
    /// The final state is published.
    Reported,
}

/// The transitions between the stages. An error of a stage ends the process.
const TRANSITIONS: [(Stage, Event, Stage); 7] = [
    (Stage::Wait, Event::Requested, Stage::Plan),
    (Stage::Wait, Event::Finished, Stage::Report),
    (Stage::Plan, Event::Found, Stage::Deliver),
    (Stage::Plan, Event::Finished, Stage::Report),
    (Stage::Deliver, Event::Replan, Stage::Plan),
    (Stage::Deliver, Event::Finished, Stage::Report),
    (Stage::Report, Event::Reported, Stage::Wait),
];

/// The stage that follows `stage` after `event`.
fn next(stage: Stage, event: Event) -> Stage {
    let found = TRANSITIONS.iter().find(|row| (row.0, row.1) == (stage, event));
    found.map_or(Stage::Report, |row| row.2)
}

/// Serves until a signal comes.
///
/// # Errors
/// No instance is named, the transport fails, or a signal comes.
pub(crate) fn run(
    arguments: &PlanArguments,
    inputs: &Inputs,
    preparation: Preparation,
    reporter: Reporter,
) -> Result<CommandOutcome, CommandError> {
    let Some(name) = &arguments.instance else {
        return Err(CommandError::Usage("--serve needs --instance NAME".into()));
    };
    let session = random_id();
    let publisher = described_publisher::open(name, session, inputs)?;
    let server = RequestServer::open(publisher.participant(), session)?;
    let queue = RefCell::new(RequestQueue::new(server));
    let mut server = Server {
        arguments,
        inputs,
        preparation,
        reporter,
        publisher,
        queue: &queue,
        task: PlanningTask::first(inputs),
        open: None,
        replans: 0,
        end: RequestEnd { state: RequestState::Invalid, reason: String::new() },
        has_robot: false,
    };
    server.reporter.emit(&RoleEvent::PlannerServes)?;
    let mut stage = Stage::Wait;
    loop {
        stage = next(stage, server.step(stage)?);
    }
}

/// The ranges of a request's numbers, for the client whose request is beyond them.
const REQUEST_RANGES: &str = "out of range: millimetres? positions are in m, at most 10000, the \
                              heading is in rad, the stance width in m, above 0 and at most 10";

struct Server<'a> {
    arguments: &'a PlanArguments,
    inputs: &'a Inputs,
    preparation: Preparation,
    reporter: Reporter,
    publisher: PlanPublisher,
    queue: &'a RefCell<RequestQueue>,
    /// The latest planning task.
    task: PlanningTask,
    /// The search of the plan to deliver.
    open: Option<OpenSearch>,
    /// Number of times that the request was planned again.
    replans: u32,
    /// How the request ended.
    end: RequestEnd,
    /// Whether a controller has reported a rest state.
    has_robot: bool,
}

/// How a request ended.
#[derive(Debug, Clone)]
struct RequestEnd {
    state: RequestState,
    /// The reason, for the client.
    reason: String,
}

impl RequestEnd {
    fn new(state: RequestState, reason: impl Into<String>) -> Self {
        Self { state, reason: reason.into() }
    }

    /// The end of a request that a newer one or a signal interrupts.
    fn interrupted() -> Self {
        let reason = match signals::raised() {
            Some(signal) => format!("the planner was ended by signal {signal}"),
            None => "a newer request took its place".into(),
        };
        Self::new(RequestState::Cancelled, reason)
    }
}

/// The task of a request, or how the request ended.
type Task = Result<PlanningTask, RequestEnd>;

impl Server<'_> {
    fn step(&mut self, stage: Stage) -> Result<Event, CommandError> {
        match stage {
            Stage::Wait => self.wait(),
            Stage::Plan => self.plan(),
            Stage::Deliver => self.deliver(),
            Stage::Report => self.report(),
        }
    }

    fn finish(&mut self, state: RequestState, reason: impl Into<String>) -> Event {
        self.finish_as(RequestEnd::new(state, reason))
    }

    fn finish_as(&mut self, end: RequestEnd) -> Event {
        self.end = end;
        Event::Finished
    }

    /// Waits for a request, publishing the status meanwhile, and derives the planning task.
    fn wait(&mut self) -> Result<Event, CommandError> {
        let (request, kind) = loop {
            if let Some(signal) = signals::raised() {
                return Err(CommandError::Interrupted(signal));
            }
            if let Some(request) = self.queue.borrow_mut().take()? {
                break request;
            }
            self.queue.borrow_mut().publish()?;
            self.publisher.participant().refresh_description();
            std::thread::sleep(POLL_INTERVAL);
        };
        self.queue.borrow_mut().begin(&request)?;
        if kind == RequestKind::Cancel {
            return self.wait_until_cancelled();
        }
        match self.task_of(&request, kind)? {
            Ok(task) => {
                (self.task, self.replans) = (task, 0);
                self.task.improve = self.arguments.search.improve;
                self.task.in_parts = true;
                Ok(Event::Requested)
            }
            Err(end) => Ok(self.finish_as(end)),
        }
    }

    /// Waits until the robot stands at the end of the chunks that were on their way.
    fn wait_until_cancelled(&mut self) -> Result<Event, CommandError> {
        self.queue.borrow_mut().set_state(RequestState::Delivering)?;
        Ok(match self.rest_feedback()? {
            Ok(Some(feedback)) => {
                let Feedback { plan_id, epoch, next_sequence, .. } = feedback;
                let place = format!(
                    "the robot stands after {next_sequence} chunks of plan {plan_id}.{epoch}"
                );
                self.finish(RequestState::Cancelled, place)
            }
            Ok(None) => self.finish(RequestState::Cancelled, "no controller is connected"),
            Err(end) => self.finish_as(end),
        })
    }

    /// The planning task of a request.
    fn task_of(&mut self, request: &PlanRequest, kind: RequestKind) -> Result<Task, CommandError> {
        let feedback = match self.rest_feedback()? {
            Ok(feedback) => feedback,
            Err(end) => return Ok(Err(end)),
        };
        let invalid = |reason: String| Ok(Err(RequestEnd::new(RequestState::Invalid, reason)));
        let task = match PlanningTask::fresh(self.inputs, feedback.as_ref()) {
            Ok(task) => task,
            Err(error) => return invalid(error.to_string()),
        };
        let usual_width = self.inputs.scenario.goal.stance_width;
        let goal = match kind {
            RequestKind::Replan => Some(self.task.scenario.goal),
            _ => request.goal.requested_pose(usual_width),
        };
        let out_of_range = |which: &str| format!("{which}: {REQUEST_RANGES}");
        let Some(goal) = goal else { return invalid(out_of_range("goal")) };
        let task = task.towards(goal, request.seed, request.work_max);
        let task = match (kind, request.start.requested_pose(usual_width)) {
            (RequestKind::StartAndGoal, Some(start)) => task.starting_at(start),
            (RequestKind::StartAndGoal, None) => {
                return invalid(out_of_range("start"));
            }
            _ => task,
        };
        match task.scenario.start.check_walk_to(&task.scenario.goal) {
            Ok(()) => Ok(Ok(task)),
            Err(reason) => invalid(format!("goal: {reason}")),
        }
    }

    /// The feedback of a controller that has executed all chunks; `None` if no controller has
    /// connected yet. Waits while a connected controller executes or is silent. Ends with the
    /// request's end if another request arrives or the controller is lost.
    fn rest_feedback(&mut self) -> Result<Result<Option<Feedback>, RequestEnd>, CommandError> {
        let queue = self.queue;
        let (begin, mut silence) = (Stopwatch::start(), Stopwatch::start());
        loop {
            let wait = Stopwatch::start();
            let keep_going = || !queue.borrow_mut().is_interrupted_or_repeat();
            if let Some(feedback) = self.publisher.wait_until_idle(SILENCE_MAX, &keep_going)? {
                self.has_robot |= feedback.rest_state.is_known();
                return Ok(Ok(Some(feedback)));
            }
            if queue.borrow_mut().is_interrupted() {
                return Ok(Err(RequestEnd::interrupted()));
            }
            if wait.seconds() > 2.0 * SILENCE_MAX.as_secs_f64() {
                // The controller published feedback in between.
                silence = Stopwatch::start();
            }
            self.publisher.participant().clean_up_dead();
            let is_connected = self.publisher.has_controller();
            if !is_connected && !self.has_robot {
                return Ok(Ok(None));
            }
            if silence.seconds() > LOST_SECONDS || begin.seconds() > REST_SECONDS_MAX {
                let reason =
                    format!("the controller has not come to rest within {:.0} s", begin.seconds());
                return Ok(Err(RequestEnd::new(RequestState::ControllerLost, reason)));
            }
        }
    }

    /// Searches. If no plan is found, searches again from a state that the robot retraces to.
    fn plan(&mut self) -> Result<Event, CommandError> {
        let (plan_id, epoch) = (self.task.plan_id, self.task.epoch);
        self.queue.borrow_mut().begin_plan(plan_id, epoch)?;
        let threads =
            NonZeroUsize::new(self.arguments.search.threads()).unwrap_or(NonZeroUsize::MIN);
        loop {
            let planner =
                self.task.planner(&self.inputs.model, self.preparation.clone(), threads)?;
            let mut open = OpenSearch::begin(planner, self.task.scenario.planner.work_max);
            let queue = self.queue;
            let emit = &mut |event: &RoleEvent| emit_and_publish(queue, &mut self.reporter, event);
            let is_over = &mut || queue.borrow_mut().is_interrupted();
            if !open.make_first_chunk(emit, is_over)? {
                return Ok(self.finish_as(RequestEnd::interrupted()));
            }
            if open.is_stopped() {
                return Ok(self.finish_improved(&open));
            }
            if !open.is_without_chunks() {
                self.open = Some(open);
                return Ok(Event::Found);
            }
            if !self.task.may_retrace_further(&open.planner) {
                let planned = open.planned.as_ref();
                return Ok(planned.map_or(Event::Finished, |planned| self.finish_failed(planned)));
            }
            self.task.retrace_further(&open.planner);
        }
    }

    /// Ends a request that was interrupted while its plan was improved: reports the best plan,
    /// which is not delivered.
    fn finish_improved(&mut self, open: &OpenSearch) -> Event {
        let mut end = RequestEnd::interrupted();
        if let Some(planned) = &open.planned {
            self.print_planned(planned);
            record_plan(self.queue.borrow_mut().current(), planned, &open.planner);
            let best = planned.improved.map_or(0.0, |improved| improved.seconds);
            end.reason += &format!("; its best plan, of {best:.1} s, is not delivered");
        }
        self.finish_as(end)
    }

    /// Ends the request as its search has ended, without a plan.
    fn finish_failed(&mut self, planned: &Planned) -> Event {
        self.print_planned(planned);
        self.queue.borrow_mut().current().work = planned.work;
        let state = match planned.result {
            PlanResult::Found | PlanResult::NoPlan => RequestState::NoPlan,
            PlanResult::Stopped => RequestState::Cancelled,
            PlanResult::StartInvalid => RequestState::StartInvalid,
            PlanResult::GoalInvalid => RequestState::GoalInvalid,
        };
        self.finish(state, planned.description.as_str())
    }

    fn print_planned(&mut self, planned: &Planned) {
        let name = format!("plan {}.{}", self.task.plan_id, self.task.epoch);
        self.reporter.print(|| summary::search_summary(&name, planned));
    }

    /// Delivers the plan. Plans the rest again if that can help.
    fn deliver(&mut self) -> Result<Event, CommandError> {
        let Some(mut open) = self.open.take() else {
            return Ok(self.finish(RequestState::Refused, "the plan was lost"));
        };
        self.queue.borrow_mut().set_state(RequestState::Delivering)?;
        let delivery = self.send(&mut open)?;
        self.has_robot |= delivery.feedback.is_some_and(|feedback| feedback.rest_state.is_known());
        Ok(match delivery.outcome {
            DeliveryOutcome::Accepted => {
                self.finish(RequestState::Accepted, "the robot stands at the goal")
            }
            DeliveryOutcome::Stopped => self.finish_as(RequestEnd::interrupted()),
            DeliveryOutcome::ControllerLost => {
                self.finish(RequestState::ControllerLost, "the controller accepts no more chunks")
            }
            DeliveryOutcome::Contradicted => {
                let reason = CommandError::Contradicted.to_string();
                self.finish(RequestState::Contradicted, reason)
            }
            DeliveryOutcome::Refused { .. }
            | DeliveryOutcome::Superseded
            | DeliveryOutcome::Incomplete => self.replan(&delivery, &open),
        })
    }

    /// Sends the chunks while they are made. Only an interruption ends the search early.
    fn send(&mut self, open: &mut OpenSearch) -> Result<Delivery, CommandError> {
        let (queue, plan) = (self.queue, (self.task.plan_id, self.task.epoch));
        let reporter = RefCell::new(&mut self.reporter);
        let name = format!("plan {}.{}", plan.0, plan.1);
        let emit =
            &mut |event: &RoleEvent| emit_and_publish(queue, &mut reporter.borrow_mut(), event);
        let on_found = &mut |planner: &Planner, planned: &Planned| {
            reporter.borrow_mut().print(|| summary::search_summary(&name, planned));
            let mut queue = queue.borrow_mut();
            record_plan(queue.current(), planned, planner);
            queue.publish()
        };
        let mut growing = GrowingPlan::new(open, Callbacks { emit, on_found })?;
        let mut accepted = 0;
        let delivery = self.publisher.deliver_from(
            &mut growing,
            &mut |feedback| {
                let is_of_plan = (feedback.plan_id, feedback.epoch) == plan;
                if is_of_plan && feedback.next_sequence != accepted {
                    accepted = feedback.next_sequence;
                    let mut queue = queue.borrow_mut();
                    let made = queue.current().chunks;
                    queue.current().accepted = if made > 0 { accepted.min(made) } else { accepted };
                    // The final status repeats the number, so a lost one does no harm.
                    let _ = queue.publish();
                }
            },
            &|| !queue.borrow_mut().is_interrupted_or_repeat(),
        )?;
        growing.finish(delivery.outcome == DeliveryOutcome::Stopped)?;
        queue.borrow_mut().current().accepted = delivery.accepted;
        Ok(delivery)
    }

    /// Sets the task that follows an incomplete delivery, if there is one.
    fn replan(&mut self, delivery: &Delivery, open: &OpenSearch) -> Event {
        let may_replan = self.replans < self.arguments.search.replans_max
            && may_replan(delivery, self.task.rest_state.is_some());
        let Some(feedback) = delivery.feedback.filter(|_| may_replan) else {
            if let Some(planned) = open.planned.as_ref().filter(|_| open.has_failed()) {
                return self.finish_failed(planned);
            }
            let refusal = Delivered::from(delivery).refusal;
            let reason = refusal.map_or_else(
                || "the controller executes a later plan of another planner".into(),
                |refusal| refusal.describe(),
            );
            return self.finish(RequestState::Refused, reason);
        };
        let OpenSearch { planner, .. } = open;
        let retraced = planner.retrace().chunks;
        let chunks = planner.final_chunks();
        let task = self.task.take().after(self.inputs, &feedback, chunks, retraced);
        let task = match task {
            Ok(task) => task,
            Err(error) => return self.finish(RequestState::Refused, error.to_string()),
        };
        (self.task, self.replans) = (task, self.replans + 1);
        Event::Replan
    }

    fn report(&mut self) -> Result<Event, CommandError> {
        let RequestRecord { plan_id, epoch, .. } = *self.queue.borrow_mut().current();
        let RequestEnd { state, reason } = &self.end;
        self.reporter.print(|| format!("plan {plan_id}.{epoch}: {}: {reason}", state.name()));
        self.queue.borrow_mut().finish(*state, reason)?;
        Ok(Event::Reported)
    }
}

/// Records a complete plan.
fn record_plan(record: &mut RequestRecord, planned: &Planned, planner: &Planner) {
    (record.work, record.chunks, record.digest) = (planned.work, planned.chunks, planner.digest());
}

/// Reports an event, and publishes the progress of a search.
fn emit_and_publish(
    queue: &RefCell<RequestQueue>,
    reporter: &mut Reporter,
    event: &RoleEvent,
) -> Result<(), CommandError> {
    if let RoleEvent::Planning(progress) = event {
        let mut queue = queue.borrow_mut();
        queue.current().work = progress.work;
        queue.publish()?;
    }
    reporter.emit(event)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_stage_leads_back_to_waiting() {
        for stage in [Stage::Wait, Stage::Plan, Stage::Deliver, Stage::Report] {
            let mut reached: Vec<Stage> =
                TRANSITIONS.iter().filter(|row| row.0 == stage).map(|row| row.2).collect();
            for _ in 0..TRANSITIONS.len() {
                let following =
                    TRANSITIONS.iter().filter(|row| reached.contains(&row.0)).map(|row| row.2);
                let following: Vec<Stage> = following.collect();
                reached.extend(following);
            }
            assert!(reached.contains(&Stage::Wait), "{stage:?}");
        }
    }
}
