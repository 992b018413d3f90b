//! Executes received chunks: checks a chunk from its bytes to its physics and moves the robot.
//!
//! The robot stands at a statically stable configuration. A chunk that passes every check moves it
//! to the chunk's end; any other leaves it where it stands, so a refusal is always safe.

use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::message::Margins;
use surefoot_shared_types::message::chunk::FLAG_LAST;
use surefoot_shared_types::message::{
    Check, Contact, Feedback, PlanChunk, SimulationState, SupportMode, Waypoint, WorldCorrection,
};
use surefoot_shared_types::world::correction::corrected_digest;

use crate::base::comparison::is_at_most;
use crate::check::checker::{Checker, MotionSegment, Violation};
use crate::chunk::continuity::{Stance, check_transition, stance_limbs};
pub use crate::chunk::message_check::Identity;
use crate::chunk::message_check::check_message;
use crate::execution::simulation::Simulation;

/// How far the first waypoint of a chunk may be from the configuration in which the robot stands,
/// in any number.
const CONTINUITY_MAX: f64 = 1e-9;

/// The simulated robot and its progress in the plan that it executes.
pub struct ChunkExecutor {
    checker: Checker,
    identity: Identity,
    plan: Option<(u64, u64)>,
    next_sequence: u64,
    stream: Digest,
    finished: bool,
    /// Where the robot stands by its plan.
    rest_state: Option<RestState>,
    /// Where it actually stands, if its feet were misplaced.
    actual: Option<RestState>,
    margins: Margins,
}

/// A statically stable configuration with its contacts.
#[derive(Debug, Clone, PartialEq)]
pub struct RestState {
    /// The configuration, and the plan's time at which it was reached.
    pub waypoint: Waypoint,
    /// Which feet carry the robot.
    pub mode: SupportMode,
    /// Where they stand.
    pub contacts: Vec<Contact>,
}

impl RestState {
    /// At the end of a chunk of a known mode.
    fn after(chunk: &PlanChunk) -> Self {
        let waypoint = chunk.waypoints()[chunk.waypoints().len() - 1];
        let mode = SupportMode::from_wire(chunk.mode).unwrap_or(SupportMode::Double);
        Self { waypoint, mode, contacts: chunk.contacts().to_vec() }
    }
}

