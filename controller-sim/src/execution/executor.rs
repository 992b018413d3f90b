//! Executes received chunks: checks a chunk from its bytes to its physics and moves the robot.
//!
//! The robot stands in a statically stable configuration. A chunk passes the stages of `STAGES`
//! in their order. One that passes all of them moves the robot to the chunk's end; any other leaves
//! the robot where it stands, so a refusal is always safe.

use std::cmp::Ordering;

use surefoot_shared_types::Pose;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::config::scenario::{GoalTolerance, StancePose};
use surefoot_shared_types::message::Margins;
use surefoot_shared_types::message::chunk::{FLAG_FIRST, FLAG_LAST};
use surefoot_shared_types::message::{
    Check, Contact, Feedback, PlanChunk, SupportMode, Waypoint, WorldCorrection,
};
use surefoot_shared_types::world::correction::corrected_digest;

use crate::base::comparison::{is_at_most, largest};
use crate::check::checker::Checker;
use crate::check::course::{Course, Stop, is_resting};
use crate::check::segment::{MotionSegment, Violation};
use crate::chunk::continuity::{Stance, check_transition, stance_limbs};
use crate::chunk::message_check::{Identity, check_identity, check_message};
use crate::execution::plan_ends::{Goal, KnownGoal, PlanEnds};
use crate::execution::recent_chunks::RecentChunks;

/// How far the first waypoint of a chunk may be from the configuration in which the robot stands,
/// in any number.
const CONTINUITY_MAX: f64 = 1e-9;

/// A stage of the checks on a chunk. No stage uses content that an earlier one has not checked.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Stage {
    /// The bytes are undamaged and the form is sound.
    Message,
    /// Made for this controller, robot, world and scenario.
    Identity,
    /// The next chunk of its plan, and of the accepted stream.
    Stream,
    /// Begins where and when the robot stands, by a legal change of contacts.
    Continuity,
    /// The physical checks of the motion.
    Physics,
}

/// The stages in their order; execution follows them.
const STAGES: [Stage; 5] =
    [Stage::Message, Stage::Identity, Stage::Stream, Stage::Continuity, Stage::Physics];

/// The simulated robot and its progress in the plan that it executes.
pub struct ChunkExecutor {
    checker: Checker,
    identity: Identity,
    /// Where the first chunk must begin and the last one end, as far as it is known.
    ends: PlanEnds,
    plan: Option<(u64, u64)>,
    next_sequence: u64,
    stream: Digest,
    finished: bool,
    /// The rest state of the plan.
    rest_state: Option<RestState>,
    /// The last accepted chunks of the plan: a smooth plan goes on without a rest.
    recent: RecentChunks,
    /// The swing foot that touches the world at the end of the last chunk, and the pose in which
    /// its sole began to.
    touch: Option<(usize, Pose)>,
    /// The actual rest state, if the feet were misplaced.
    actual: Option<RestState>,
    margins: Margins,
}

/// A statically stable configuration with its contacts.
#[derive(Debug, Clone, PartialEq)]
pub struct RestState {
    /// The configuration, and the plan's time at which it was reached.
    pub waypoint: Waypoint,
    /// The feet that carry the robot.
    pub mode: SupportMode,
    /// The contacts of these feet.
    pub contacts: Vec<Contact>,
}

impl RestState {
    /// Where the robot rests after a chunk of a known mode.
    fn after(chunk: &PlanChunk) -> Self {
        Self {
            waypoint: Stop::rest(chunk),
            mode: mode_of(chunk),
            contacts: chunk.contacts().to_vec(),
        }
    }

    /// A foot that stays keeps the pose at which it was set down, so that the deviation allowed
    /// from one chunk to the next does not add up.
    fn keep_contacts_of(&mut self, before: Option<&Self>) {
        for old in before.iter().flat_map(|before| &before.contacts) {
            if let Some(new) = self.contacts.iter_mut().find(|new| new.limb == old.limb) {
                *new = *old;
            }
        }
    }
}

