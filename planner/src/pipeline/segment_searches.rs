//! Segments that are planned in parallel [Grey 3.2]: each takes one segment of the route through
//! the cycle of stage M, and then the next free one.
//!
//! All of them work on one Gamma_M. Their searches for configurations and motions share batches.
//! What changes the graph itself, like more footholds, is done for one segment at a time.

use surefoot_shared_types::config::PlannerConfig;

use crate::base::arena::reserve;
use crate::base::capacity::ArenaFull;
use crate::motion::ids::TransitionId;
use crate::motion::transition_sequence::Objective;
use crate::motion::tuning::SEGMENT_SEARCHES_MAX;
use crate::pipeline::recovery_policy::RecoveryPolicy;
use crate::pipeline::stage::Event;

/// The next task of a segment.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum SegmentState {
    /// None: no segment is left.
    Idle,
    /// Search a sequence.
    Seek,
    /// Estimate the transitions of its sequence.
    Estimate,
    /// Sample configurations of its transitions from `next` on. `failed`: some before have none.
    Sample { next: usize, failed: bool },
    /// Plan motions along its edges from `next` on. `failed`: some before have none.
    Move { next: usize, failed: bool },
    /// Recover: its sequence cannot be completed.
    Failed,
    /// Recover: no sequence leads from its start to its end.
    Disconnected,
    /// Find another route, once the segments before it are complete.
    Leave,
}

/// The search of one segment.
#[derive(Debug)]
pub(crate) struct SegmentSearch {
    /// Index of the segment.
    pub segment: usize,
    /// The next task.
    pub state: SegmentState,
    /// The sequence that is being completed.
    pub sequence: Vec<TransitionId>,
    /// What its sequence is optimised for.
    pub objective: Objective,
    /// Where no sequence connects both ends: the last vertex that is reached from the segment's
    /// start, and the first from its end.
    pub frontiers: [usize; 2],
    /// Failures, and the actions that were taken.
    pub recovery: RecoveryPolicy,
    /// Number of sweeps for footholds along the segment.
    pub sweeps: usize,
    /// The shortest complete sequence.
    pub best: Vec<TransitionId>,
    /// Number of attempts to remove steps; 0 before the first.
    pub step_removals: u32,
}

impl SegmentSearch {
    fn new(config: &PlannerConfig) -> Self {
        let sequence = || reserve(config.configurations_max as usize);
        Self {
            segment: 0,
            state: SegmentState::Idle,
            sequence: sequence(),
            objective: Objective::Feasible,
            frontiers: [0; 2],
            recovery: RecoveryPolicy::default(),
            sweeps: 0,
            best: sequence(),
            step_removals: 0,
        }
    }

    /// Searches a sequence next.
    pub fn seek(&mut self, objective: Objective) {
        (self.objective, self.state) = (objective, SegmentState::Seek);
    }

    /// Makes a sequence the one that is being completed, with its next task.
    ///
    /// # Errors
    /// It has more transitions than may have configurations.
    pub fn take(
        &mut self,
        sequence: &[TransitionId],
        state: SegmentState,
    ) -> Result<(), ArenaFull> {
        self.state = state;
        if sequence.len() > self.sequence.capacity() {
            return Err(ArenaFull::Configurations);
        }
        self.sequence.clear();
        self.sequence.extend_from_slice(sequence);
        Ok(())
    }

    /// Appends a transition to the sequence that is being completed.
    ///
    /// # Errors
    /// It has more transitions than may have configurations.
    pub fn push(&mut self, transition: TransitionId) -> Result<(), ArenaFull> {
        if self.sequence.len() == self.sequence.capacity() {
            return Err(ArenaFull::Configurations);
        }
        self.sequence.push(transition);
        Ok(())
    }

    /// Begins with a segment whose vertices were all swept once.
    fn begin(&mut self, segment: usize) {
        self.segment = segment;
        self.seek(Objective::Feasible);
        (self.recovery, self.sweeps) = (RecoveryPolicy::default(), 1);
    }
}

/// The searches of all segments, allocated once.
#[derive(Debug)]
pub(crate) struct SegmentSearches {
    searches: [SegmentSearch; SEGMENT_SEARCHES_MAX],
    current: usize,
    /// The first segment without a search.
    next_segment: usize,
}

impl SegmentSearches {
    /// Idle searches.
    pub fn new(config: &PlannerConfig) -> Self {
        let searches = std::array::from_fn(|_| SegmentSearch::new(config));
        Self { searches, current: 0, next_segment: 0 }
    }

    /// The current search.
    pub fn current(&self) -> &SegmentSearch {
        &self.searches[self.current]
    }

    /// The current search, to be changed.
    pub fn current_mut(&mut self) -> &mut SegmentSearch {
        &mut self.searches[self.current]
    }

    /// Makes a search the current one.
    pub fn select(&mut self, index: usize) {
        self.current = index;
    }

    /// The searches that do not wait for another route, with their index.
    pub fn active(&mut self) -> impl Iterator<Item = (usize, &mut SegmentSearch)> {
        let last = self.last_segment();
        self.searches.iter_mut().enumerate().filter(move |(_, search)| search.segment <= last)
    }

