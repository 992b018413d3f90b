//! `surefoot control`: checks and walks the plan that arrives in an instance. Also the controller
//! process of a walk.

pub mod chunk_handler;

mod simulated;

use std::time::Duration;

use surefoot_controller_sim::channel::plan_subscriber::{PlanSubscriber, StreamEnd};
use surefoot_controller_sim::{
    Checker, CheckerError, ChunkExecutor, Disturbance, GroundTruth, Identity,
};
use surefoot_shared_types::instance::random_id;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::load::load_world;
use surefoot_shared_types::world::world::World;

use crate::cli::arguments::ControlArguments;
use crate::commands::control::chunk_handler::ChunkHandler;
use crate::commands::control::simulated::Simulated;
use crate::commands::session::{enter_instance, prepare_process};
use crate::input::inputs::Inputs;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::report::event::{CheckSummary, Refusal, RoleEvent};
use crate::report::reporter::Reporter;
use crate::system::signals;

/// How long the last feedback is repeated for a planner that stays connected, at most.
const LINGER_TIME_MAX: Duration = Duration::from_secs(10);

/// Runs the command.
///
/// # Errors
/// When an input cannot be used, the transport fails, or a signal comes.
pub fn run(arguments: &ControlArguments) -> Result<CommandOutcome, CommandError> {
    prepare_process(&arguments.role);
    let Inputs { scenario, model, world } = Inputs::load(&arguments.scenario, arguments.seed)?;
    let mut reporter = Reporter::new(arguments.role.report_lines, false);
    let id = random_id();
    let identity = Identity {
        controller_id: id,
        robot: model.digest,
        world: world.digest,
        config: scenario.digest,
    };
    let (ground_truth, world) = actual_world(arguments, &model, world)?;
    let checker = Checker::new(model, world, scenario.checker)?;
    let mut subscriber = PlanSubscriber::open(&enter_instance(&arguments.instance)?, id)?;
    let executor = match subscriber.taken_over() {
        Some(feedback) => ChunkExecutor::take_over(checker, identity, feedback),
        None => ChunkExecutor::new(checker, identity),
    };
    let simulated = arguments.rate.map(|rate| Simulated::new(&subscriber, id, rate)).transpose()?;
    let mut handler = ChunkHandler::new(
        executor,
        ground_truth,
        arguments.disturb.map(Disturbance::new),
        simulated,
    );
    if let Some(feedback) = subscriber.taken_over() {
        handler.mark_reported(feedback.corrections());
    }
    if let Some(seed) = arguments.disturb {
        subscriber.inject_faults(seed);
    }
    reporter.emit(&RoleEvent::ControllerReady)?;
    let keep_going = || signals::raised().is_none();
    let mut ended = match subscriber.stream_end() {
        Some(ended) => ended,
        None => {
            subscriber.run(&mut |chunk, heartbeat| handler.handle(chunk, heartbeat), &keep_going)?
        }
    };
    // A supervisor ends this process; until then a restarted planner may connect.
    let linger_max = (!arguments.role.report_lines && !arguments.serve).then_some(LINGER_TIME_MAX);
    loop {
        let refusal = match ended {
            StreamEnd::Finished => None,
            StreamEnd::Refused(chunk) => Some(Refusal::of(chunk, handler.detail().to_owned())),
            StreamEnd::PlannerLeft => {
                reporter
                    .emit(&RoleEvent::Holding { accepted: subscriber.feedback().next_sequence })?;
                ended = subscriber
                    .run(&mut |chunk, heartbeat| handler.handle(chunk, heartbeat), &keep_going)?;
                continue;
            }
            StreamEnd::Stopped => {
                return Err(CommandError::Interrupted(signals::raised().unwrap_or(libc::SIGTERM)));
            }
        };
        handler.error()?;
        let checked = handler.summary(subscriber.stats().duplicates, refusal);
        reporter.emit(&RoleEvent::Checked(checked.clone()))?;
        reporter.print(|| summary(&checked));
        match subscriber.linger(
            &mut |chunk, heartbeat| handler.handle(chunk, heartbeat),
            linger_max,
            &keep_going,
        )? {
            Some(next) => ended = next,
            None => {
                return Ok(if checked.refusal.is_some() {
                    CommandOutcome::Refused
                } else {
                    CommandOutcome::Done
                });
            }
        }
    }
}

/// The actual world, and its differences from the world that the planner knows.
fn actual_world(
    arguments: &ControlArguments,
    model: &RobotModel,
    known_world: World,
) -> Result<(Option<GroundTruth>, World), CommandError> {
    let Some(path) = &arguments.ground_truth else { return Ok((None, known_world)) };
    let world = load_world(path)?;
    let ground_truth =
        GroundTruth::new(model, &known_world, &world).map_err(CheckerError::Shape)?;
    Ok((Some(ground_truth), world))
}

fn summary(checked: &CheckSummary) -> String {
    let so_far = format!(
        "{} chunks walked and accepted; margins: {}",
        checked.accepted,
        checked.margins.describe()
    );
    match &checked.refusal {
        None => so_far,
        Some(refusal) => format!("{so_far}\nrefused: {}", refusal.describe()),
    }
}
