//! `surefoot control`: checks and walks the plan that arrives in an instance. Also the controller process of a walk.

mod simulated;

use std::time::Duration;

use surefoot_controller_sim::channel::{ChannelError, ChunkReceiver, Ended, Judgement};
use surefoot_controller_sim::{Checker, CheckerError, Identity, Truth, Violation, Walker};
use surefoot_shared_types::instance::draw_id;
use surefoot_shared_types::message::{Check, PlanChunk};
use surefoot_shared_types::robot::RobotModel;
use surefoot_shared_types::scene::World;
use surefoot_shared_types::scene::load::load_world;

use self::simulated::Simulated;
use super::{enter, settle};
use crate::arguments::ControlArguments;
use crate::audience::Audience;
use crate::clock::Stopwatch;
use crate::failure::{Ending, Failure};
use crate::inputs::Inputs;
use crate::line::{Judged, Line, Refusal};
use crate::margins::WorstMargins;
use crate::signals;

/// How long the last word is repeated for a planner that does not leave.
const LINGER: Duration = Duration::from_secs(10);

/// Runs the command.
///
/// # Errors
/// When an input cannot be used, the transport fails, or a signal comes.
pub fn run(arguments: &ControlArguments) -> Result<Ending, Failure> {
    settle(&arguments.role);
    let Inputs { scenario, model, world } = Inputs::load(&arguments.scenario, arguments.seed)?;
    let mut audience = Audience::new(arguments.role.report_lines, false);
    let id = draw_id();
    let identity = Identity { instance: id, robot: model.digest, world: world.digest, config: scenario.digest };
    let (truth, world) = true_world(arguments, &model, world)?;
    let checker = Checker::new(model, world, scenario.checker)?;
    let mut receiver = ChunkReceiver::open(&enter(&arguments.instance)?, id)?;
    let walker = match receiver.taken_over() {
        Some(word) => Walker::take_over(checker, identity, word),
        None => Walker::new(checker, identity),
    };
    let simulated = arguments.rate.map(|rate| Simulated::new(&receiver, id, rate)).transpose()?;
    let mut judge = Judge { walker, truth, simulated, failed: Ok(()), seconds: 0.0, detail: String::new() };
    if let (Some(truth), Some(word)) = (&mut judge.truth, receiver.taken_over()) {
        truth.pass_over(word.corrections());
    }
    audience.tell(&Line::ControllerReady)?;
    let keep_going = || signals::raised().is_none();
    let mut ended = match receiver.ended() {
        Some(ended) => ended,
        None => receiver.run(&mut |chunk, alive| judge.judge(chunk, alive), &keep_going)?,
    };
    // A supervisor says when all is over, and until then a restarted planner may ask again.
    let longest = (!arguments.role.report_lines && !arguments.serve).then_some(LINGER);
    loop {
        let refusal = match ended {
            Ended::Finished => None,
            Ended::Refused(chunk) => Some(Refusal::of(chunk, judge.detail.clone())),
            Ended::Left => {
                audience.tell(&Line::Holding { accepted: receiver.feedback().next_sequence })?;
                ended = receiver.run(&mut |chunk, alive| judge.judge(chunk, alive), &keep_going)?;
                continue;
            }
            Ended::Stopped => return Err(Failure::Interrupted(signals::raised().unwrap_or(libc::SIGTERM))),
        };
        std::mem::replace(&mut judge.failed, Ok(()))?;
        let judged = judge.conclude(receiver.tally().duplicates, refusal);
        audience.tell(&Line::Judged(judged.clone()))?;
        audience.say(|| verdict(&judged));
        match receiver.linger(&mut |chunk, alive| judge.judge(chunk, alive), longest, &keep_going)? {
            Some(next) => ended = next,
            None => return Ok(if judged.refusal.is_some() { Ending::Refused } else { Ending::Done }),
        }
    }
}

/// Judges chunks and remembers what it took.
struct Judge {
    walker: Walker,
    truth: Option<Truth>,
    simulated: Option<Simulated>,
    /// Why the simulation can tell nothing more.
    failed: Result<(), ChannelError>,
    seconds: f64,
    detail: String,
}

impl Judge {
    fn judge(&mut self, chunk: &PlanChunk, alive: &mut dyn FnMut()) -> Judgement {
        let watch = Stopwatch::start();
        let judgement = match self.walker.admit_and_walk(chunk) {
            Ok(margins) => Judgement::Accepted(margins),
            Err(violation) => self.refuse(chunk, violation),
        };
        self.seconds += watch.seconds();
        if let (Judgement::Accepted(_), Some(simulated), Ok(())) = (&judgement, &mut self.simulated, &self.failed) {
            self.failed = simulated.walk(&mut self.walker, chunk, alive);
        }
        judgement
    }

    /// A refusal, for its own reason or because the world is another: then what was met is part of the world from now on.
    fn refuse(&mut self, chunk: &PlanChunk, violation: Violation) -> Judgement {
        let waypoint = violation.waypoint as u32;
        let correction = self.truth.as_mut().and_then(|truth| truth.met(&self.walker, chunk, &violation));
        let check = if correction.is_some() { Check::WorldDiffers } else { violation.check };
        self.detail = violation.detail;
        if let Some(correction) = &correction {
            self.walker.correct(correction);
        }
        Judgement::Refused { check, waypoint, correction }
    }

    fn conclude(&self, duplicated: u64, refusal: Option<Refusal>) -> Judged {
        let margins = WorstMargins::from(&self.walker.margins());
        Judged { check_seconds: self.seconds, accepted: self.walker.next_sequence(), duplicated, margins, refusal }
    }
}

/// The world in which the robot really walks, and what of it the planner does not know.
fn true_world(arguments: &ControlArguments, model: &RobotModel, belief: World) -> Result<(Option<Truth>, World), Failure> {
    let Some(path) = &arguments.truth else { return Ok((None, belief)) };
    let world = load_world(path)?;
    let truth = Truth::new(model, &belief, &world).map_err(CheckerError::Shape)?;
    Ok((Some(truth), world))
}

fn verdict(judged: &Judged) -> String {
    let so_far = format!("{} chunks walked and accepted; margins: {}", judged.accepted, judged.margins.describe());
    match &judged.refusal {
        None => so_far,
        Some(refusal) => format!("{so_far}\nrefused: {}", refusal.describe()),
    }
}
