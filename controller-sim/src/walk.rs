//! One received chunk, from its bytes to the verdict: the controller's heart.
//!
//! The walker stands at a statically stable configuration. A chunk that passes every test moves it
//! to the chunk's end; any other leaves it where it stands, so a refusal is always safe.

use surefoot_shared_types::digest::Digest;
use surefoot_shared_types::message::chunk::FLAG_LAST;
use surefoot_shared_types::message::feedback::Margins;
use surefoot_shared_types::message::{
    Check, Contact, Correction, Feedback, PlanChunk, State, SupportMode, Waypoint,
};
use surefoot_shared_types::scene::correction::corrected_digest;

pub use crate::admission::Identity;
use crate::admission::check_message;
use crate::bound::within;
use crate::check::{Checker, Segment, Violation};
use crate::continuity::{Stance, check_transition, standing_limbs};
use crate::simulation::Simulation;

/// How far the first waypoint of a chunk may be from the configuration in which the robot stands,
/// in any number.
const CONTINUITY_MAX: f64 = 1e-9;

/// The simulated robot, and how far it got in the plan it walks.
pub struct Walker {
    checker: Checker,
    identity: Identity,
    plan: Option<(u64, u64)>,
    next_sequence: u64,
    stream: Digest,
    finished: bool,
    /// Where the plan being walked says that the robot stands.
    standing: Option<Standing>,
    /// Where it really stands, if its feet were misplaced.
    really: Option<Standing>,
    margins: Margins,
}

/// A configuration in which the robot may stop forever.
#[derive(Debug, Clone, PartialEq)]
pub struct Standing {
    /// The configuration, and the plan's time at which it was reached.
    pub waypoint: Waypoint,
    /// Which feet carry the robot.
    pub mode: SupportMode,
    /// Where they stand.
    pub contacts: Vec<Contact>,
}

impl Standing {
    /// At the end of a chunk of a known mode.
    fn after(chunk: &PlanChunk) -> Self {
        let waypoint = chunk.waypoints()[chunk.waypoints().len() - 1];
        let mode = SupportMode::from_wire(chunk.mode).unwrap_or(SupportMode::Double);
        Self { waypoint, mode, contacts: chunk.contacts().to_vec() }
    }
}

impl Walker {
    /// A robot that stands nowhere yet: the first chunk says where.
    pub fn new(checker: Checker, identity: Identity) -> Self {
        Self {
            checker,
            identity,
            plan: None,
            next_sequence: 0,
            stream: Digest::default(),
            finished: false,
            standing: None,
            really: None,
            margins: Margins::UNMEASURED,
        }
    }

    /// A robot that another controller moved before: `word` is the last that one said.
    pub fn take_over(checker: Checker, identity: Identity, word: &Feedback) -> Self {
        let standing = &word.standing;
        let limbs = SupportMode::from_wire(standing.mode).map(|mode| (mode, standing_limbs(mode)));
        let contacts = |limbs: &[u32]| {
            limbs.iter().filter_map(|&limb| standing.contact_of(limb)).copied().collect()
        };
        let world = corrected_digest(&identity.world, word.corrections());
        Self {
            checker,
            identity: Identity { world, ..identity },
            plan: (word.session != 0).then_some((word.plan_id, word.epoch)),
            next_sequence: word.next_sequence,
            stream: word.stream,
            finished: word.finished != 0,
            standing: limbs.filter(|_| standing.is_known()).map(|(mode, limbs)| Standing {
                waypoint: standing.waypoint,
                mode,
                contacts: contacts(limbs),
            }),
            really: None,
            margins: word.margins,
        }
    }

    /// Expects chunks made for the world as `correction` says it is, from now on: to be called with
    /// every correction that the planner is told.
    pub fn correct(&mut self, correction: &Correction) {
        self.identity.world = corrected_digest(&self.identity.world, &[*correction]);
    }

    /// Admits a chunk, checks it, and walks it: the worst margins of the chunk, or why it is
    /// refused. Tested in the order CRC, form, instance, robot, world, configuration, sequence,
    /// stream, continuity, physics.
    ///
    /// # Errors
    /// The first condition that does not hold; the robot stays where it stands.
    pub fn admit_and_walk(&mut self, chunk: &PlanChunk) -> Result<Margins, Violation> {
        let margins = self.admit(chunk, &mut || {})?;
        self.walk(chunk, &margins);
        Ok(margins)
    }

