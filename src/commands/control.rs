//! `surefoot control`: checks the plan that arrives in an instance and executes it. Also the
//! controller process of a walk.

pub mod chunk_handler;

mod paced_walk;

use std::cell::RefCell;
use std::path::Path;
use std::time::Duration;

use surefoot_controller_sim::channel::plan_subscriber::{PlanSubscriber, StreamEnd};
use surefoot_controller_sim::{
    Checker, CheckerError, ChunkExecutor, Disturbance, Goal, GroundTruth, Identity,
};
use surefoot_shared_types::config::scenario::{Scenario, StancePose};
use surefoot_shared_types::instance::sender::random_id;
use surefoot_shared_types::message::{PlanChunk, WalkRecord};
use surefoot_shared_types::plan_file::write::{executed_plan, save};
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::load::load_world;
use surefoot_shared_types::world::world::World;

use crate::cli::arguments::ControlArguments;
use crate::cli::simulation_arguments::SimulationArguments;
use crate::commands::control::chunk_handler::{ChunkHandler, SharedHandler};
use crate::commands::control::paced_walk::{PacedWalk, WalkOptions};
use crate::commands::session::prepare_process;
use crate::input::inputs::{Inputs, Overrides};
use crate::input::output_files;
use crate::input::shipped::world_path;
use crate::report::command_error::{CommandError, CommandOutcome};
use crate::report::event::{CheckSummary, Refusal, RoleEvent};
use crate::report::liveness;
use crate::report::reporter::Reporter;
use crate::system::instance::enter_instance;
use crate::system::signals;

/// Longest time that the last feedback is repeated for a planner that stays connected.
const LINGER_TIME_MAX: Duration = Duration::from_secs(10);

/// Runs the command.
///
/// # Errors
/// An input cannot be used, the transport fails, or a signal comes.
pub fn run(arguments: &ControlArguments) -> Result<CommandOutcome, CommandError> {
    prepare_process(&arguments.role);
    CommandError::unless_limited()?;
    let mut controller = Controller::open(arguments)?;
    let _deferral = signals::defer();
    controller.reporter.emit(&RoleEvent::ControllerReady)?;
    match controller.run() {
        Err(CommandError::Interrupted(_)) if arguments.serve => Ok(CommandOutcome::Done),
        ended => ended,
    }
}

/// The file of the motion as executed, with the scenario and the world that the planner knows.
struct Record<'a> {
    path: &'a Path,
    scenario: Scenario,
    world: World,
    /// The seed of misplaced feet, if there are any.
    disturb_seed: Option<u64>,
}

/// A controller that is connected to an instance.
struct Controller<'a> {
    subscriber: PlanSubscriber,
    handler: ChunkHandler,
    /// Where the motion as executed is written, if it is.
    record: Option<Record<'a>>,
    reporter: Reporter,
    /// Longest time that the controller stays after a complete plan; no limit if `None`.
    linger_max: Option<Duration>,
}

impl<'a> Controller<'a> {
    fn open(arguments: &'a ControlArguments) -> Result<Self, CommandError> {
        let overrides = Overrides { seed: arguments.seed, motion: arguments.motion };
        let inputs = Inputs::load(&arguments.scenario, overrides)?;
        if let Some(executed) = &arguments.simulation.executed {
            output_files::check_path(executed)?;
        }
        let id = random_id();
        let description = inputs.description(id);
        let Inputs { scenario, model, world, .. } = inputs;
        let identity = Identity {
            controller_id: id,
            robot: model.digest,
            world: world.digest,
            config: scenario.digest,
        };
        let executed = arguments.simulation.executed.as_deref();
        let disturb_seed = arguments.simulation.disturb;
        let record = executed.map(|path| {
            let (scenario, world) = (scenario.clone(), world.clone());
            Record { path, scenario, world, disturb_seed }
        });
        let (ground_truth, world) = actual_world(arguments, &model, world)?;
        let checker = Checker::new(model, world, scenario.checker)?;
        let mut subscriber = PlanSubscriber::open(&enter_instance(&arguments.instance)?, id)?;
        subscriber.describe(&description)?;
        let ends =
            (scenario.start, Goal { stance: scenario.goal, tolerance: scenario.goal_tolerance });
        let executor = executor(arguments, (checker, identity), ends, &subscriber);
        let SimulationArguments { rate, late, disturb, .. } = arguments.simulation;
        let walk = WalkOptions { rate, late, is_recorded: record.is_some() };
        let mut robot = PacedWalk::new(&subscriber, id, &walk)?;
        robot.take_over(chunks_taken_over(&subscriber, arguments));
        let disturbance = disturb.map(Disturbance::new);
        let mut handler = ChunkHandler::new(executor, ground_truth, disturbance, robot);
        if let Some(feedback) = subscriber.taken_over() {
            handler.mark_reported(feedback.corrections());
        }
        if let Some(seed) = disturb {
            subscriber.inject_faults(seed);
        }
        // A supervisor ends this process; until then a restarted planner may connect.
        let stays = arguments.role.report_lines || arguments.serve;
        let reporter = Reporter::new(arguments.role.report_lines, false);
        let linger_max = (!stays).then_some(LINGER_TIME_MAX);
        Ok(Self { subscriber, handler, record, reporter, linger_max })
    }

