//! Execution with misplaced feet.
//!
//! A landing foot stands up to 5 mm and 1 degree off its planned pose, in the plane of its sole.
//! While it stands there, the root moves as planned and the leg's joints are solved for the actual
//! sole. When the foot is lifted, it returns to its planned path. Where that exceeds a joint's
//! acceleration limit, the motion takes longer than planned and the rest of the plan is delayed.
//! The executed motion passes every check of the plan, or the robot holds its position and reports
//! where it stands.

use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{interpolate, rotation_about};
use surefoot_shared_types::message::{Contact, Margins, PlanChunk, SupportMode, Waypoint};

use crate::base::random;
use crate::check::checker::Checker;
use crate::check::course::Course;
use crate::check::segment::MotionSegment;
use crate::execution::executor::ChunkExecutor;
use crate::execution::executor::RestState;
use crate::execution::tuning::{LANDING_ATTEMPTS_MAX, OFFSET_MAX, YAW_MAX};
use crate::kinematics::forward::{Configuration, Posture};
use crate::kinematics::leg_ik::solve_leg_ik;

/// Result of executing an accepted chunk.
#[derive(Debug, Clone, PartialEq)]
pub enum DisturbedExecution {
    /// Executed as this chunk says, with these worst margins.
    Executed(Box<PlanChunk>, Margins),
    /// A foot was set down `LANDING_ATTEMPTS_MAX` times near this contact without support.
    Unsupported(Box<Contact>),
    /// With the actual feet the motion violates a check; one line says which.
    Infeasible(String),
}

/// Misplaces landing feet and stores their actual poses.
#[derive(Debug, Clone)]
pub struct Disturbance {
    seed: u64,
    /// Of each foot the actual pose in its planned sole frame.
    planned_from_actual: [Pose; 2],
    /// How far behind the plan the robot is, s.
    delay: f64,
}

impl Disturbance {
    /// The disturbances of a seed.
    pub fn new(seed: u64) -> Self {
        Self { seed, planned_from_actual: [Pose::IDENTITY; 2], delay: 0.0 }
    }

    /// Executes a chunk that `executor` accepts, with the actual feet. `heartbeat` is called now
    /// and then meanwhile.
    pub fn execute(
        &mut self,
        executor: &mut ChunkExecutor,
        chunk: &PlanChunk,
        heartbeat: &mut dyn FnMut(),
    ) -> DisturbedExecution {
        if chunk.sequence == 0 {
            // A plan begins at the actual rest state.
            (self.planned_from_actual, self.delay) = ([Pose::IDENTITY; 2], 0.0);
        }
        let landing = executor.landing(chunk).copied();
        let attempts = if landing.is_some() { LANDING_ATTEMPTS_MAX } else { 1 };
        let mut last_error = String::new();
        for attempt in 0..attempts {
            let mut feet = self.planned_from_actual;
            if let Some(landing) = &landing {
                feet[landing.limb as usize] = self.landing_offset(chunk, attempt);
            }
            match check_actual(executor, chunk, landing.as_ref(), (&feet, self.delay), heartbeat) {
                Ok((actual, margins)) => {
                    executor.execute_as(chunk, &actual, &margins);
                    self.planned_from_actual = feet_after(chunk, feet);
                    self.delay = end_time(&actual) - end_time(chunk);
                    return DisturbedExecution::Executed(Box::new(actual), margins);
                }
                Err(reason) => last_error = reason,
            }
        }
        landing.map_or(DisturbedExecution::Infeasible(last_error), |contact| {
            DisturbedExecution::Unsupported(Box::new(contact))
        })
    }

    /// Actual pose, in the planned sole frame, of a foot that lands with this chunk.
    fn landing_offset(&self, chunk: &PlanChunk, attempt: u64) -> Pose {
        let random = |index: u64| {
            random::uniform(
                self.seed,
                &[chunk.plan_id, chunk.epoch, chunk.sequence, attempt, index],
            )
        };
        let distance = OFFSET_MAX * random(0).sqrt();
        let (sin, cos) = libm::sincos(std::f64::consts::TAU * random(1));
        let yaw = YAW_MAX * (2.0 * random(2) - 1.0);
        Pose::from_parts(
            glam::DVec3::new(distance * cos, distance * sin, 0.0),
            rotation_about(glam::DVec3::Z, yaw),
        )
    }
}

/// The feet after a chunk: a lifted foot is back on its planned path.
fn feet_after(chunk: &PlanChunk, feet: [Pose; 2]) -> [Pose; 2] {
    [0, 1].map(|limb| if is_in_contact(chunk, limb) { feet[limb] } else { Pose::IDENTITY })
}

fn is_in_contact(chunk: &PlanChunk, limb: usize) -> bool {
    chunk.contacts().iter().any(|contact| contact.limb as usize == limb)
}