impl ChunkExecutor {
    /// A robot without a rest state yet; the first chunk sets it.
    pub fn new(checker: Checker, identity: Identity) -> Self {
        Self {
            checker,
            identity,
            ends: PlanEnds::default(),
            plan: None,
            next_sequence: 0,
            stream: Digest::default(),
            finished: false,
            rest_state: None,
            recent: RecentChunks::default(),
            touch: None,
            actual: None,
            margins: Margins::UNMEASURED,
        }
    }

    /// The same robot, whose first chunk must begin at this stance.
    pub fn starting_at(self, start: StancePose) -> Self {
        Self { ends: PlanEnds { start: Some(start), ..self.ends }, ..self }
    }

    /// The same robot, whose plans must end at this goal.
    pub fn ending_at(self, goal: Goal) -> Self {
        Self { ends: PlanEnds { goal: KnownGoal::Same(goal), ..self.ends }, ..self }
    }

    /// The same robot, each of whose plans must end at the goal that its last chunk states.
    pub fn ending_as_stated(self, tolerance: GoalTolerance) -> Self {
        Self { ends: PlanEnds { goal: KnownGoal::Stated(tolerance), ..self.ends }, ..self }
    }

    /// A robot that another controller moved before; `feedback` is the last one that it published.
    pub fn take_over(checker: Checker, identity: Identity, feedback: &Feedback) -> Self {
        let rest_state = &feedback.rest_state;
        let limbs = SupportMode::from_wire(rest_state.mode).map(|mode| (mode, stance_limbs(mode)));
        let contacts = |limbs: &[u32]| {
            limbs.iter().filter_map(|&limb| rest_state.contact_of(limb)).copied().collect()
        };
        let world = corrected_digest(&identity.world, feedback.corrections());
        Self {
            checker,
            identity: Identity { world, ..identity },
            ends: PlanEnds::default(),
            plan: (feedback.session != 0).then_some((feedback.plan_id, feedback.epoch)),
            next_sequence: feedback.next_sequence,
            stream: feedback.stream,
            finished: feedback.finished != 0,
            rest_state: limbs.filter(|_| rest_state.is_known()).map(|(mode, limbs)| RestState {
                waypoint: rest_state.waypoint,
                mode,
                contacts: contacts(limbs),
            }),
            recent: RecentChunks::default(),
            touch: None,
            actual: None,
            margins: feedback.margins,
        }
    }

    /// The same robot, whose plan goes on after these chunks, the last ones that it has accepted.
    pub fn going_on_after(mut self, chunks: &[PlanChunk]) -> Self {
        chunks.iter().for_each(|chunk| self.recent.add(mode_of(chunk), chunk));
        self
    }

    /// From now on expects chunks made for the world with `correction` applied. To be called with
    /// every correction that is reported to the planner.
    pub fn correct(&mut self, correction: &WorldCorrection) {
        self.identity.world = corrected_digest(&self.identity.world, &[*correction]);
    }

    /// Checks a chunk and executes it. Returns its worst margins.
    ///
    /// # Errors
    /// The first condition that does not hold; the robot stays where it stands.
    pub fn check_and_execute(&mut self, chunk: &PlanChunk) -> Result<Margins, Violation> {
        let margins = self.check_chunk(chunk, &mut || {})?;
        self.execute(chunk, &margins);
        Ok(margins)
    }

    /// As [`Self::check_and_execute`], but the robot does not move. `heartbeat` is called now and
    /// then meanwhile.
    ///
    /// # Errors
    /// The first condition that does not hold, in the order of `STAGES`.
    pub fn check_chunk(
        &mut self,
        chunk: &PlanChunk,
        heartbeat: &mut dyn FnMut(),
    ) -> Result<Margins, Violation> {
        let mut margins = Margins::UNMEASURED;
        for stage in STAGES {
            margins = margins.min(&self.step(stage, chunk, heartbeat)?);
        }
        Ok(margins)
    }