impl ChunkExecutor {
    /// A robot without a rest state yet; the first chunk sets it.
    pub fn new(checker: Checker, identity: Identity) -> Self {
        Self {
            checker,
            identity,
            plan: None,
            next_sequence: 0,
            stream: Digest::default(),
            finished: false,
            rest_state: None,
            actual: None,
            margins: Margins::UNMEASURED,
        }
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
            plan: (feedback.session != 0).then_some((feedback.plan_id, feedback.epoch)),
            next_sequence: feedback.next_sequence,
            stream: feedback.stream,
            finished: feedback.finished != 0,
            rest_state: limbs.filter(|_| rest_state.is_known()).map(|(mode, limbs)| RestState {
                waypoint: rest_state.waypoint,
                mode,
                contacts: contacts(limbs),
            }),
            actual: None,
            margins: feedback.margins,
        }
    }

    /// From now on expects chunks made for the world with `correction` applied. To be called with
    /// every correction that is reported to the planner.
    pub fn correct(&mut self, correction: &WorldCorrection) {
        self.identity.world = corrected_digest(&self.identity.world, &[*correction]);
    }

    /// Checks a chunk and executes it: the worst margins of the chunk, or why it is refused.
    /// Checked in the order CRC, form, controller, robot, world, configuration, sequence, stream,
    /// continuity, physics.
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
    /// The first condition that does not hold.
    pub fn check_chunk(
        &mut self,
        chunk: &PlanChunk,
        heartbeat: &mut dyn FnMut(),
    ) -> Result<Margins, Violation> {
        let mode = check_message(chunk, &self.identity, self.checker.model().joints.len())?;
        let starts_plan = self.starts_plan(chunk);
        self.check_sequence(chunk, starts_plan)?;
        self.check_stream(chunk, starts_plan)?;
        self.check_continuity(chunk, mode, starts_plan)?;
        let segment =
            MotionSegment { mode, contacts: chunk.contacts(), waypoints: chunk.waypoints() };
        self.checker.check_segment(&segment, heartbeat)
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
        if let Some(actual) = self.actual.take() {
            self.rest_state = Some(actual);
        }
    }

    /// Where the robot actually stands; nothing before the first chunk.
    pub fn actual_rest_state(&self) -> Option<&RestState> {
        self.actual.as_ref().or(self.rest_state.as_ref())
    }

    /// Executes an accepted chunk in simulated time; `publish` is called at every tick.
    pub fn simulate(
        &mut self,
        simulation: &mut Simulation,
        chunk: &PlanChunk,
        publish: &mut dyn FnMut(&SimulationState),
    ) {
        simulation.execute(&mut self.checker, chunk, publish);
    }

    /// The checker.
    pub fn checker(&self) -> &Checker {
        &self.checker
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

    /// Where the robot stands, by the plan; nothing before the first chunk.
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

    fn check_sequence(&self, chunk: &PlanChunk, starts_plan: bool) -> Result<(), Violation> {
        let bad = |detail| Err(Violation::new(Check::Sequence, 0, detail));
        if starts_plan {
            return Ok(());
        }
        let (got, expected) = (chunk.sequence, self.next_sequence);
        if self.plan != Some((chunk.plan_id, chunk.epoch)) {
            return bad(format!("chunk {got} of plan {}, which has not begun", chunk.plan_id));
        }
        match got.cmp(&expected) {
            std::cmp::Ordering::Less => bad(format!("chunk {got} again; {expected} comes next")),
            std::cmp::Ordering::Greater => {
                bad(format!("chunk {got} leaves a gap; {expected} comes next"))
            }
            std::cmp::Ordering::Equal if self.finished => {
                bad(format!("chunk {got} after the plan's last one"))
            }
            std::cmp::Ordering::Equal => Ok(()),
        }
    }

    fn check_stream(&self, chunk: &PlanChunk, starts_plan: bool) -> Result<(), Violation> {
        let expected = if starts_plan { Digest::default() } else { self.stream };
        if chunk.stream == expected {
            return Ok(());
        }
        Err(Violation::new(
            Check::Stream,
            0,
            format!("it continues stream {}, accepted is {expected}", chunk.stream),
        ))
    }

    /// A new plan may start its clock anew and put its weight on another foot, but begins where the
    /// robot stands.
    fn check_continuity(
        &self,
        chunk: &PlanChunk,
        mode: SupportMode,
        starts_plan: bool,
    ) -> Result<(), Violation> {
        let bad = |detail| Err(Violation::new(Check::Continuity, 0, detail));
        let Some(rest_state) = &self.rest_state else { return Ok(()) };
        let first = &chunk.waypoints()[0];
        let jump = largest_difference(&rest_state.waypoint, first);
        if !is_at_most(jump, CONTINUITY_MAX) {
            return bad(format!(
                "it begins {jump:.3e} from where the robot stands, limit {CONTINUITY_MAX:.0e}"
            ));
        }
        let late = (first.time - rest_state.waypoint.time).abs();
        if !starts_plan && !is_at_most(late, CONTINUITY_MAX) {
            return bad(format!(
                "it begins at {} s, the chunk before ended at {} s",
                first.time, rest_state.waypoint.time
            ));
        }
        let before = Stance { mode: rest_state.mode, contacts: &rest_state.contacts };
        check_transition(&before, &Stance { mode, contacts: chunk.contacts() }).or_else(bad)
    }

    /// Executes a chunk that [`Self::check_chunk`] accepted with these margins.
    pub fn execute(&mut self, chunk: &PlanChunk, margins: &Margins) {
        let starts_plan = self.starts_plan(chunk);
        let so_far = if starts_plan { Margins::UNMEASURED } else { self.margins };
        self.margins = so_far.min(margins);
        self.plan = Some((chunk.plan_id, chunk.epoch));
        self.next_sequence = chunk.sequence + 1;
        self.stream = chunk.stream_after();
        self.finished = chunk.flags & FLAG_LAST != 0;
        self.rest_state = Some(RestState::after(chunk));
        self.actual = None;
    }
}

fn largest_difference(a: &Waypoint, b: &Waypoint) -> f64 {
    let numbers = |w: &Waypoint| {
        w.root_position.into_iter().chain(w.root_rotation).chain(w.q).collect::<Vec<f64>>()
    };
    numbers(a).iter().zip(numbers(b)).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}
