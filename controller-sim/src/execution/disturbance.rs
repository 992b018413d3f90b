//! Execution with misplaced feet.
//!
//! A landing foot stands up to 5 mm and 1 degree off its planned pose, in the plane of its sole.
//! While it stands there, the root moves as planned and the leg's joints are solved for the actual
//! sole. When the foot is lifted, it returns to its planned path. Where straight lines exceed a
//! joint's acceleration limit, the motion takes longer than planned and the rest of the plan is
//! delayed; a smooth motion keeps its times. The executed motion passes every check of the plan, or
//! the robot brakes and reports where it stands.

use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::rotation_about;
use surefoot_shared_types::message::{Check, Contact, Margins, PlanChunk, SupportMode, Waypoint};

use crate::base::random;
use crate::check::checker::Checker;
use crate::check::course::Course;
use crate::check::segment::{MotionSegment, Violation};
use crate::execution::actual_motion::{actual_chunk, end_time, is_in_contact};
use crate::execution::executor::ChunkExecutor;
use crate::execution::executor::RestState;
use crate::execution::recent_chunks::RecentChunks;
use crate::execution::tuning::{LANDING_ATTEMPTS_MAX, OFFSET_MAX, YAW_MAX};

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

/// Why a chunk cannot be executed with the actual feet.
struct Infeasible {
    /// Whether a landing foot finds no support.
    lacks_support: bool,
    /// One line that says why.
    detail: String,
}

/// Misplaces landing feet and stores their actual poses.
#[derive(Debug, Clone)]
pub struct Disturbance {
    seed: u64,
    /// Of each foot the actual pose in its planned sole frame.
    planned_from_actual: [Pose; 2],
    /// How far behind the plan the robot is, s.
    delay: f64,
    /// The last executed chunks of a smooth plan.
    recent: RecentChunks,
}

impl Disturbance {
    /// The disturbances of a seed.
    pub fn new(seed: u64) -> Self {
        Self {
            seed,
            planned_from_actual: [Pose::IDENTITY; 2],
            delay: 0.0,
            recent: RecentChunks::default(),
        }
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
            *self = Self::new(self.seed);
        }
        let landing = executor.landing(chunk).copied();
        let attempts = if landing.is_some() { LANDING_ATTEMPTS_MAX } else { 1 };
        let mut last_error = Infeasible { lacks_support: false, detail: String::new() };
        for attempt in 0..attempts {
            let mut feet = self.planned_from_actual;
            if let Some(landing) = &landing {
                feet[landing.limb as usize] = self.landing_offset(chunk, attempt);
            }
            match self.check_actual(executor, chunk, landing.as_ref(), &feet, heartbeat) {
                Ok((actual, margins)) => {
                    executor.execute_as(chunk, &actual, &margins);
                    self.planned_from_actual = feet_after(chunk, feet);
                    self.delay = end_time(&actual) - end_time(chunk);
                    let mode = SupportMode::from_wire(actual.mode);
                    if let Some(mode) = mode.filter(|_| actual.is_smooth()) {
                        self.recent.add(mode, &actual);
                    }
                    return DisturbedExecution::Executed(Box::new(actual), margins);
                }
                Err(reason) => last_error = reason,
            }
        }
        match landing {
            Some(contact) if last_error.lacks_support => {
                DisturbedExecution::Unsupported(Box::new(contact))
            }
            _ => DisturbedExecution::Infeasible(last_error.detail),
        }
    }

    /// Checks a chunk with its actual feet: the chunk to execute, or why it cannot be executed.
    fn check_actual(
        &self,
        executor: &mut ChunkExecutor,
        chunk: &PlanChunk,
        landing: Option<&Contact>,
        feet: &[Pose; 2],
        heartbeat: &mut dyn FnMut(),
    ) -> Result<(PlanChunk, Margins), Infeasible> {
        let detail = |detail| Infeasible { lacks_support: landing.is_some(), detail };
        let mut actual = actual_chunk(executor.checker(), chunk, feet).map_err(detail)?;
        if !chunk.is_smooth() {
            delay_motion(executor.checker(), &mut actual, self.delay);
        }
        let mode = SupportMode::from_wire(chunk.mode).ok_or_else(|| detail("no mode".into()))?;
        let infeasible = |violation: Violation| Infeasible {
            // Straight lines pass the other checks of a landing if they are slow enough.
            lacks_support: landing.is_some()
                && (!chunk.is_smooth() || violation.check == Check::Contact),
            detail: violation.to_string(),
        };
        if landing.is_some() {
            self.check_slide(executor, &actual, heartbeat).map_err(infeasible)?;
        }
        let margins = if chunk.is_smooth() {
            self.recent.check_next(executor.checker_mut(), (mode, &actual), heartbeat)
        } else {
            let (contacts, waypoints) = (actual.contacts(), actual.waypoints());
            let segment = MotionSegment { mode, contacts, waypoints, course: Course::Straight };
            executor.check_motion(&segment, heartbeat)
        };
        Ok((actual, margins.map_err(infeasible)?))
    }

    /// Whether the landing foot may slide from its planned place to where it comes to rest.
    fn check_slide(
        &self,
        executor: &mut ChunkExecutor,
        actual: &PlanChunk,
        heartbeat: &mut dyn FnMut(),
    ) -> Result<(), Violation> {
        let Some(RestState { waypoint, mode, contacts }) = executor.actual_rest_state().cloned()
        else {
            return Ok(());
        };
        let waypoint = self.recent.last_waypoint().map_or(waypoint, Waypoint::rested);
        let end = Waypoint { time: waypoint.time + 1.0, ..actual.waypoints()[0].rested() };
        let slide = MotionSegment {
            mode,
            contacts: &contacts,
            waypoints: &[waypoint, end],
            course: Course::Straight,
        };
        executor.check_motion(&slide, heartbeat).map(drop)
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

/// Delays a motion by `delay` (s), and has it take as long as the joints need.
fn delay_motion(checker: &Checker, actual: &mut PlanChunk, delay: f64) {
    let time_scale_min = checker.time_scale_min(actual.waypoints());
    let begin = actual.waypoints[0].time;
    for waypoint in &mut actual.waypoints[..actual.waypoints_len as usize] {
        waypoint.time = delay + begin + time_scale_min * (waypoint.time - begin);
    }
    actual.brake_at = end_time(actual);
}