    /// As [`Self::admit_and_walk`], but the robot does not move. `alive` is called now and then
    /// meanwhile.
    ///
    /// # Errors
    /// The first condition that does not hold.
    pub fn admit(
        &mut self,
        chunk: &PlanChunk,
        alive: &mut dyn FnMut(),
    ) -> Result<Margins, Violation> {
        let mode = check_message(chunk, &self.identity, self.checker.model().joints.len())?;
        let starts_plan = self.starts_plan(chunk);
        self.check_sequence(chunk, starts_plan)?;
        self.check_stream(chunk, starts_plan)?;
        self.check_continuity(chunk, mode, starts_plan)?;
        let segment = Segment { mode, contacts: chunk.contacts(), waypoints: chunk.waypoints() };
        self.checker.check_segment(&segment, alive)
    }

    /// The contact of an admitted chunk that the robot does not stand on yet.
    pub fn landing<'a>(&self, chunk: &'a PlanChunk) -> Option<&'a Contact> {
        let standing = self.standing()?;
        let is_double = SupportMode::from_wire(chunk.mode) == Some(SupportMode::Double);
        let stands =
            |contact: &Contact| standing.contacts.iter().any(|old| old.limb == contact.limb);
        chunk.contacts().iter().find(|contact| is_double && !stands(contact))
    }

    /// The physical checks of a motion that is not the plan's. `alive` is called now and then
    /// meanwhile.
    ///
    /// # Errors
    /// The first violation.
    pub fn check(
        &mut self,
        segment: &Segment,
        alive: &mut dyn FnMut(),
    ) -> Result<Margins, Violation> {
        self.checker.check_segment(segment, alive)
    }

    /// The robot has walked an admitted chunk with its feet elsewhere than planned, as `real` says.
    pub fn walk_as(&mut self, chunk: &PlanChunk, real: &PlanChunk, margins: &Margins) {
        self.walk(chunk, margins);
        let standing = Standing::after(real);
        self.really = (Some(&standing) != self.standing.as_ref()).then_some(standing);
    }

    /// The robot gives up its plan: the next one must begin where it really stands.
    pub fn hold(&mut self) {
        if let Some(really) = self.really.take() {
            self.standing = Some(really);
        }
    }

    /// Where the robot really stands; nothing before the first chunk.
    pub fn really_standing(&self) -> Option<&Standing> {
        self.really.as_ref().or(self.standing.as_ref())
    }

    /// Walks an accepted chunk in simulated time; `tell` hears of every tick.
    pub fn simulate(
        &mut self,
        simulation: &mut Simulation,
        chunk: &PlanChunk,
        tell: &mut dyn FnMut(&State),
    ) {
        simulation.walk(&mut self.checker, chunk, tell);
    }

    /// What judges the chunks.
    pub fn checker(&self) -> &Checker {
        &self.checker
    }

    /// The sequence number expected next: all before are accepted.
    pub fn next_sequence(&self) -> u64 {
        self.next_sequence
    }

    /// The plan being walked, if any.
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
    pub fn standing(&self) -> Option<&Standing> {
        self.standing.as_ref()
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
        let Some(standing) = &self.standing else { return Ok(()) };
        let first = &chunk.waypoints()[0];
        let jump = largest_difference(&standing.waypoint, first);
        if !within(jump, CONTINUITY_MAX) {
            return bad(format!(
                "it begins {jump:.3e} from where the robot stands, limit {CONTINUITY_MAX:.0e}"
            ));
        }
        let late = (first.time - standing.waypoint.time).abs();
        if !starts_plan && !within(late, CONTINUITY_MAX) {
            return bad(format!(
                "it begins at {} s, the chunk before ended at {} s",
                first.time, standing.waypoint.time
            ));
        }
        let before = Stance { mode: standing.mode, contacts: &standing.contacts };
        check_transition(&before, &Stance { mode, contacts: chunk.contacts() }).or_else(bad)
    }

    /// Walks a chunk that [`Self::admit`] admitted with these margins.
    pub fn walk(&mut self, chunk: &PlanChunk, margins: &Margins) {
        let starts_plan = self.starts_plan(chunk);
        let so_far = if starts_plan { Margins::UNMEASURED } else { self.margins };
        self.margins = so_far.min(margins);
        self.plan = Some((chunk.plan_id, chunk.epoch));
        self.next_sequence = chunk.sequence + 1;
        self.stream = chunk.stream_after();
        self.finished = chunk.flags & FLAG_LAST != 0;
        self.standing = Some(Standing::after(chunk));
        self.really = None;
    }
}

fn largest_difference(a: &Waypoint, b: &Waypoint) -> f64 {
    let numbers = |w: &Waypoint| {
        w.root_position.into_iter().chain(w.root_rotation).chain(w.q).collect::<Vec<f64>>()
    };
    numbers(a).iter().zip(numbers(b)).map(|(x, y)| (x - y).abs()).fold(0.0, f64::max)
}
