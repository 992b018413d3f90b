//! `surefoot plan --serve`: stays up, and plans and delivers what clients ask for.
//!
//! The newest request counts: it takes the place of whatever is planned or delivered. Robot and
//! world stay loaded.

use std::cell::RefCell;
use std::num::NonZeroUsize;
use std::time::Duration;

use bytemuck::Zeroable;
use surefoot_planner::Planner;
use surefoot_planner::channel::{ChunkSender, Outcome};
use surefoot_planner::prepare::Preparation;
use surefoot_shared_types::instance::desk::Clerk;
use surefoot_shared_types::instance::draw_id;
use surefoot_shared_types::message::{PlanRequest, PlanStatus, RequestKind, RequestState};

use super::super::enter;
use super::may_go_on;
use super::task::Task;
use crate::arguments::PlanArguments;
use crate::audience::Audience;
use crate::failure::{Ending, Failure};
use crate::inputs::Inputs;
use crate::line::{Line, PlanEnd, Planned};
use crate::{search, signals, verdict};

/// Time between two looks at the desk while there is nothing to do.
const LOOK_EVERY: Duration = Duration::from_millis(5);
/// How long a controller may take to say where its robot stands.
const SETTLE_WITHIN: Duration = Duration::from_millis(300);

/// A request with its kind.
type Asked = (PlanRequest, RequestKind);

/// Serves until a signal comes.
///
/// # Errors
/// When no instance is named, the transport fails, or a signal comes.
pub(super) fn run(
    arguments: &PlanArguments,
    inputs: &Inputs,
    preparation: Preparation<'static>,
    audience: Audience,
) -> Result<Ending, Failure> {
    let Some(name) = &arguments.instance else {
        return Err(Failure::Usage("--serve needs --instance NAME".into()));
    };
    let session = draw_id();
    let sender = ChunkSender::open(&enter(name)?, session)?;
    let clerk = Clerk::open(sender.link(), session)?;
    let desk = RefCell::new(Desk { clerk, status: PlanStatus::zeroed(), next: None });
    let mut server = Server {
        arguments,
        inputs,
        preparation,
        audience,
        sender,
        desk: &desk,
        last: Task::first(inputs),
    };
    server.audience.tell(&Line::PlannerServes)?;
    loop {
        let asked = server.wait()?;
        server.serve(asked)?;
    }
}

/// The desk, and the request that came while another one was served.
struct Desk {
    clerk: Clerk,
    status: PlanStatus,
    next: Option<Asked>,
}

impl Desk {
    /// Looks for a request; answers whether there is one now, or a signal.
    fn is_interrupted(&mut self) -> bool {
        if self.next.is_none() {
            // A desk that fails now fails again when it is waited at.
            self.next = self.clerk.take().unwrap_or(None);
        }
        self.next.is_some() || signals::raised().is_some()
    }

    fn tell(&mut self) -> Result<(), Failure> {
        Ok(self.clerk.tell(&self.status)?)
    }

    fn enter(&mut self, state: RequestState) -> Result<(), Failure> {
        self.status.state = state as u32;
        self.tell()
    }
}

struct Server<'a> {
    arguments: &'a PlanArguments,
    inputs: &'a Inputs,
    preparation: Preparation<'static>,
    audience: Audience,
    sender: ChunkSender,
    desk: &'a RefCell<Desk>,
    /// What was asked for last.
    last: Task,
}

