//! What a planner is to plan: where from, where to, in which world, under which name.

use std::num::NonZeroUsize;

use surefoot_planner::prepare::Preparation;
use surefoot_planner::{Planner, PlannerError};
use surefoot_shared_types::config::{Mark, Scenario};
use surefoot_shared_types::message::{Correction, CorrectionKind, Feedback, PlanChunk, Standing};
use surefoot_shared_types::robot::RobotModel;
use surefoot_shared_types::scene::World;
use surefoot_shared_types::scene::correction::CorrectionError;

use crate::failure::Failure;
use crate::inputs::Inputs;

/// Chunks that are remembered of what was walked: more than four dozen steps.
const WALKED_MAX: usize = 256;
/// How many places at which a foot was lifted a walk goes back at the most.
const PLACES_BACK_MAX: usize = 16;
/// Units of work after which a search is given up for one from farther back: so many for each chunk
/// of the plan before, which is several times of what these took.
const WORK_PER_CHUNK: u64 = 300;
/// The least of it.
const WORK_MIN: u64 = 20_000;

/// A task.
#[derive(Debug, Clone)]
pub(crate) struct Task {
    /// The scenario with this task's start, goal and seed. Its digest stays that of the file, which
    /// is what both sides know.
    pub(super) scenario: Scenario,
    /// The world as it is known now.
    pub(super) world: World,
    /// What the controller met so far that is not as the world file says.
    pub(super) corrections: Vec<Correction>,
    /// Where the robot stands; nothing before it stands anywhere.
    pub(super) standing: Option<Standing>,
    /// Chunks of the plan before.
    chunks: u64,
    /// The chunks that it walked last, the last one to there.
    walked: Vec<PlanChunk>,
    /// To how many places back it goes first, at which a foot was lifted.
    places_back: usize,
    /// Which plan of the controller's it is.
    pub(super) plan_id: u64,
    /// How often it was planned again.
    pub(super) epoch: u64,
}

impl Task {
    /// The scenario's own.
    pub(crate) fn first(inputs: &Inputs) -> Self {
        Self {
            scenario: inputs.scenario.clone(),
            world: inputs.world.clone(),
            corrections: vec![],
            standing: None,
            chunks: 0,
            walked: vec![],
            places_back: 0,
            plan_id: 1,
            epoch: 0,
        }
    }

    /// Whether a task that begins farther back than a `planner` of this one may find what that one
    /// did not.
    pub(super) fn may_go_back(&self, planner: &Planner) -> bool {
        let gone = planner.way_back().places;
        let is_farthest =
            gone < self.places_back || gone >= PLACES_BACK_MAX || self.walked.is_empty();
        self.standing.is_some() && !is_farthest
    }

    /// Begins farther back than a `planner` of this task.
    pub(super) fn go_back(&mut self, planner: &Planner) {
        self.places_back = (2 * planner.way_back().places).max(1);
    }

    /// The rest of the way from where the controller's `word` says that the robot stands, in the
    /// world as it says that it is, under a new epoch. `chunks` are this task's, the first `back`
    /// of which lead back along what was walked before.
    ///
    /// # Errors
    /// The word's corrections concern another world, or its epoch is the last one possible.
    pub(crate) fn after(
        self,
        inputs: &Inputs,
        word: &Feedback,
        chunks: &[PlanChunk],
        back: usize,
    ) -> Result<Self, Failure> {
        let is_own = (word.plan_id, word.epoch) == (self.plan_id, self.epoch);
        let epoch = following(
            if word.plan_id == self.plan_id { word.epoch.max(self.epoch) } else { word.epoch },
            word,
        )?;
        let accepted = usize::try_from(word.next_sequence)
            .map_or(chunks, |count| &chunks[..count.min(chunks.len())]);
        let walked = if is_own { walked_after(self.walked, accepted, back) } else { vec![] };
        let (plan_id, chunks) = (word.plan_id, chunks.len() as u64);
        Ok(Self { plan_id, epoch, chunks, walked, places_back: 0, ..self }
            .standing_as(inputs, word)?)
    }

    /// A plan of its own from where the controller's `word` says that the robot stands, or from the
    /// scenario's start where it stands nowhere yet.
    ///
    /// # Errors
    /// The word's corrections concern another world, or its plan is the last one possible.
    pub(super) fn anew(inputs: &Inputs, word: Option<&Feedback>) -> Result<Self, Failure> {
        let first = Self::first(inputs);
        match word {
            Some(word) => Ok(Self { plan_id: following(word.plan_id, word)?, ..first }
                .standing_as(inputs, word)?),
            None => Ok(first),
        }
    }

    /// The same task towards another goal, with another seed and at most this much work.
    pub(super) fn towards(mut self, goal: Mark, seed: u64, work_max: u64) -> Self {
        self.scenario.goal = goal;
        self.scenario.seed = seed;
        if work_max > 0 {
            self.scenario.planner.work_max = work_max.min(self.scenario.planner.work_max);
        }
        self
    }