    /// Begins with a new route of `segments` segments that have no footholds yet. The failures on
    /// the route before still count.
    pub fn begin_route(&mut self, segments: usize) {
        let recovery = self.current().recovery;
        (self.current, self.next_segment) = (0, 0);
        for search in &mut self.searches {
            search.state = SegmentState::Idle;
            search.step_removals = 0;
            if self.next_segment < segments {
                search.begin(self.next_segment);
                self.next_segment += 1;
            }
        }
        (self.searches[0].recovery, self.searches[0].sweeps) = (recovery, 0);
    }

    /// The current search is complete: it begins with the next of `segments` segments, if one is
    /// left.
    pub fn begin_next(&mut self, segments: usize) {
        let segment = self.next_segment;
        let search = self.current_mut();
        if segment == segments {
            search.state = SegmentState::Idle;
            return;
        }
        search.begin(segment);
        self.next_segment += 1;
    }

    /// Chooses the next task, and makes the search that needs it the current one. Failed searches
    /// come first, then those without a sequence, in parallel with the estimates of others; these
    /// before configurations, and configurations before motions, so that a batch serves as many
    /// segments as possible. A route is left only after all this, which keeps what was traversed.
    /// [`Event::Complete`] means that no task is left.
    pub fn next(&mut self) -> Event {
        let has_failed = |state| matches!(state, SegmentState::Failed | SegmentState::Disconnected);
        if let Some(index) = self.find(has_failed) {
            self.current = index;
            return Event::Failed;
        }
        let waiting = self.find(|state| state == SegmentState::Seek);
        if let Some(index) = waiting {
            self.current = index;
        }
        if self.is_estimating() {
            return Event::NeedsEstimates;
        }
        if waiting.is_some() {
            return Event::NeedsSequence;
        }
        if self.find(|state| matches!(state, SegmentState::Sample { .. })).is_some() {
            return Event::NeedsConfigurations;
        }
        if self.find(|state| matches!(state, SegmentState::Move { .. })).is_some() {
            return Event::NeedsMotions;
        }
        if let Some(index) = self.find(|state| state == SegmentState::Leave) {
            self.current = index;
            return Event::LeaveRoute;
        }
        Event::Complete
    }

    /// Whether a search needs a sequence.
    pub fn needs_sequence(&self) -> bool {
        self.find(|state| state == SegmentState::Seek).is_some()
    }

    /// Whether a search needs estimates.
    pub fn is_estimating(&self) -> bool {
        self.find(|state| state == SegmentState::Estimate).is_some()
    }

    /// The first segment that is to be left, if any. Those after it wait.
    fn last_segment(&self) -> usize {
        let left = self.searches.iter().filter(|search| search.state == SegmentState::Leave);
        left.map(|search| search.segment).min().unwrap_or(usize::MAX)
    }

    /// The first search in such a state that does not wait.
    fn find(&self, is_such: impl Fn(SegmentState) -> bool) -> Option<usize> {
        let last = self.last_segment();
        self.searches.iter().position(|search| search.segment <= last && is_such(search.state))
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        let transitions = |search: &SegmentSearch| {
            (search.sequence.capacity() + search.best.capacity()) * size_of::<TransitionId>()
        };
        self.searches.iter().map(transitions).sum()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn searches(states: [SegmentState; SEGMENT_SEARCHES_MAX]) -> SegmentSearches {
        let config = PlannerConfig { configurations_max: 4, ..PlannerConfig::default() };
        let mut searches = SegmentSearches::new(&config);
        searches.begin_route(SEGMENT_SEARCHES_MAX);
        for (search, state) in searches.searches.iter_mut().zip(states) {
            search.state = state;
        }
        searches
    }

    #[test]
    fn failed_segments_come_first_and_a_route_is_left_last() {
        use SegmentState::{Disconnected, Estimate, Failed, Idle, Leave, Move, Sample, Seek};
        let (sample, move_) = (Sample { next: 0, failed: false }, Move { next: 0, failed: false });
        let next = |states| searches(states).next();
        assert_eq!(next([Seek, Estimate, Disconnected, sample]), Event::Failed);
        assert_eq!(next([Failed, Idle, Idle, Idle]), Event::Failed);
        assert_eq!(next([move_, Seek, Estimate, sample]), Event::NeedsEstimates);
        assert_eq!(next([move_, Seek, Idle, sample]), Event::NeedsSequence);
        assert_eq!(next([move_, Idle, Idle, sample]), Event::NeedsConfigurations);
        assert_eq!(next([move_, Idle, Leave, Idle]), Event::NeedsMotions);
        assert_eq!(next([Idle, Leave, Idle, Idle]), Event::LeaveRoute);
        assert_eq!(next([Idle; SEGMENT_SEARCHES_MAX]), Event::Complete);
    }

    #[test]
    fn segments_after_one_that_is_left_wait() {
        use SegmentState::{Failed, Leave, Seek};
        let mut searches = searches([Seek, Leave, Failed, Seek]);
        assert_eq!(searches.next(), Event::NeedsSequence);
        assert_eq!(searches.current().segment, 0);
        assert_eq!(searches.active().count(), 2);
    }
}
