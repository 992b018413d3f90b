//! `surefoot request`: sends a request to a planner that serves, and prints its result.

use bytemuck::Zeroable;
use surefoot_shared_types::instance::instance::Instance;
use surefoot_shared_types::instance::participant::Participant;
use surefoot_shared_types::instance::requests::RequestClient;
use surefoot_shared_types::instance::sender::random_id;
use surefoot_shared_types::message::request::StancePoseData;
use surefoot_shared_types::message::{PlanRequest, RequestKind, RequestRecord, RequestState};

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
    let record = Waiting::new(&client, request).follow()?;
    terminal::print_result(&describe(&record));
    command_outcome(&record, &request)
}

fn request_of(arguments: &RequestArguments) -> PlanRequest {
    let data = |stance: &StanceArgument| StancePoseData {
        position: stance.position,
        yaw: stance.yaw,
        stance_width: arguments.stance_width.unwrap_or(0.0),
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
const SILENCE_SECONDS_MAX: f64 = 1.0;
/// Longest silence of a planner whose process exists, s.
const STOPPED_SECONDS_MAX: f64 = 60.0;

/// A client that waits for the end of its request.
struct Waiting<'a> {
    client: &'a RequestClient,
    request: PlanRequest,
    watch: Stopwatch,
    sent_at: f64,
    /// The session of the planner that has taken the request.
    session: Option<u64>,
    /// Time since the planner's last status.
    silence: Stopwatch,
    looked_at: f64,
    /// Whether a planner has published a status.
    has_planner: bool,
    /// The progress that was printed last.
    printed: String,
}

impl<'a> Waiting<'a> {
    fn new(client: &'a RequestClient, request: PlanRequest) -> Self {
        let start = Stopwatch::start();
        Self {
            client,
            request,
            watch: start,
            sent_at: f64::NEG_INFINITY,
            session: None,
            silence: start,
            looked_at: 0.0,
            has_planner: false,
            printed: String::new(),
        }
    }

    /// Repeats the request until a status names it, then follows its record to the end.
    fn follow(&mut self) -> Result<RequestRecord, CommandError> {
        loop {
            if let Some(signal) = signals::raised() {
                return Err(CommandError::Interrupted(signal));
            }
            if let Some(record) = self.receive()? {
                return Ok(record);
            }
            self.check_time()?;
            if self.session.is_none() && self.watch.seconds() - self.sent_at > REPEAT_SECONDS {
                self.client.send(&self.request)?;
                self.sent_at = self.watch.seconds();
            }
            std::thread::sleep(POLL_INTERVAL);
        }
    }

    /// Evaluates the latest status. Returns the record of this request once it has ended.
    fn receive(&mut self) -> Result<Option<RequestRecord>, CommandError> {
        let Some(status) = self.client.status()? else { return Ok(None) };
        self.silence = Stopwatch::start();
        self.has_planner = true;
        let known = self.session;
        let Some(record) = status.record_of(self.request.client, self.request.number) else {
            return match known {
                None => Ok(None),
                Some(session) if session == status.session => Err(CommandError::EndUnknown),
                Some(_) => Err(CommandError::PlannerReplaced),
            };
        };
        self.session = Some(status.session);
        if record.known_state().is_some_and(RequestState::is_final) {
            return Ok(Some(*record));
        }
        self.print_progress(record);
        Ok(None)
    }

    fn check_time(&mut self) -> Result<(), CommandError> {
        if self.session.is_none() && self.watch.seconds() > ACKNOWLEDGE_SECONDS_MAX {
            let seconds = ACKNOWLEDGE_SECONDS_MAX;
            return Err(if self.has_planner {
                CommandError::Unanswered { seconds }
            } else {
                CommandError::NoPlanner
            });
        }
        let silence = self.silence.seconds();
        if self.session.is_none() || silence < SILENCE_SECONDS_MAX {
            return Ok(());
        }
        if silence > STOPPED_SECONDS_MAX {
            return Err(CommandError::PlannerSilent { seconds: STOPPED_SECONDS_MAX });
        }
        if self.watch.seconds() - self.looked_at > SILENCE_SECONDS_MAX {
            self.looked_at = self.watch.seconds();
            if !self.client.has_server() {
                return Err(CommandError::PlannerEnded);
            }
        }
        Ok(())
    }

    /// Prints the request's progress to stderr, where it changes.
    fn print_progress(&mut self, record: &RequestRecord) {
        let plan = format!("plan {}.{}", record.plan_id, record.epoch);
        let progress = match record.known_state() {
            Some(RequestState::Delivering) if self.request.kind == RequestKind::Cancel as u32 => {
                "the robot finishes the chunks on their way".into()
            }
            Some(RequestState::Delivering) if record.chunks == 0 => {
                let walks = if record.accepted > 0 { "the robot walks" } else { "sent" };
                format!("{plan}: {walks} while the rest of it is planned")
            }
            Some(RequestState::Delivering) if record.accepted == 0 => {
                format!("{plan}: found, {} chunks; no controller has accepted one", record.chunks)
            }
            Some(RequestState::Delivering) => {
                format!("{plan}: found, {} chunks; the robot walks", record.chunks)
            }
            Some(RequestState::Planning) if record.plan_id == 0 => {
                "waiting until the robot stands".into()
            }
            _ => format!("{plan}: searching"),
        };
        if self.printed != progress {
            terminal::print_note(&progress);
            self.printed = progress;
        }
    }
}

fn describe(record: &RequestRecord) -> String {
    let state = RequestState::from_wire(record.state).map_or("unknown", RequestState::name);
    let plan = format!("plan {}.{}", record.plan_id, record.epoch);
    let counts = match record.chunks {
        0 => format!("{plan}, {} work units", record.work),
        chunks => format!(
            "{plan}, {} of {chunks} chunks accepted, {} work units, digest {}",
            record.accepted, record.work, record.digest
        ),
    };
    format!("{state}: {counts}; {}", record.reason())
}

fn command_outcome(
    record: &RequestRecord,
    request: &PlanRequest,
) -> Result<CommandOutcome, CommandError> {
    let reason = record.reason();
    match RequestState::from_wire(record.state) {
        Some(RequestState::Accepted) => Ok(CommandOutcome::Done),
        Some(RequestState::Cancelled) if is_cancelled(record, request) => Ok(CommandOutcome::Done),
        Some(RequestState::NoPlan) => Ok(CommandOutcome::NoPlan),
        Some(RequestState::Refused) => Ok(CommandOutcome::Refused),
        Some(RequestState::ControllerLost) => Err(CommandError::ControllerLost),
        Some(RequestState::Contradicted) => Err(CommandError::Contradicted),
        Some(RequestState::Cancelled) => {
            Err(CommandError::Usage(format!("the request is cancelled: {reason}")))
        }
        // The reason says which of them is invalid.
        Some(RequestState::StartInvalid | RequestState::GoalInvalid) => {
            Err(CommandError::Usage(reason.to_owned()))
        }
        _ => Err(CommandError::Usage(format!("the request is invalid: {reason}"))),
    }
}

/// Whether a request to cancel was met: by itself, or because the robot follows a newer request.
fn is_cancelled(record: &RequestRecord, request: &PlanRequest) -> bool {
    record.known_state() == Some(RequestState::Cancelled)
        && request.kind == RequestKind::Cancel as u32
}