    /// Checks one stage of a chunk that has passed the stages before it. Returns the margins that
    /// the stage measures.
    fn step(
        &mut self,
        stage: Stage,
        chunk: &PlanChunk,
        heartbeat: &mut dyn FnMut(),
    ) -> Result<Margins, Violation> {
        match stage {
            Stage::Message => {
                check_message(chunk, self.checker.model().joints.len())?;
            }
            Stage::Identity => check_identity(chunk, &self.identity)?,
            Stage::Stream => self.check_stream(chunk)?,
            Stage::Continuity => self.check_continuity(chunk, mode_of(chunk))?,
            Stage::Physics => return self.check_physics(chunk, heartbeat),
        }
        Ok(Margins::UNMEASURED)
    }

    /// The physical checks of a chunk.
    fn check_physics(
        &mut self,
        chunk: &PlanChunk,
        heartbeat: &mut dyn FnMut(),
    ) -> Result<Margins, Violation> {
        self.touch_after(chunk)?;
        if self.rest_state.is_none() {
            self.checker.excuse_none_clear_in(&chunk.waypoints()[0]);
        }
        let mode = mode_of(chunk);
        if !chunk.is_smooth() {
            let (contacts, waypoints) = (chunk.contacts(), chunk.waypoints());
            let course = Course::Straight;
            let segment = MotionSegment { mode, contacts, waypoints, course };
            return self.checker.check_segment(&segment, heartbeat);
        }
        if self.landing(chunk).is_some() {
            self.checker.check_landing(chunk.contacts(), &chunk.waypoints()[0])?;
        }
        let before = self.rest_state.as_ref().filter(|_| !self.starts_plan(chunk));
        if before.is_some_and(|before| before.mode == mode) {
            self.checker.check_going_on(chunk.contacts(), &chunk.waypoints()[0])?;
        }
        let none = RecentChunks::default();
        let recent = if self.starts_plan(chunk) { &none } else { &self.recent };
        recent.check_next(&mut self.checker, (mode, chunk), heartbeat)
    }

    /// The swing foot that touches the world at the end of a chunk, and the pose in which its sole
    /// began to, in this chunk or before.
    fn touch_after(&self, chunk: &PlanChunk) -> Result<Option<(usize, Pose)>, Violation> {
        let limb = match mode_of(chunk) {
            SupportMode::Left => 1,
            SupportMode::Right => 0,
            SupportMode::Double => return Ok(None),
        };
        let before = self.touch.filter(|(foot, _)| *foot == limb && !self.starts_plan(chunk));
        let before = before.map(|(_, pose)| pose);
        let touch = self.checker.check_touch(limb, chunk.waypoints(), before)?;
        Ok(touch.map(|pose| (limb, pose)))
    }

    /// Executes a chunk that [`Self::check_chunk`] accepted with these margins.
    pub fn execute(&mut self, chunk: &PlanChunk, margins: &Margins) {
        self.touch = self.touch_after(chunk).unwrap_or_default();
        let starts_plan = self.starts_plan(chunk);
        let so_far = if starts_plan { Margins::UNMEASURED } else { self.margins };
        if starts_plan {
            self.recent.clear();
        }
        self.margins = so_far.min(margins);
        self.plan = Some((chunk.plan_id, chunk.epoch));
        self.next_sequence = chunk.sequence + 1;
        self.stream = chunk.stream_after();
        self.finished = chunk.flags & FLAG_LAST != 0;
        let mut rest_state = RestState::after(chunk);
        rest_state.keep_contacts_of(self.rest_state.as_ref());
        self.rest_state = Some(rest_state);
        self.recent.add(mode_of(chunk), chunk);
        self.actual = None;
    }

