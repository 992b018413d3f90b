//! `surefoot plan --serve`: stays up, and plans and delivers what clients ask for.
//!
//! The newest request counts: it replaces the current planning or delivery. Robot and
//! world stay loaded.

use std::cell::RefCell;
use std::num::NonZeroUsize;
use std::time::Duration;

use bytemuck::Zeroable;
use surefoot_planner::Planner;
use surefoot_planner::channel::plan_publisher::PlanPublisher;
use surefoot_planner::channel::send_window::DeliveryOutcome;
use surefoot_planner::preparation::build::Preparation;
use surefoot_shared_types::instance::random_id;
use surefoot_shared_types::instance::requests::RequestServer;
use surefoot_shared_types::message::{PlanRequest, PlanStatus, RequestKind, RequestState};

use crate::cli::arguments::PlanArguments;
use crate::commands::plan::may_replan;
use crate::commands::plan::planning_task::PlanningTask;
use crate::commands::search_loop;
use crate::commands::session::enter_instance;
use crate::input::inputs::Inputs;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::report::event::{PlanResult, Planned, RoleEvent};
use crate::report::reporter::Reporter;
use crate::report::summary;
use crate::system::signals;

/// Time between two polls of the request server.
const POLL_INTERVAL: Duration = Duration::from_millis(5);
/// Longest time until a controller publishes its rest state.
const REST_STATE_WAIT_MAX: Duration = Duration::from_millis(300);

/// A request with its kind.
type IncomingRequest = (PlanRequest, RequestKind);

/// Serves until a signal comes.
///
/// # Errors
/// When no instance is named, the transport fails, or a signal comes.
pub(crate) fn run(
    arguments: &PlanArguments,
    inputs: &Inputs,
    preparation: Preparation<'static>,
    reporter: Reporter,
) -> Result<CommandOutcome, CommandError> {
    let Some(name) = &arguments.instance else {
        return Err(CommandError::Usage("--serve needs --instance NAME".into()));
    };
    let session = random_id();
    let sender = PlanPublisher::open(&enter_instance(name)?, session)?;
    let server = RequestServer::open(sender.participant(), session)?;
    let queue = RefCell::new(RequestQueue { server, status: PlanStatus::zeroed(), next: None });
    let mut server = Server {
        arguments,
        inputs,
        preparation,
        reporter,
        sender,
        queue: &queue,
        last: PlanningTask::first(inputs),
    };
    server.reporter.emit(&RoleEvent::PlannerServes)?;
    loop {
        let request = server.wait()?;
        server.serve(request)?;
    }
}

/// The request server, and the request that came while another one was served.
struct RequestQueue {
    server: RequestServer,
    status: PlanStatus,
    next: Option<IncomingRequest>,
}

impl RequestQueue {
    /// Looks for a request; answers whether there is one now, or a signal.
    fn is_interrupted(&mut self) -> bool {
        if self.next.is_none() {
            // A server that fails now fails again on the next wait.
            self.next = self.server.take().unwrap_or(None);
        }
        self.next.is_some() || signals::raised().is_some()
    }

    fn publish(&mut self) -> Result<(), CommandError> {
        Ok(self.server.publish(&self.status)?)
    }

    fn set_state(&mut self, state: RequestState) -> Result<(), CommandError> {
        self.status.state = state as u32;
        self.publish()
    }
}

struct Server<'a> {
    arguments: &'a PlanArguments,
    inputs: &'a Inputs,
    preparation: Preparation<'static>,
    reporter: Reporter,
    sender: PlanPublisher,
    queue: &'a RefCell<RequestQueue>,
    /// What was request for last.
    last: PlanningTask,
}

