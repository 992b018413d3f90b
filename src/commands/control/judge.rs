//! What the controller does with a chunk: judges it, walks it, and meets the world.

use surefoot_controller_sim::channel::{ChannelError, Judgement};
use surefoot_controller_sim::disturbance::Walked;
use surefoot_controller_sim::truth::nothing_carries;
use surefoot_controller_sim::{Disturbance, Truth, Violation, Walker};
use surefoot_shared_types::message::limits::CORRECTIONS_MAX;
use surefoot_shared_types::message::{Check, Correction, Margins, PlanChunk};

use super::simulated::Simulated;
use crate::clock::Stopwatch;
use crate::line::{Judged, Refusal};
use crate::margins::WorstMargins;

/// Judges chunks and remembers what it took.
pub(super) struct Judge {
    walker: Walker,
    truth: Option<Truth>,
    disturbance: Option<Disturbance>,
    simulated: Option<Simulated>,
    /// Why the simulation can tell nothing more.
    failed: Result<(), ChannelError>,
    corrections: usize,
    seconds: f64,
    detail: String,
}

impl Judge {
    /// A judge that has judged nothing yet.
    pub(super) fn new(
        walker: Walker,
        truth: Option<Truth>,
        disturbance: Option<Disturbance>,
        simulated: Option<Simulated>,
    ) -> Self {
        Self {
            walker,
            truth,
            disturbance,
            simulated,
            failed: Ok(()),
            corrections: 0,
            seconds: 0.0,
            detail: String::new(),
        }
    }

    /// Leaves out what an earlier controller told already.
    pub(super) fn pass_over(&mut self, told: &[Correction]) {
        self.corrections = told.len();
        if let Some(truth) = &mut self.truth {
            truth.pass_over(told);
        }
    }

    /// Why the last chunk was refused.
    pub(super) fn detail(&self) -> &str {
        &self.detail
    }

    /// Why the simulation could not tell all, if so.
    pub(super) fn failure(&mut self) -> Result<(), ChannelError> {
        std::mem::replace(&mut self.failed, Ok(()))
    }

    /// Judges a chunk, and walks it if it may be walked. `alive` is called now and then meanwhile.
    pub(super) fn judge(&mut self, chunk: &PlanChunk, alive: &mut dyn FnMut()) -> Judgement {
        let watch = Stopwatch::start();
        let judgement = match self.walker.admit(chunk, alive) {
            Ok(margins) => self.walk(chunk, margins, alive),
            Err(violation) => self.refuse(chunk, violation),
        };
        self.seconds += watch.seconds();
        let walked = match &judgement {
            Judgement::Accepted(..) => chunk,
            Judgement::AcceptedAs(_, _, walked) => walked,
            Judgement::Refused { .. } => return judgement,
        };
        if let (Some(simulated), Ok(())) = (&mut self.simulated, &self.failed) {
            self.failed = simulated.walk(&mut self.walker, walked, alive);
        }
        judgement
    }

    /// What is to be said at the end of a plan.
    pub(super) fn conclude(&self, duplicated: u64, refusal: Option<Refusal>) -> Judged {
        let margins = WorstMargins::from(&self.walker.margins());
        Judged {
            check_seconds: self.seconds,
            accepted: self.walker.next_sequence(),
            duplicated,
            margins,
            refusal,
        }
    }

    fn walk(&mut self, chunk: &PlanChunk, margins: Margins, alive: &mut dyn FnMut()) -> Judgement {
        let Some(disturbance) = &mut self.disturbance else {
            self.walker.walk(chunk, &margins);
            return Judgement::Accepted(margins, self.walker.stream());
        };
        match disturbance.walk(&mut self.walker, chunk, alive) {
            Walked::As(real, margins) => Judgement::AcceptedAs(margins, self.walker.stream(), real),
            Walked::DoesNotFit(why) => self.hold(Check::FootMisplaced, 0, None, why),
            Walked::NothingCarries(contact) => {
                let correction = nothing_carries(self.walker.checker().model(), &contact);
                self.hold(
                    Check::WorldDiffers,
                    0,
                    Some(correction),
                    format!("nothing carries foot {} where it comes down", contact.limb),
                )
            }
        }
    }

    /// A refusal, for its own reason or because the world is another.
    fn refuse(&mut self, chunk: &PlanChunk, violation: Violation) -> Judgement {
        let correction =
            self.truth.as_mut().and_then(|truth| truth.met(&self.walker, chunk, &violation));
        let check = match violation.check {
            _ if correction.is_some() => Check::WorldDiffers,
            // The controller before this one knew how far the feet are off, and this one does not.
            Check::Continuity if self.disturbance.is_some() => Check::FootMisplaced,
            check => check,
        };
        self.hold(check, violation.waypoint as u32, correction, violation.detail)
    }

    /// The robot stays where it really stands. What was met is part of the world from now on, as
    /// long as a word can hold it.
    fn hold(
        &mut self,
        check: Check,
        waypoint: u32,
        correction: Option<Correction>,
        detail: String,
    ) -> Judgement {
        self.detail = detail;
        self.walker.hold();
        let correction = correction.filter(|_| self.corrections < CORRECTIONS_MAX);
        if let Some(correction) = &correction {
            self.corrections += 1;
            self.walker.correct(correction);
        }
        Judgement::Refused { check, waypoint, correction }
    }
}
