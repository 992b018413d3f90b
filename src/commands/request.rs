//! `surefoot request`: asks a planner that stays up, and says what becomes of it.

use bytemuck::Zeroable;
use surefoot_shared_types::instance::desk::Client;
use surefoot_shared_types::instance::{Instance, Link, draw_id};
use surefoot_shared_types::message::request::MarkData;
use surefoot_shared_types::message::{PlanRequest, PlanStatus, RequestKind, RequestState};

use crate::arguments::{Prints, RequestArguments};
use crate::clock::Stopwatch;
use crate::failure::{Ending, Failure};
use crate::{signals, terminal};

/// How long a planner may take to notice a request, s.
const NOTICE_SECONDS_MAX: f64 = 10.0;
/// Time between two looks at the status.
const LOOK_EVERY: std::time::Duration = std::time::Duration::from_millis(2);
/// Time after which a request that nobody noticed is repeated, s.
const REPEAT_SECONDS: f64 = 0.02;

/// Runs the command.
///
/// # Errors
/// When the instance does not exist, no planner answers, the request cannot be met, or a signal
/// comes.
pub fn run(arguments: &RequestArguments) -> Result<Ending, Failure> {
    signals::install();
    let link = Link::open(&Instance::attach(&arguments.instance)?)?;
    let mut client = Client::open(link, draw_id())?;
    let request = client.sign(&request_of(arguments));
    let status = follow(&client, &request)?;
    terminal::say(&in_words(&status));
    ending(&status, &request)
}

fn request_of(arguments: &RequestArguments) -> PlanRequest {
    let data = |prints: &Prints| MarkData {
        position: prints.position,
        yaw: prints.yaw,
        feet_apart: arguments.feet_apart,
    };
    let kind = match (arguments.cancel, &arguments.start, &arguments.goal) {
        (true, _, _) => RequestKind::Cancel,
        (false, Some(_), Some(_)) => RequestKind::StartAndGoal,
        (false, None, Some(_)) => RequestKind::Goal,
        (false, _, None) => RequestKind::Replan,
    };
    PlanRequest {
        kind: kind as u32,
        seed: arguments.seed,
        work_max: arguments.work_max,
        start: arguments.start.as_ref().map_or(MarkData::zeroed(), data),
        goal: arguments.goal.as_ref().map_or(MarkData::zeroed(), data),
        ..PlanRequest::zeroed()
    }
}

/// Repeats the request until a status names it, then hears until its end.
fn follow(client: &Client, request: &PlanRequest) -> Result<PlanStatus, Failure> {
    let watch = Stopwatch::start();
    let mut sent_at = f64::NEG_INFINITY;
    let mut noticed = false;
    loop {
        if let Some(signal) = signals::raised() {
            return Err(Failure::Interrupted(signal));
        }
        if !noticed && watch.seconds() > NOTICE_SECONDS_MAX {
            return Err(Failure::NoPlanner);
        }
        if !noticed && watch.seconds() - sent_at > REPEAT_SECONDS {
            client.send(request)?;
            sent_at = watch.seconds();
        }
        let status = client.status()?;
        let is_ours = status.is_some_and(|status| {
            (status.client, status.number) == (request.client, request.number)
        });
        match status {
            Some(status) if is_ours && status.known_state().is_some_and(RequestState::is_final) => {
                return Ok(status);
            }
            Some(_) if is_ours => noticed = true,
            Some(status) if noticed => {
                return Ok(PlanStatus { state: RequestState::Cancelled as u32, ..status });
            }
            _ => {}
        }
        std::thread::sleep(LOOK_EVERY);
    }
}

fn in_words(status: &PlanStatus) -> String {
    let state = RequestState::from_wire(status.state).map_or("unknown", RequestState::word);
    let plan = format!("plan {}.{}", status.plan_id, status.epoch);
    match status.chunks {
        0 => format!("{state}: {plan}, {} work units", status.work),
        chunks => format!(
            "{state}: {plan}, {} of {chunks} chunks accepted, {} work units, digest {}",
            status.accepted, status.work, status.digest
        ),
    }
}

fn ending(status: &PlanStatus, request: &PlanRequest) -> Result<Ending, Failure> {
    match RequestState::from_wire(status.state) {
        Some(RequestState::Accepted) => Ok(Ending::Done),
        Some(RequestState::Cancelled) if request.kind == RequestKind::Cancel as u32 => {
            Ok(Ending::Done)
        }
        Some(RequestState::NoPlan) => Ok(Ending::NoPlan),
        Some(RequestState::Refused) => Ok(Ending::Refused),
        Some(RequestState::ControllerLost) => Err(Failure::ControllerLost),
        Some(RequestState::Cancelled) => {
            Err(Failure::Usage("somebody asked for something else meanwhile".into()))
        }
        Some(RequestState::StartInvalid) => {
            Err(Failure::Usage("the robot cannot stand at the start; the planner says why".into()))
        }
        Some(RequestState::GoalInvalid) => {
            Err(Failure::Usage("the robot cannot stand at the goal; the planner says why".into()))
        }
        _ => Err(Failure::Usage(
            "the request makes no sense, or it is not known where the robot stands".into(),
        )),
    }
}