impl Server<'_> {
    /// Waits for a request, publishing the status meanwhile.
    fn wait(&mut self) -> Result<IncomingRequest, CommandError> {
        loop {
            let mut queue = self.queue.borrow_mut();
            if let Some(signal) = signals::raised() {
                return Err(CommandError::Interrupted(signal));
            }
            let request = match queue.next.take() {
                Some(request) => Some(request),
                None => queue.server.take()?,
            };
            if let Some(request) = request {
                return Ok(request);
            }
            queue.publish()?;
            drop(queue);
            std::thread::sleep(POLL_INTERVAL);
        }
    }

    /// Does what a request asks, unless another one comes.
    fn serve(&mut self, (request, kind): IncomingRequest) -> Result<(), CommandError> {
        self.queue.borrow_mut().status =
            PlanStatus { client: request.client, number: request.number, ..PlanStatus::zeroed() };
        let state = match self.task(&request, kind)? {
            Some(task) => self.plan_and_deliver(task)?,
            None if kind == RequestKind::Cancel => RequestState::Cancelled,
            None => RequestState::Invalid,
        };
        let PlanStatus { plan_id, epoch, .. } = self.queue.borrow().status;
        self.reporter.print(|| format!("plan {plan_id}.{epoch}: {}", state.name()));
        self.queue.borrow_mut().set_state(state)
    }

    /// What is to be planned, if anything.
    fn task(
        &mut self,
        request: &PlanRequest,
        kind: RequestKind,
    ) -> Result<Option<PlanningTask>, CommandError> {
        if kind == RequestKind::Cancel {
            return Ok(None);
        }
        let feedback =
            self.sender.wait_until_idle(REST_STATE_WAIT_MAX, &|| signals::raised().is_none())?;
        let Ok(here) = PlanningTask::fresh(self.inputs, feedback.as_ref()) else { return Ok(None) };
        let goal = if kind == RequestKind::Replan {
            Some(self.last.scenario.goal)
        } else {
            request.goal.stance_pose()
        };
        let Some(goal) = goal else { return Ok(None) };
        let task = here.towards(goal, request.seed, request.work_max);
        Ok(match kind {
            RequestKind::StartAndGoal => {
                request.start.stance_pose().map(|start| task.starting_at(start))
            }
            _ => Some(task),
        })
    }

    /// Plans and delivers a task, again where the world turns out to be another.
    fn plan_and_deliver(&mut self, task: PlanningTask) -> Result<RequestState, CommandError> {
        let mut task = task;
        self.last = task.clone();
        for _ in 0..=self.arguments.search.replans_max {
            let planner = match self.plan(&mut task)? {
                Ok(planner) => planner,
                Err(state) => return Ok(state),
            };
            self.queue.borrow_mut().set_state(RequestState::Delivering)?;
            let queue = self.queue;
            let mut accepted = 0;
            let delivery = self.sender.deliver(
                planner.chunks(),
                &mut |feedback| {
                    if feedback.next_sequence != accepted {
                        accepted = feedback.next_sequence;
                        let mut queue = queue.borrow_mut();
                        queue.status.accepted = accepted;
                        // A lost status is repaired by the final one.
                        let _ = queue.publish();
                    }
                },
                &|| !queue.borrow_mut().is_interrupted(),
            )?;
            match (delivery.outcome, delivery.feedback) {
                (DeliveryOutcome::Accepted, _) => return Ok(RequestState::Accepted),
                (DeliveryOutcome::Stopped, _) => return Ok(RequestState::Cancelled),
                (DeliveryOutcome::ControllerLost, _) => return Ok(RequestState::ControllerLost),
                (_, Some(feedback)) if may_replan(&delivery, task.rest_state.is_some()) => {
                    match task.after(
                        self.inputs,
                        &feedback,
                        planner.chunks(),
                        planner.retrace().chunks,
                    ) {
                        Ok(next) => task = next,
                        Err(_) => return Ok(RequestState::Refused),
                    }
                }
                _ => return Ok(RequestState::Refused),
            }
        }
        Ok(RequestState::Refused)
    }

    /// Searches, from farther back where nothing leads on; a planner with a plan, or the state in
    /// which the request ends.
    fn plan(
        &mut self,
        task: &mut PlanningTask,
    ) -> Result<Result<Planner, RequestState>, CommandError> {
        {
            let mut queue = self.queue.borrow_mut();
            (queue.status.plan_id, queue.status.epoch, queue.status.accepted) =
                (task.plan_id, task.epoch, 0);
            queue.set_state(RequestState::Planning)?;
        }
        let threads =
            NonZeroUsize::new(self.arguments.search.threads()).unwrap_or(NonZeroUsize::MIN);
        loop {
            let mut planner = task.planner(&self.inputs.model, self.preparation, threads)?;
            let Some(planned) = self.search(&mut planner, task)? else {
                return Ok(Err(RequestState::Cancelled));
            };
            if planned.result != PlanResult::NoPlan || !task.may_retrace_further(&planner) {
                return Ok(self.publish_result(planner, &planned, task));
            }
            task.retrace_further(&planner);
        }
    }

    /// Searches until it is over, or interrupted: nothing then.
    fn search(
        &mut self,
        planner: &mut Planner,
        task: &PlanningTask,
    ) -> Result<Option<Planned>, CommandError> {
        let (queue, reporter) = (self.queue, &mut self.reporter);
        let mut emit = |event: &RoleEvent| {
            if let RoleEvent::Planning(progress) = event {
                let mut queue = queue.borrow_mut();
                queue.status.work = progress.work;
                queue.publish()?;
            }
            reporter.emit(event)
        };
        search_loop::run_until(planner, task.scenario.planner.work_max, &mut emit, &mut || {
            queue.borrow_mut().is_interrupted()
        })
    }

    fn publish_result(
        &mut self,
        planner: Planner,
        planned: &Planned,
        task: &PlanningTask,
    ) -> Result<Planner, RequestState> {
        self.reporter.print(|| {
            summary::search_summary(&format!("plan {}.{}", task.plan_id, task.epoch), planned)
        });
        let mut queue = self.queue.borrow_mut();
        queue.status.work = planned.work;
        match planned.result {
            PlanResult::Found => {
                (queue.status.chunks, queue.status.digest) = (planned.chunks, planner.digest());
                Ok(planner)
            }
            PlanResult::NoPlan => Err(RequestState::NoPlan),
            PlanResult::StartInvalid => Err(RequestState::StartInvalid),
            PlanResult::GoalInvalid => Err(RequestState::GoalInvalid),
        }
    }
}