    /// The contact of an accepted chunk that the robot does not stand on yet.
    pub fn landing<'a>(&self, chunk: &'a PlanChunk) -> Option<&'a Contact> {
        let rest_state = self.rest_state()?;
        let is_double = SupportMode::from_wire(chunk.mode) == Some(SupportMode::Double);
        let stands =
            |contact: &Contact| rest_state.contacts.iter().any(|old| old.limb == contact.limb);
        chunk.contacts().iter().find(|contact| is_double && !stands(contact))
    }

    /// The physical checks of a motion that is not the plan's. `heartbeat` is called now and then
    /// meanwhile.
    ///
    /// # Errors
    /// The first violation.
    pub fn check_motion(
        &mut self,
        segment: &MotionSegment,
        heartbeat: &mut dyn FnMut(),
    ) -> Result<Margins, Violation> {
        self.checker.check_segment(segment, heartbeat)
    }

    /// The robot has executed an accepted chunk with misplaced feet, as `actual` says.
    pub fn execute_as(&mut self, chunk: &PlanChunk, actual: &PlanChunk, margins: &Margins) {
        self.execute(chunk, margins);
        let rest_state = RestState::after(actual);
        self.actual = (Some(&rest_state) != self.rest_state.as_ref()).then_some(rest_state);
    }

    /// Ends the plan: the next one must begin at the actual rest state.
    pub fn hold_position(&mut self) {
        self.recent.clear();
        if let Some(actual) = self.actual.take() {
            self.rest_state = Some(actual);
        }
    }

    /// The actual rest state; nothing before the first chunk.
    pub fn actual_rest_state(&self) -> Option<&RestState> {
        self.actual.as_ref().or(self.rest_state.as_ref())
    }

    /// The checker.
    pub fn checker(&self) -> &Checker {
        &self.checker
    }

    /// The checker, to compute with.
    pub fn checker_mut(&mut self) -> &mut Checker {
        &mut self.checker
    }

    /// The sequence number expected next: all before are accepted.
    pub fn next_sequence(&self) -> u64 {
        self.next_sequence
    }

    /// The plan in execution, if any.
    pub fn plan_id(&self) -> Option<u64> {
        self.plan.map(|(plan_id, _)| plan_id)
    }

    /// The digest of the accepted stream.
    pub fn stream(&self) -> Digest {
        self.stream
    }

    /// Whether the last chunk of the plan is accepted.
    pub fn finished(&self) -> bool {
        self.finished
    }

    /// The rest state by the plan; nothing before the first chunk.
    pub fn rest_state(&self) -> Option<&RestState> {
        self.rest_state.as_ref()
    }

    /// The worst margins of the accepted chunks of this plan.
    pub fn margins(&self) -> Margins {
        self.margins
    }

    fn starts_plan(&self, chunk: &PlanChunk) -> bool {
        chunk.sequence == 0 && self.plan != Some((chunk.plan_id, chunk.epoch))
    }

    /// Whether a chunk is the next one of its plan, and continues the accepted stream.
    fn check_stream(&self, chunk: &PlanChunk) -> Result<(), Violation> {
        let starts_plan = self.starts_plan(chunk);
        if !starts_plan {
            self.check_sequence(chunk)
                .map_err(|detail| Violation::new(Check::Sequence, 0, detail))?;
        }
        let expected = if starts_plan { Digest::default() } else { self.stream };
        if chunk.stream == expected {
            return Ok(());
        }
        let detail = format!("it continues stream {}, accepted is {expected}", chunk.stream);
        Err(Violation::new(Check::Stream, 0, detail))
    }

    /// Whether a chunk that does not start a plan has the sequence number expected next.
    fn check_sequence(&self, chunk: &PlanChunk) -> Result<(), String> {
        let (got, expected) = (chunk.sequence, self.next_sequence);
        if self.plan != Some((chunk.plan_id, chunk.epoch)) {
            return Err(format!("chunk {got} of plan {}, which has not begun", chunk.plan_id));
        }
        match got.cmp(&expected) {
            Ordering::Less => Err(format!("chunk {got} again; {expected} comes next")),
            Ordering::Greater => Err(format!("chunk {got} leaves a gap; {expected} comes next")),
            Ordering::Equal if self.finished => {
                Err(format!("chunk {got} after the plan's last one"))
            }
            Ordering::Equal => Ok(()),
        }
    }

    /// A new plan may start its clock anew and put its weight on another foot, but begins where the
    /// robot stands.
    fn check_continuity(&self, chunk: &PlanChunk, mode: SupportMode) -> Result<(), Violation> {
        let bad = |detail| Err(Violation::new(Check::Continuity, 0, detail));
        check_rests(chunk).or_else(bad)?;
        let model = self.checker.model();
        self.ends.check_goal(model, chunk, mode).or_else(bad)?;
        let Some(rest_state) = &self.rest_state else {
            return self.ends.check_start(model, chunk).or_else(bad);
        };
        let goes_on = self.recent.last_waypoint().filter(|_| !self.starts_plan(chunk));
        let (first, last) = (&chunk.waypoints()[0], goes_on.unwrap_or(&rest_state.waypoint));
        let jump = largest_difference(last, first);
        if !is_at_most(jump, CONTINUITY_MAX) {
            return bad(format!(
                "it begins {jump:.3e} from where the robot stands, limit {CONTINUITY_MAX:.0e}"
            ));
        }
        let late = (first.time - last.time).abs();
        if !self.starts_plan(chunk) && !is_at_most(late, CONTINUITY_MAX) {
            let (begin, end) = (first.time, last.time);
            return bad(format!("it begins at {begin} s, the chunk before ended at {end} s"));
        }
        goes_on.map_or(Ok(()), |last| check_torques_go_on(last, first)).or_else(bad)?;
        let brakes = self.recent.brake_at().filter(|_| goes_on.is_some());
        if let Some(before) = brakes.filter(|before| !is_at_most(*before, chunk.brake_at)) {
            let at = chunk.brake_at;
            return bad(format!("it brakes at {at} s, before the last chunk does at {before} s"));
        }
        let before = Stance { mode: rest_state.mode, contacts: &rest_state.contacts };
        check_transition(&before, &Stance { mode, contacts: chunk.contacts() }).or_else(bad)
    }
}

