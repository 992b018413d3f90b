//! Feet that come down elsewhere than planned, and a robot that goes on all the same.
//!
//! When a foot lands, it stands up to 5 mm and 1 degree off, in the plane of its sole. As long as
//! it stands there, the leg makes up for it: the root moves as planned, and the leg's joints reach
//! the sole where it really is. When the foot is lifted, it goes back to its planned way. Where
//! that asks too much of a joint, it takes longer than planned, and what follows is as late. What
//! is so walked passes every check of the plan, or the robot holds and says where it stands.

use surefoot_shared_types::Pose;
use surefoot_shared_types::message::{Contact, Margins, PlanChunk, SupportMode, Waypoint};
use surefoot_shared_types::spatial::{interpolate, rotation_about};

use crate::Walker;
use crate::check::{Checker, Segment};
use crate::draw;
use crate::kinematics::{Configuration, Posture};
use crate::leg::reach;
use crate::walk::Standing;

/// A foot comes down at most so far from its place, m.
const OFF_MAX: f64 = 0.005;
/// A foot comes down turned by at most so much, rad.
const TURN_MAX: f64 = 1.0 / 180.0 * std::f64::consts::PI;
/// How often a foot is set down where what carries it does not do.
const LANDINGS_MAX: u64 = 4;

/// What became of an admitted chunk.
#[derive(Debug, Clone, PartialEq)]
pub enum Walked {
    /// Walked, in this way, with these worst margins.
    As(Box<PlanChunk>, Margins),
    /// A foot was set down `LANDINGS_MAX` times near this contact, and nothing carried it.
    NothingCarries(Box<Contact>),
    /// As the feet stand, the motion does not pass a check; one line says which.
    DoesNotFit(String),
}

/// Misplaces feet, and knows where they really are.
#[derive(Debug, Clone)]
pub struct Disturbance {
    seed: u64,
    /// Of each foot, from where it was to be to where it is, in its sole frame.
    planned_from_real: [Pose; 2],
    /// How far behind the plan the robot is, s.
    late: f64,
}

impl Disturbance {
    /// The disturbances of a seed.
    pub fn new(seed: u64) -> Self {
        Self { seed, planned_from_real: [Pose::IDENTITY; 2], late: 0.0 }
    }

    /// Walks a chunk that `walker` has admitted, as the feet really stand. `alive` is called now
    /// and then meanwhile.
    pub fn walk(
        &mut self,
        walker: &mut Walker,
        chunk: &PlanChunk,
        alive: &mut dyn FnMut(),
    ) -> Walked {
        if chunk.sequence == 0 {
            // A plan begins where the robot really stands.
            (self.planned_from_real, self.late) = ([Pose::IDENTITY; 2], 0.0);
        }
        let landing = walker.landing(chunk).copied();
        let tries = if landing.is_some() { LANDINGS_MAX } else { 1 };
        let mut why = String::new();
        for attempt in 0..tries {
            let mut feet = self.planned_from_real;
            if let Some(landing) = &landing {
                feet[landing.limb as usize] = self.misplaced(chunk, attempt);
            }
            match walk_really(walker, chunk, landing.as_ref(), (&feet, self.late), alive) {
                Ok((real, margins)) => {
                    walker.walk_as(chunk, &real, &margins);
                    self.planned_from_real = after(chunk, feet);
                    self.late = end_of(&real) - end_of(chunk);
                    return Walked::As(Box::new(real), margins);
                }
                Err(reason) => why = reason,
            }
        }
        landing.map_or(Walked::DoesNotFit(why), |contact| Walked::NothingCarries(Box::new(contact)))
    }

    /// Where a foot comes down that lands with this chunk.
    fn misplaced(&self, chunk: &PlanChunk, attempt: u64) -> Pose {
        let draw = |what: u64| {
            draw::unit(self.seed, &[chunk.plan_id, chunk.epoch, chunk.sequence, attempt, what])
        };
        let off = OFF_MAX * draw(0).sqrt();
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * draw(1));
        let turn = TURN_MAX * (2.0 * draw(2) - 1.0);
        Pose::from_parts(
            glam::DVec3::new(off * cos, off * sin, 0.0),
            rotation_about(glam::DVec3::Z, turn),
        )
    }
}

/// A lifted foot is back on its planned way at the end of the chunk.
fn after(chunk: &PlanChunk, feet: [Pose; 2]) -> [Pose; 2] {
    [0, 1].map(|limb| if stands(chunk, limb) { feet[limb] } else { Pose::IDENTITY })
}