/// Checks a chunk with its actual feet: the chunk to execute, or why it cannot be executed.
fn check_actual(
    executor: &mut ChunkExecutor,
    chunk: &PlanChunk,
    landing: Option<&Contact>,
    (feet, delay): (&[Pose; 2], f64),
    heartbeat: &mut dyn FnMut(),
) -> Result<(PlanChunk, Margins), String> {
    let mut actual = actual_chunk(executor.checker(), chunk, feet)?;
    delay_motion(executor.checker(), &mut actual, delay);
    let mode = SupportMode::from_wire(chunk.mode).ok_or("no mode")?;
    if landing.is_some() {
        check_slide(executor, &actual, heartbeat)?;
    }
    let segment = MotionSegment {
        mode,
        contacts: actual.contacts(),
        waypoints: actual.waypoints(),
        course: Course::Straight,
    };
    let margins =
        executor.check_motion(&segment, heartbeat).map_err(|violation| violation.to_string())?;
    Ok((actual, margins))
}

/// Delays a motion by `delay` (s), and has it take as long as the joints need.
fn delay_motion(checker: &Checker, actual: &mut PlanChunk, delay: f64) {
    let time_scale_min = checker.time_scale_min(actual.waypoints());
    let begin = actual.waypoints[0].time;
    for waypoint in &mut actual.waypoints[..actual.waypoints_len as usize] {
        waypoint.time = delay + begin + time_scale_min * (waypoint.time - begin);
    }
    actual.brake_at = end_time(actual);
}

/// When the last waypoint of a chunk is reached, s.
fn end_time(chunk: &PlanChunk) -> f64 {
    chunk.waypoints().last().map_or(0.0, |waypoint| waypoint.time)
}

/// Whether the landing foot may slide from its planned place to where it comes to rest.
fn check_slide(
    executor: &mut ChunkExecutor,
    actual: &PlanChunk,
    heartbeat: &mut dyn FnMut(),
) -> Result<(), String> {
    let Some(RestState { waypoint, mode, contacts }) = executor.actual_rest_state().cloned() else {
        return Ok(());
    };
    let end = Waypoint { time: waypoint.time + 1.0, ..actual.waypoints()[0] };
    let slide = MotionSegment {
        mode,
        contacts: &contacts,
        waypoints: &[waypoint, end],
        course: Course::Straight,
    };
    executor.check_motion(&slide, heartbeat).map(drop).map_err(|violation| violation.to_string())
}

/// The chunk with its actual feet.
fn actual_chunk(
    checker: &Checker,
    chunk: &PlanChunk,
    feet: &[Pose; 2],
) -> Result<PlanChunk, String> {
    let mut actual = *chunk;
    let moved = (0..2).filter(|&limb| feet[limb] != Pose::IDENTITY);
    for limb in moved {
        let planned_from_actual = &feet[limb];
        let contact = actual
            .contacts
            .iter_mut()
            .take(chunk.contacts_len as usize)
            .find(|contact| contact.limb as usize == limb);
        let world_from_stance_sole = contact.map(|contact| {
            let pose = contact.world_from_sole() * *planned_from_actual;
            contact.position = pose.translation.to_array();
            contact.rotation = pose.rotation.normalize().to_array();
            contact.world_from_sole()
        });
        let (begin, end) = (chunk.waypoints[0].time, end_time(chunk));
        for waypoint in &mut actual.waypoints[..chunk.waypoints_len as usize] {
            let fraction = if end > begin { (waypoint.time - begin) / (end - begin) } else { 0.0 };
            // From its stance to its planned path with zero velocity at both ends.
            let remaining = 1.0 - fraction * fraction * (3.0 - 2.0 * fraction);
            let swinging = |planned: Pose| {
                planned * interpolate(&Pose::IDENTITY, planned_from_actual, remaining)
            };
            move_foot(checker, waypoint, limb, |planned| {
                world_from_stance_sole.unwrap_or_else(|| swinging(planned))
            })?;
        }
    }
    Ok(actual)
}

fn move_foot(
    checker: &Checker,
    waypoint: &mut Waypoint,
    limb: usize,
    target: impl Fn(Pose) -> Pose,
) -> Result<(), String> {
    let model = checker.model();
    let mut configuration = Configuration::of_waypoint(waypoint, model.joints.len());
    let planned = Posture::new(model, &configuration).world_from_sole(model, limb);
    if !solve_leg_ik(model, &mut configuration, limb, &target(planned)) {
        return Err(format!("the leg of foot {limb} does not reach its actual pose"));
    }
    waypoint.q.iter_mut().zip(configuration.q).for_each(|(slot, position)| *slot = position);
    Ok(())
}