    /// The same task from a mark, wherever the robot stands.
    pub(super) fn starting_on(mut self, start: Mark) -> Self {
        self.scenario.start = start;
        self.standing = None;
        self
    }

    /// A planner that is ready for this task. Where the robot cannot stand as it does, its plan
    /// leads back first.
    ///
    /// # Errors
    /// The robot or the world is none that it can use.
    pub(crate) fn planner(
        &self,
        model: &RobotModel,
        preparation: Preparation<'static>,
        threads: NonZeroUsize,
    ) -> Result<Planner, PlannerError> {
        let mut planner = Planner::new(model, &self.world, &self.scenario, preparation, threads)?;
        if let Some(standing) = &self.standing {
            planner.begin_at(&self.world, standing)?;
            let places =
                if planner.may_begin() { self.places_back } else { self.places_back.max(1) };
            if places > 0 {
                planner.walk_back(&self.world, &self.walked, places)?;
            }
            if self.may_go_back(&planner) {
                planner.limit_work(WORK_MIN.max(WORK_PER_CHUNK * self.chunks));
            }
        }
        for missing in self
            .corrections
            .iter()
            .filter(|correction| correction.known_kind() == Some(CorrectionKind::ContactMissing))
        {
            let [half_length, half_width, _] = missing.half_extents;
            planner.shun(&missing.pose(), [half_length, half_width]);
        }
        planner.name_plan(self.plan_id, self.epoch);
        Ok(planner)
    }

    fn standing_as(mut self, inputs: &Inputs, word: &Feedback) -> Result<Self, CorrectionError> {
        self.world = inputs.world.corrected(word.corrections())?;
        self.corrections = word.corrections().to_vec();
        self.standing = word.standing.is_known().then_some(word.standing);
        Ok(self)
    }
}

/// What the robot has walked, of which it remembers so much, after the `accepted` chunks: the first
/// `back` of them lead back.
fn walked_after(mut walked: Vec<PlanChunk>, accepted: &[PlanChunk], back: usize) -> Vec<PlanChunk> {
    let (led_back, onward) = accepted.split_at(back.min(accepted.len()));
    walked.truncate(walked.len().saturating_sub(led_back.len()));
    walked.extend_from_slice(onward);
    walked.drain(..walked.len().saturating_sub(WALKED_MAX));
    walked
}

/// The number after one of the `word`'s, which may be any.
fn following(number: u64, word: &Feedback) -> Result<u64, Failure> {
    number.checked_add(1).ok_or(Failure::LastName { plan_id: word.plan_id, epoch: word.epoch })
}

#[cfg(test)]
mod tests {
    use bytemuck::Zeroable;

    use super::*;

    #[test]
    fn chunks_that_lead_back_are_forgotten_with_what_they_lead_along() {
        let chunk = |sequence| PlanChunk { sequence, ..PlanChunk::zeroed() };
        let sequences =
            |walked: Vec<PlanChunk>| walked.iter().map(|chunk| chunk.sequence).collect::<Vec<_>>();
        let walked = [1, 2, 3].map(chunk).to_vec();
        assert_eq!(
            sequences(walked_after(walked.clone(), &[10, 11].map(chunk), 0)),
            [1, 2, 3, 10, 11]
        );
        assert_eq!(sequences(walked_after(walked.clone(), &[10, 11, 12].map(chunk), 2)), [1, 12]);
        assert_eq!(
            sequences(walked_after(walked.clone(), &[10].map(chunk), 2)),
            [1, 2],
            "it was stopped on the way back"
        );
        let many: Vec<PlanChunk> = (0..WALKED_MAX as u64).map(chunk).collect();
        assert_eq!(walked_after(walked, &many, 0), many, "the oldest are forgotten first");
    }

    #[test]
    fn no_plan_follows_the_last_one_that_can_be_named() {
        let inputs = Inputs::load("configs/scenarios/flat_walk.toml".as_ref(), None).unwrap();
        let word = |plan_id, epoch| Feedback { plan_id, epoch, ..Feedback::zeroed() };
        let first = Task::first(&inputs);
        let name = |task: Result<Task, Failure>| {
            task.map(|task| (task.plan_id, task.epoch)).map_err(|failure| failure.to_string())
        };
        assert_eq!(name(Task::anew(&inputs, Some(&word(4, u64::MAX)))), Ok((5, 0)));
        assert_eq!(
            name(first.clone().after(&inputs, &word(u64::MAX, 4), &[], 0)),
            Ok((u64::MAX, 5))
        );
        let last = |word: Feedback| {
            Err(Failure::LastName { plan_id: word.plan_id, epoch: word.epoch }.to_string())
        };
        assert_eq!(name(Task::anew(&inputs, Some(&word(u64::MAX, 0)))), last(word(u64::MAX, 0)));
        assert_eq!(name(first.after(&inputs, &word(4, u64::MAX), &[], 0)), last(word(4, u64::MAX)));
    }
}