fn stands(chunk: &PlanChunk, limb: usize) -> bool {
    chunk.contacts().iter().any(|contact| contact.limb as usize == limb)
}

/// Walks a chunk with its feet where they really are; the chunk as it was walked, or why it cannot
/// be.
fn walk_really(
    walker: &mut Walker,
    chunk: &PlanChunk,
    landing: Option<&Contact>,
    (feet, late): (&[Pose; 2], f64),
    alive: &mut dyn FnMut(),
) -> Result<(PlanChunk, Margins), String> {
    let mut real = really(walker.checker(), chunk, feet)?;
    slow_down(walker.checker(), &mut real, late);
    let mode = SupportMode::from_wire(chunk.mode).ok_or("no mode")?;
    if landing.is_some() {
        check_slide(walker, &real, alive)?;
    }
    let segment = Segment { mode, contacts: real.contacts(), waypoints: real.waypoints() };
    let margins = walker.check(&segment, alive).map_err(|violation| violation.to_string())?;
    Ok((real, margins))
}

/// Delays a motion by `late` (s), and has it take as long as the joints need.
fn slow_down(checker: &Checker, real: &mut PlanChunk, late: f64) {
    let slower_by = checker.slower_by(real.waypoints());
    let begin = real.waypoints[0].time;
    for waypoint in &mut real.waypoints[..real.waypoints_len as usize] {
        waypoint.time = late + begin + slower_by * (waypoint.time - begin);
    }
}

/// When the last waypoint of a chunk is reached, s.
fn end_of(chunk: &PlanChunk) -> f64 {
    chunk.waypoints().last().map_or(0.0, |waypoint| waypoint.time)
}

/// Whether the landing foot may slide from its planned place to where it comes to rest.
fn check_slide(
    walker: &mut Walker,
    real: &PlanChunk,
    alive: &mut dyn FnMut(),
) -> Result<(), String> {
    let Some(Standing { waypoint, mode, contacts }) = walker.really_standing().cloned() else {
        return Ok(());
    };
    let end = Waypoint { time: waypoint.time + 1.0, ..real.waypoints()[0] };
    let slide = Segment { mode, contacts: &contacts, waypoints: &[waypoint, end] };
    walker.check(&slide, alive).map(drop).map_err(|violation| violation.to_string())
}

/// The chunk with its feet where they really are.
fn really(checker: &Checker, chunk: &PlanChunk, feet: &[Pose; 2]) -> Result<PlanChunk, String> {
    let mut real = *chunk;
    let moved = (0..2).filter(|&limb| feet[limb] != Pose::IDENTITY);
    for limb in moved {
        let planned_from_real = &feet[limb];
        let contact = real
            .contacts
            .iter_mut()
            .take(chunk.contacts_len as usize)
            .find(|contact| contact.limb as usize == limb);
        let standing_at = contact.map(|contact| {
            let pose = contact.world_from_sole() * *planned_from_real;
            contact.position = pose.translation.to_array();
            contact.rotation = pose.rotation.normalize().to_array();
            contact.world_from_sole()
        });
        let (begin, end) = (chunk.waypoints[0].time, end_of(chunk));
        for waypoint in &mut real.waypoints[..chunk.waypoints_len as usize] {
            let share = if end > begin { (waypoint.time - begin) / (end - begin) } else { 0.0 };
            // It leaves where it stood and joins its planned way without a jerk.
            let left = 1.0 - share * share * (3.0 - 2.0 * share);
            let swinging =
                |planned: Pose| planned * interpolate(&Pose::IDENTITY, planned_from_real, left);
            place_foot(checker, waypoint, limb, |planned| {
                standing_at.unwrap_or_else(|| swinging(planned))
            })?;
        }
    }
    Ok(real)
}

fn place_foot(
    checker: &Checker,
    waypoint: &mut Waypoint,
    limb: usize,
    wanted: impl Fn(Pose) -> Pose,
) -> Result<(), String> {
    let model = checker.model();
    let mut configuration = Configuration::of_waypoint(waypoint, model.joints.len());
    let planned = Posture::new(model, &configuration).world_from_sole(model, limb);
    if !reach(model, &mut configuration, limb, &wanted(planned)) {
        return Err(format!("the leg of foot {limb} does not reach where it really is"));
    }
    waypoint.q.iter_mut().zip(configuration.q).for_each(|(slot, position)| *slot = position);
    Ok(())
}