impl Server<'_> {
    /// Waits for a request, telling how things stand.
    fn wait(&mut self) -> Result<Asked, Failure> {
        loop {
            let mut desk = self.desk.borrow_mut();
            if let Some(signal) = signals::raised() {
                return Err(Failure::Interrupted(signal));
            }
            let asked = match desk.next.take() {
                Some(asked) => Some(asked),
                None => desk.clerk.take()?,
            };
            if let Some(asked) = asked {
                return Ok(asked);
            }
            desk.tell()?;
            drop(desk);
            std::thread::sleep(LOOK_EVERY);
        }
    }

    /// Does what a request asks, unless another one comes.
    fn serve(&mut self, (request, kind): Asked) -> Result<(), Failure> {
        self.desk.borrow_mut().status =
            PlanStatus { client: request.client, number: request.number, ..PlanStatus::zeroed() };
        let state = match self.task(&request, kind)? {
            Some(task) => self.plan_and_deliver(task)?,
            None if kind == RequestKind::Cancel => RequestState::Cancelled,
            None => RequestState::Invalid,
        };
        let PlanStatus { plan_id, epoch, .. } = self.desk.borrow().status;
        self.audience.say(|| format!("plan {plan_id}.{epoch}: {}", state.word()));
        self.desk.borrow_mut().enter(state)
    }

    /// What is to be planned, if anything.
    fn task(&mut self, request: &PlanRequest, kind: RequestKind) -> Result<Option<Task>, Failure> {
        if kind == RequestKind::Cancel {
            return Ok(None);
        }
        let word = self.sender.settle(SETTLE_WITHIN, &|| signals::raised().is_none())?;
        let Ok(here) = Task::anew(self.inputs, word.as_ref()) else { return Ok(None) };
        let goal = if kind == RequestKind::Replan {
            Some(self.last.scenario.goal)
        } else {
            request.goal.mark()
        };
        let Some(goal) = goal else { return Ok(None) };
        let task = here.towards(goal, request.seed, request.work_max);
        Ok(match kind {
            RequestKind::StartAndGoal => request.start.mark().map(|start| task.starting_on(start)),
            _ => Some(task),
        })
    }

    /// Plans and delivers a task, again where the world turns out to be another.
    fn plan_and_deliver(&mut self, task: Task) -> Result<RequestState, Failure> {
        let mut task = task;
        self.last = task.clone();
        for _ in 0..=self.arguments.search.replans_max {
            let planner = match self.plan(&mut task)? {
                Ok(planner) => planner,
                Err(state) => return Ok(state),
            };
            self.desk.borrow_mut().enter(RequestState::Delivering)?;
            let desk = self.desk;
            let mut accepted = 0;
            let delivery = self.sender.deliver(
                planner.chunks(),
                &mut |word| {
                    if word.next_sequence != accepted {
                        accepted = word.next_sequence;
                        let mut desk = desk.borrow_mut();
                        desk.status.accepted = accepted;
                        // Whoever does not hear this hears the end.
                        let _ = desk.tell();
                    }
                },
                &|| !desk.borrow_mut().is_interrupted(),
            )?;
            match (delivery.outcome, delivery.feedback) {
                (Outcome::Accepted, _) => return Ok(RequestState::Accepted),
                (Outcome::Stopped, _) => return Ok(RequestState::Cancelled),
                (Outcome::ControllerLost, _) => return Ok(RequestState::ControllerLost),
                (_, Some(word)) if may_go_on(&delivery, task.standing.is_some()) => {
                    match task.after(
                        self.inputs,
                        &word,
                        planner.chunks(),
                        planner.way_back().chunks,
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
    fn plan(&mut self, task: &mut Task) -> Result<Result<Planner, RequestState>, Failure> {
        {
            let mut desk = self.desk.borrow_mut();
            (desk.status.plan_id, desk.status.epoch, desk.status.accepted) =
                (task.plan_id, task.epoch, 0);
            desk.enter(RequestState::Planning)?;
        }
        let threads =
            NonZeroUsize::new(self.arguments.search.threads()).unwrap_or(NonZeroUsize::MIN);
        loop {
            let mut planner = task.planner(&self.inputs.model, self.preparation, threads)?;
            let Some(planned) = self.search(&mut planner, task)? else {
                return Ok(Err(RequestState::Cancelled));
            };
            if planned.end != PlanEnd::NoPlan || !task.may_go_back(&planner) {
                return Ok(self.conclude(planner, &planned, task));
            }
            task.go_back(&planner);
        }
    }

    /// Searches until it is over, or interrupted: nothing then.
    fn search(&mut self, planner: &mut Planner, task: &Task) -> Result<Option<Planned>, Failure> {
        let (desk, audience) = (self.desk, &mut self.audience);
        let mut tell = |line: &Line| {
            if let Line::Planning(searching) = line {
                let mut desk = desk.borrow_mut();
                desk.status.work = searching.work;
                desk.tell()?;
            }
            audience.tell(line)
        };
        search::run_until(planner, task.scenario.planner.work_max, &mut tell, &mut || {
            desk.borrow_mut().is_interrupted()
        })
    }

    fn conclude(
        &mut self,
        planner: Planner,
        planned: &Planned,
        task: &Task,
    ) -> Result<Planner, RequestState> {
        self.audience
            .say(|| verdict::of_search(&format!("plan {}.{}", task.plan_id, task.epoch), planned));
        let mut desk = self.desk.borrow_mut();
        desk.status.work = planned.work;
        match planned.end {
            PlanEnd::Found => {
                (desk.status.chunks, desk.status.digest) = (planned.chunks, planner.digest());
                Ok(planner)
            }
            PlanEnd::NoPlan => Err(RequestState::NoPlan),
            PlanEnd::StartInvalid => Err(RequestState::StartInvalid),
            PlanEnd::GoalInvalid => Err(RequestState::GoalInvalid),
        }
    }
}
