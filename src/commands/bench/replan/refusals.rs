//! The feedback of a controller that refuses a chunk of a plan, with the robot's rest state.

use bytemuck::Zeroable;
use glam::DVec3;
use surefoot_controller_sim::missing_contact;
use surefoot_shared_types::Pose;
use surefoot_shared_types::message::{Contact, Feedback, PlanChunk, RestState, WorldCorrection};
use surefoot_shared_types::robot::model::RobotModel;

use crate::input::inputs::Inputs;

/// Half of each side of the box that blocks the route, m.
const BOX_HALF_SIDE: f64 = 0.03;
/// Smallest distance of a refused contact from the goal's sole poses, m. A nearer one blocks the
/// goal.
const GOAL_CLEARANCE: f64 = 0.35;

/// A foot that is set down, and the rest states before its lift-off and before its landing.
struct Landing {
    contact: Contact,
    before_swing: RestState,
    before_landing: RestState,
}

/// Words that refuse landings spread over a plan, by turns because nothing carries the sole, which
/// is learnt on one foot just before it lands, and because a box stands there, which is learnt on
/// both feet before the other one is lifted.
pub fn spread(inputs: &Inputs, chunks: &[PlanChunk], refusals: usize) -> Vec<Feedback> {
    let goal = inputs.scenario.goal.world_from_soles();
    let is_free = |landing: &Landing| {
        let there = landing.contact.world_from_sole().translation;
        goal.iter().all(|sole| sole.translation.distance(there) > GOAL_CLEARANCE)
    };
    let landings: Vec<Landing> = landings(chunks).into_iter().filter(is_free).collect();
    let count = refusals.min(landings.len());
    let chosen = (0..count).map(|index| &landings[(2 * index + 1) * landings.len() / (2 * count)]);
    chosen
        .enumerate()
        .map(|(index, landing)| refusal(&inputs.model, landing, index % 2 == 0))
        .collect()
}

fn landings(chunks: &[PlanChunk]) -> Vec<Landing> {
    let (mut rest_state, mut before_swing) = (RestState::zeroed(), RestState::zeroed());
    let mut landings = vec![];
    for pair in chunks.windows(2) {
        let [here, next] = pair else { continue };
        let Some(last) = here.waypoints().last() else { continue };
        rest_state = rest_state.after(here.mode, here.contacts(), last);
        if next.contacts().len() < here.contacts().len() {
            before_swing = rest_state;
        }
        let stands = |limb| here.contacts().iter().any(|contact| contact.limb == limb);
        if let Some(&contact) = next.contacts().iter().find(|contact| !stands(contact.limb)) {
            landings.push(Landing { contact, before_swing, before_landing: rest_state });
        }
    }
    landings
}

fn refusal(model: &RobotModel, landing: &Landing, is_void: bool) -> Feedback {
    let (rest_state, correction) = match is_void {
        true => (landing.before_landing, missing_contact(model, &landing.contact)),
        false => (landing.before_swing, box_on(&landing.contact)),
    };
    let mut feedback =
        Feedback { plan_id: 1, rest_state, corrections_len: 1, ..Feedback::zeroed() };
    feedback.corrections[0] = correction;
    feedback
}

/// A box that stands where a sole should.
fn box_on(contact: &Contact) -> WorldCorrection {
    let world_from_box =
        contact.world_from_sole() * Pose::from_translation(DVec3::Z * BOX_HALF_SIDE);
    WorldCorrection::extra(&world_from_box, [BOX_HALF_SIDE; 3])
}