    /// Receives, checks and executes plans until the time to linger is over or a signal comes.
    fn run(&mut self) -> Result<CommandOutcome, CommandError> {
        let mut ended = match self.subscriber.stream_end() {
            Some(ended) => {
                self.handler.come_to_rest();
                ended
            }
            None => self.receive()?,
        };
        loop {
            let refusal = match ended {
                StreamEnd::Finished => None,
                StreamEnd::Refused(chunk) => {
                    Some(Refusal::of(chunk, self.handler.detail().to_owned()))
                }
                StreamEnd::PlannerLeft => {
                    self.handler.come_to_rest();
                    let accepted = self.subscriber.feedback().next_sequence;
                    self.reporter.emit(&RoleEvent::Holding { accepted })?;
                    ended = self.receive()?;
                    continue;
                }
                StreamEnd::Stopped => {
                    self.handler.come_to_rest();
                    if self.subscriber.feedback().next_sequence > 0 {
                        self.report(None)?;
                    }
                    return Err(CommandError::interrupted());
                }
            };
            let is_refused = refusal.is_some();
            self.report(refusal)?;
            match self.linger(is_refused)? {
                Some(next) => ended = next,
                None if is_refused => return Ok(CommandOutcome::Refused),
                None => return Ok(CommandOutcome::Done),
            }
        }
    }

    /// Receives chunks until their stream ends.
    fn receive(&mut self) -> Result<StreamEnd, CommandError> {
        let handler = RefCell::new(&mut self.handler);
        Ok(self.subscriber.run_with(&mut SharedHandler(&handler), &|| keep_walking(&handler))?)
    }

    /// Repeats the last feedback. Returns the end of the next stream, if another one comes. After a
    /// refusal it stays while a planner is connected, which may plan again for any time.
    fn linger(&mut self, is_refused: bool) -> Result<Option<StreamEnd>, CommandError> {
        let handler = RefCell::new(&mut self.handler);
        let linger_max = self.linger_max.map(|max| if is_refused { Duration::MAX } else { max });
        Ok(self
            .subscriber
            .linger_with(&mut SharedHandler(&handler), linger_max, &|| keep_walking(&handler))?)
    }

    /// Reports the summary of a plan, and writes the motion as executed so far.
    fn report(&mut self, refusal: Option<Refusal>) -> Result<(), CommandError> {
        self.handler.error()?;
        if let Some(record) = &self.record {
            self.write_executed(record)?;
        }
        let (feedback, stats) = (self.subscriber.feedback(), self.subscriber.stats());
        let checked = self.handler.summary(stats, &feedback, refusal);
        self.reporter.emit(&RoleEvent::Checked(checked.clone()))?;
        self.reporter.print(|| summary(&checked));
        Ok(())
    }

    fn write_executed(&self, record: &Record<'_>) -> Result<(), CommandError> {
        let Record { path, scenario, world, disturb_seed } = record;
        let (model, walked) = (self.handler.model(), self.handler.executed());
        let executed = (&walked[..], *disturb_seed);
        let folder = output_files::plan_folder(path);
        Ok(save(&executed_plan(model, world, scenario, executed, &folder), path)?)
    }
}

/// Checks chunks from the start to the goal of the scenario, from where another controller left the
/// robot, or for a controller that serves, between the stances that each request states.
fn executor(
    arguments: &ControlArguments,
    (checker, identity): (Checker, Identity),
    (start, goal): (StancePose, Goal),
    subscriber: &PlanSubscriber,
) -> ChunkExecutor {
    let executor = match subscriber.taken_over() {
        Some(feedback) => {
            let executor = ChunkExecutor::take_over(checker, identity, feedback);
            executor.going_on_after(chunks_taken_over(subscriber, arguments).0)
        }
        None if arguments.serve => ChunkExecutor::new(checker, identity),
        None => ChunkExecutor::new(checker, identity).starting_at(start),
    };
    if arguments.serve {
        executor.ending_as_stated(goal.tolerance)
    } else {
        executor.ending_at(goal)
    }
}

/// The chunks in which another controller left the robot, and where. Misplaced feet are known to
/// that controller alone: then the robot stands where it reported.
fn chunks_taken_over<'a>(
    subscriber: &'a PlanSubscriber,
    arguments: &ControlArguments,
) -> (&'a [PlanChunk], Option<&'a WalkRecord>) {
    let is_planned = arguments.simulation.disturb.is_none();
    if is_planned { subscriber.chunks_taken_over() } else { (&[], None) }
}

/// Walks on where the robot's time is real time. Whether no signal has asked the process to end.
fn keep_walking(handler: &RefCell<&mut ChunkHandler>) -> bool {
    handler.borrow_mut().catch_up();
    liveness::keep_going()
}

/// The actual world, and its differences from the world that the planner knows.
fn actual_world(
    arguments: &ControlArguments,
    model: &RobotModel,
    known_world: World,
) -> Result<(Option<GroundTruth>, World), CommandError> {
    let Some(path) = &arguments.simulation.ground_truth else { return Ok((None, known_world)) };
    let world = load_world(&world_path(path)?)?;
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
    let so_far = match checked.stops() {
        Some(stops) => format!("{so_far}; {stops}"),
        None => so_far,
    };
    let so_far = match checked.dropped() {
        Some(dropped) => format!("{so_far}; {dropped}"),
        None => so_far,
    };
    match &checked.refusal {
        None => so_far,
        Some(refusal) => format!("{so_far}\nrefused: {}", refusal.describe()),
    }
}
