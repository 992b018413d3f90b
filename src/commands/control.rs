//! `surefoot control`: checks and walks the plan that arrives in an instance. Also the controller
//! process of a walk.

mod judge;
mod simulated;

use std::time::Duration;

use surefoot_controller_sim::channel::{ChunkReceiver, Ended};
use surefoot_controller_sim::{Checker, CheckerError, Disturbance, Identity, Truth, Walker};
use surefoot_shared_types::instance::draw_id;
use surefoot_shared_types::robot::RobotModel;
use surefoot_shared_types::scene::World;
use surefoot_shared_types::scene::load::load_world;

use self::judge::Judge;
use self::simulated::Simulated;
use super::{enter, settle};
use crate::arguments::ControlArguments;
use crate::audience::Audience;
use crate::failure::{Ending, Failure};
use crate::inputs::Inputs;
use crate::line::{Judged, Line, Refusal};
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
    let identity = Identity {
        instance: id,
        robot: model.digest,
        world: world.digest,
        config: scenario.digest,
    };
    let (truth, world) = true_world(arguments, &model, world)?;
    let checker = Checker::new(model, world, scenario.checker)?;
    let mut receiver = ChunkReceiver::open(&enter(&arguments.instance)?, id)?;
    let walker = match receiver.taken_over() {
        Some(word) => Walker::take_over(checker, identity, word),
        None => Walker::new(checker, identity),
    };
    let simulated = arguments.rate.map(|rate| Simulated::new(&receiver, id, rate)).transpose()?;
    let mut judge = Judge::new(walker, truth, arguments.disturb.map(Disturbance::new), simulated);
    if let Some(word) = receiver.taken_over() {
        judge.pass_over(word.corrections());
    }
    if let Some(seed) = arguments.disturb {
        receiver.disturb_words(seed);
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
            Ended::Refused(chunk) => Some(Refusal::of(chunk, judge.detail().to_owned())),
            Ended::Left => {
                audience.tell(&Line::Holding { accepted: receiver.feedback().next_sequence })?;
                ended = receiver.run(&mut |chunk, alive| judge.judge(chunk, alive), &keep_going)?;
                continue;
            }
            Ended::Stopped => {
                return Err(Failure::Interrupted(signals::raised().unwrap_or(libc::SIGTERM)));
            }
        };
        judge.failure()?;
        let judged = judge.conclude(receiver.tally().duplicates, refusal);
        audience.tell(&Line::Judged(judged.clone()))?;
        audience.say(|| verdict(&judged));
        match receiver.linger(
            &mut |chunk, alive| judge.judge(chunk, alive),
            longest,
            &keep_going,
        )? {
            Some(next) => ended = next,
            None => {
                return Ok(if judged.refusal.is_some() { Ending::Refused } else { Ending::Done });
            }
        }
    }
}

/// The world in which the robot really walks, and what of it the planner does not know.
fn true_world(
    arguments: &ControlArguments,
    model: &RobotModel,
    belief: World,
) -> Result<(Option<Truth>, World), Failure> {
    let Some(path) = &arguments.truth else { return Ok((None, belief)) };
    let world = load_world(path)?;
    let truth = Truth::new(model, &belief, &world).map_err(CheckerError::Shape)?;
    Ok((Some(truth), world))
}

fn verdict(judged: &Judged) -> String {
    let so_far = format!(
        "{} chunks walked and accepted; margins: {}",
        judged.accepted,
        judged.margins.describe()
    );
    match &judged.refusal {
        None => so_far,
        Some(refusal) => format!("{so_far}\nrefused: {}", refusal.describe()),
    }
}
