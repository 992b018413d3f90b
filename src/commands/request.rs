//! `surefoot request`: sends a request to a planner that serves, and prints its result.

use bytemuck::Zeroable;
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::participant::Participant;
use surefoot_shared_types::instance::requests::RequestClient;
use surefoot_shared_types::instance::sender::random_id;
use surefoot_shared_types::message::request::StancePoseData;
use surefoot_shared_types::message::{PlanRequest, PlanStatus, RequestKind, RequestState};

use crate::cli::arguments::{RequestArguments, StanceArgument};
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::system::clock::Stopwatch;
use crate::system::{signals, terminal};

/// Longest time until a planner acknowledges a request, s.
const ACKNOWLEDGE_SECONDS_MAX: f64 = 10.0;
/// Time between two polls of the status.
const POLL_INTERVAL: std::time::Duration = std::time::Duration::from_millis(2);
/// Time after which a request without acknowledgement is repeated, s.
const REPEAT_SECONDS: f64 = 0.02;

/// Runs the command.
///
/// # Errors
/// When the instance does not exist, no planner answers, the request cannot be met, or a signal
/// comes.
pub fn run(arguments: &RequestArguments) -> Result<CommandOutcome, CommandError> {
    CommandError::unless_limited()?;
    let _deferral = signals::defer();
    let participant = Participant::open(&Instance::attach(&arguments.instance)?)?;
    let mut client = RequestClient::open(participant, random_id())?;
    let request = client.stamp(&request_of(arguments));
    let status = follow(&client, &request)?;
    terminal::print_result(&describe(&status));
    command_outcome(&status, &request)
}

fn request_of(arguments: &RequestArguments) -> PlanRequest {
    let data = |stance: &StanceArgument| StancePoseData {
        position: stance.position,
        yaw: stance.yaw,
        stance_width: arguments.stance_width,
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
        start: arguments.start.as_ref().map_or(StancePoseData::zeroed(), data),
        goal: arguments.goal.as_ref().map_or(StancePoseData::zeroed(), data),
        ..PlanRequest::zeroed()
    }
}

/// Silence of the planner after which the client looks whether it is still connected, s.
const SILENCE_SECONDS_MAX: f64 = 2.0;

/// Repeats the request until a status names it, then follows its status to the final one.
fn follow(client: &RequestClient, request: &PlanRequest) -> Result<PlanStatus, CommandError> {
    let watch = Stopwatch::start();
    let mut sent_at = f64::NEG_INFINITY;
    // The session of the planner that has taken the request.
    let mut session: Option<u64> = None;
    let mut silence = Stopwatch::start();
    loop {
        if let Some(signal) = signals::raised() {
            return Err(CommandError::Interrupted(signal));
        }
        if session.is_none() && watch.seconds() > ACKNOWLEDGE_SECONDS_MAX {
            return Err(CommandError::NoPlanner);
        }
        if session.is_some() && silence.seconds() > SILENCE_SECONDS_MAX {
            if !client.has_server() {
                return Err(CommandError::NoPlanner);
            }
            silence = Stopwatch::start();
        }
        if session.is_none() && watch.seconds() - sent_at > REPEAT_SECONDS {
            client.send(request)?;
            sent_at = watch.seconds();
        }
        let status = client.status()?;
        if status.is_some() {
            silence = Stopwatch::start();
        }
        let is_ours = status.is_some_and(|status| {
            (status.client, status.number) == (request.client, request.number)
        });
        match status {
            Some(status) if is_ours && status.known_state().is_some_and(RequestState::is_final) => {
                return Ok(status);
            }
            Some(status) if is_ours => session = Some(status.session),
            Some(status) if session.is_some_and(|session| session != status.session) => {
                return Err(CommandError::Usage(
                    "another planner replaced the one that had this request; send it again".into(),
                ));
            }
            Some(status) if session.is_some() => {
                return Ok(PlanStatus { state: RequestState::Cancelled as u32, ..status });
            }
            _ => {}
        }
        std::thread::sleep(POLL_INTERVAL);
    }
}

fn describe(status: &PlanStatus) -> String {
    let state = RequestState::from_wire(status.state).map_or("unknown", RequestState::name);
    let plan = format!("plan {}.{}", status.plan_id, status.epoch);
    match status.chunks {
        0 => format!("{state}: {plan}, {} work units", status.work),
        chunks => format!(
            "{state}: {plan}, {} of {chunks} chunks accepted, {} work units, digest {}",
            status.accepted, status.work, status.digest
        ),
    }
}

fn command_outcome(
    status: &PlanStatus,
    request: &PlanRequest,
) -> Result<CommandOutcome, CommandError> {
    match RequestState::from_wire(status.state) {
        Some(RequestState::Accepted) => Ok(CommandOutcome::Done),
        Some(RequestState::Cancelled) if request.kind == RequestKind::Cancel as u32 => {
            Ok(CommandOutcome::Done)
        }
        Some(RequestState::NoPlan) => Ok(CommandOutcome::NoPlan),
        Some(RequestState::Refused) => Ok(CommandOutcome::Refused),
        Some(RequestState::ControllerLost) => Err(CommandError::ControllerLost),
        Some(RequestState::Cancelled) => {
            Err(CommandError::Usage("another client's request replaced this one".into()))
        }
        Some(RequestState::StartInvalid) => Err(CommandError::Usage(
            "the start stance is invalid; the planner's output gives the reason".into(),
        )),
        Some(RequestState::GoalInvalid) => Err(CommandError::Usage(
            "the goal stance is invalid; the planner's output gives the reason".into(),
        )),
        _ => Err(CommandError::Usage(
            "the request is invalid, or the robot's rest state is unknown".into(),
        )),
    }
}
