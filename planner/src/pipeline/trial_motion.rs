//! The smooth motion along a few steps of a walk, from rest to rest: how long it takes.

use crate::base::capacity::ArenaFull;
use crate::pipeline::timed_chunks::UNITS_PER_POINT;
use crate::smooth_path::smoother::{Smoother, SmoothingInputs};
use crate::timing::path_timing::PathTiming;

/// Most edges of such a part.
pub(crate) const EDGES_MAX: usize = 64;
/// Most points of its path.
pub(crate) const POINTS_MAX: usize = 8_192;
/// Points of a profile that is not rounded, for each work unit.
const PROFILE_POINTS_PER_UNIT: u64 = 8;
/// Largest work of the smoothing, relative to that of the part that is compared.
const SMOOTHING_WORK_MAX: f64 = 1.25;

/// What happens next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Task {
    Begin,
    Smooth,
    /// Limits at the points of the next span.
    Limits,
    /// The timing of all spans.
    Time,
}

/// Facts of a motion.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct TrialFacts {
    /// Duration, s.
    pub seconds: f64,
    /// Phases that keep the searched motion.
    pub searched_phases: u64,
    /// Work units of the smoothing.
    pub smoothing_work: u64,
}

impl TrialFacts {
    /// Those of a motion that every other one is better than.
    pub const WORST: Self =
        Self { seconds: f64::INFINITY, searched_phases: u64::MAX, smoothing_work: u64::MAX };
}

/// How a trial stands.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Trial {
    /// There is more to do.
    Running,
    /// The motion takes no less time, or there is none.
    Rejected,
    /// It takes less time.
    Better(TrialFacts),
}

/// Smooths and times one part of a walk after the other. All memory is reserved at first.
#[derive(Debug)]
pub(crate) struct TrialMotion {
    smoother: Smoother,
    timing: PathTiming,
    task: Task,
    smoothing_work: u64,
}

impl TrialMotion {
    /// Takes the memory of a timing for [`POINTS_MAX`] points.
    pub fn new(timing: PathTiming) -> Self {
        let smoother = Smoother::new(EDGES_MAX, POINTS_MAX);
        Self { smoother, timing, task: Task::Begin, smoothing_work: 0 }
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.smoother.bytes() + self.timing.bytes()
    }

    /// Smooths within `budget` units of work, or adds the limits of one span, or times the whole
    /// part, which the budget does not divide. Ends early where the motion cannot be better than
    /// one with these `known` facts. Returns the units spent.
    pub fn advance(
        &mut self,
        inputs: &SmoothingInputs<'_>,
        known: &TrialFacts,
        budget: u64,
    ) -> (u64, Trial) {
        let (spent, trial) =
            self.try_advance(inputs, known, budget).unwrap_or((1, Trial::Rejected));
        if trial != Trial::Running {
            self.task = Task::Begin;
        }
        (spent, trial)
    }

    fn try_advance(
        &mut self,
        inputs: &SmoothingInputs<'_>,
        known: &TrialFacts,
        budget: u64,
    ) -> Result<(u64, Trial), ArenaFull> {
        match self.task {
            Task::Begin if inputs.plan.nodes.len() > EDGES_MAX => Ok((1, Trial::Rejected)),
            Task::Begin => {
                self.smoother.begin(inputs, false);
                (self.task, self.smoothing_work) = (Task::Smooth, 0);
                Ok((0, Trial::Running))
            }
            Task::Smooth => self.smooth(inputs, known, budget),
            Task::Limits => self.add_span(),
            Task::Time => Ok(self.time(known)),
        }
    }

    fn smooth(
        &mut self,
        inputs: &SmoothingInputs<'_>,
        known: &TrialFacts,
        budget: u64,
    ) -> Result<(u64, Trial), ArenaFull> {
        let work_max = SMOOTHING_WORK_MAX * known.smoothing_work as f64;
        let mut spent = 0;
        while !self.smoother.is_over() && spent < budget {
            if self.smoothing_work as f64 > work_max {
                return Ok((spent, Trial::Rejected));
            }
            self.smoother.advance(inputs)?;
            (spent, self.smoothing_work) = (spent + 1, self.smoothing_work + 1);
        }
        if self.smoother.is_over() {
            if self.smoother.searched_phases() > known.searched_phases {
                return Ok((spent, Trial::Rejected));
            }
            self.timing.begin();
            self.task = Task::Limits;
        }
        Ok((spent, Trial::Running))
    }

    fn add_span(&mut self) -> Result<(u64, Trial), ArenaFull> {
        let path = self.smoother.path();
        match path.spans.get(self.timing.spans()) {
            Some(span) => {
                let points = (span.last - span.first + 1) as u64;
                self.timing.add_span(path)?;
                Ok((UNITS_PER_POINT * points, Trial::Running))
            }
            None => {
                self.task = Task::Time;
                Ok((0, Trial::Running))
            }
        }
    }

    fn time(&mut self, known: &TrialFacts) -> (u64, Trial) {
        let path = self.smoother.path();
        let points = path.points.len() as u64;
        let Some(last) = self.timing.spans().checked_sub(1) else { return (1, Trial::Rejected) };
        let fastest = self.timing.fastest_seconds();
        if fastest.is_none_or(|seconds| seconds >= known.seconds) {
            return (points / PROFILE_POINTS_PER_UNIT + 1, Trial::Rejected);
        }
        let is_timed = self.timing.solve(path, 0, 0);
        let seconds = self.timing.span_times(last).end;
        let trial = if is_timed && seconds < known.seconds {
            Trial::Better(TrialFacts {
                seconds,
                searched_phases: self.smoother.searched_phases(),
                smoothing_work: self.smoothing_work,
            })
        } else {
            Trial::Rejected
        };
        (UNITS_PER_POINT * points, trial)
    }
}