/// The mode of a chunk that has passed [`Stage::Message`].
fn mode_of(chunk: &PlanChunk) -> SupportMode {
    SupportMode::from_wire(chunk.mode).unwrap_or(SupportMode::Double)
}

/// A plan begins and ends at rest, and so does a chunk that brakes within no time. The robot comes
/// to rest at the plan's end, nowhere before.
fn check_rests(chunk: &PlanChunk) -> Result<(), String> {
    let waypoints = chunk.waypoints();
    let (begin, end) = (&waypoints[0], &waypoints[waypoints.len() - 1]);
    if chunk.flags & FLAG_FIRST != 0 && !is_resting(begin) {
        return Err("the plan begins in motion".to_owned());
    }
    let is_last = chunk.flags & FLAG_LAST != 0;
    if (is_last || chunk.brake_duration == 0.0) && !is_resting(end) {
        return Err("it ends in motion and names no instant to brake".to_owned());
    }
    let rest_at = Stop::of_chunk(chunk).rest_at();
    if is_last && !is_at_most(end.time - rest_at, CONTINUITY_MAX) {
        let end = end.time;
        return Err(format!("the plan ends at {end} s, and its last chunk rests at {rest_at} s"));
    }
    Ok(())
}

/// Whether a chunk's first waypoint states the feed-forward torques of the last one before it, so
/// that no chunk leaves out those that others state.
fn check_torques_go_on(last: &Waypoint, first: &Waypoint) -> Result<(), String> {
    let torques = |w: &Waypoint| w.torque.into_iter().chain(w.rest_torque);
    let jump = largest(torques(last).zip(torques(first)).map(|(x, y)| (x - y).abs()));
    if is_at_most(jump, CONTINUITY_MAX) {
        return Ok(());
    }
    Err(format!(
        "its feed-forward torques begin {jump:.3e} N m or N from those of the chunk before, limit \
         {CONTINUITY_MAX:.0e}"
    ))
}

/// The largest difference of any number of two waypoints but their torques; NaN where one is NaN.
fn largest_difference(a: &Waypoint, b: &Waypoint) -> f64 {
    let numbers = |w: &Waypoint| {
        let root = w.root_position.into_iter().chain(w.root_rotation).chain(w.root_velocity);
        let joints = w.q.into_iter().chain(w.joint_velocity).chain(w.joint_acceleration);
        root.chain(w.root_acceleration).chain(joints)
    };
    largest(numbers(a).zip(numbers(b)).map(|(x, y)| (x - y).abs()))
}
