//! Segments planned side by side [Grey 3.2]: each lane takes one of them through the cycle of stage
//! M, and then another.
//!
//! All lanes work on one Gamma_M. Their searches for configurations and motions share rounds; what
//! changes the graph itself, like more placements, happens to one lane at a time.

use surefoot_shared_types::config::PlannerConfig;

use crate::base::arena::reserve;
use crate::motion::mode_graph::{ArenaFull, TransitionId};
use crate::motion::search_batch::SEGMENT_SEARCHES_MAX;
use crate::motion::transition_sequence::Objective;
use crate::rpg::{Phase, Planner};
use crate::trouble::Trouble;

/// What a lane does next.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Turn {
    /// Nothing: there is no segment left for it.
    Rest,
    /// It looks for a sequence.
    Seek,
    /// It has a sequence of which some transitions are to be judged.
    Judge,
    /// It samples its transitions from `next` on; some before have `failed`.
    Sample { next: usize, failed: bool },
    /// It plans its motions from edge `next` on; some before have `failed`.
    Move { next: usize, failed: bool },
    /// It has a sequence that cannot be completed.
    Fail,
    /// Its segment cannot be walked: another route is to be found, once the segments before it are
    /// complete.
    Leave,
}

/// A segment that is being planned.
#[derive(Debug)]
pub struct Lane {
    /// Which segment of the route.
    pub segment: usize,
    /// What comes next.
    pub turn: Turn,
    /// The sequence that is being completed.
    pub sequence: Vec<TransitionId>,
    /// What a sequence is sought for, or was.
    pub objective: Objective,
    /// The farthest station that walks from the segment's start reached where none led to its end.
    pub frontier: usize,
    /// How long sequences have failed.
    pub trouble: Trouble,
    /// Sweeps along this part of the route.
    pub sweeps: usize,
    /// The shortest complete sequence.
    pub best: Vec<TransitionId>,
    /// Attempts to find a shorter one; 0 while none was made.
    pub shortenings: u32,
}

impl Lane {
    fn new(config: &PlannerConfig) -> Self {
        let sequence = || reserve(config.configurations_max as usize);
        Self {
            segment: 0,
            turn: Turn::Rest,
            sequence: sequence(),
            objective: Objective::Feasible,
            frontier: 0,
            trouble: Trouble::default(),
            sweeps: 0,
            best: sequence(),
            shortenings: 0,
        }
    }

    /// Makes a sequence the one that is being completed.
    ///
    /// # Errors
    /// It has more transitions than may have configurations.
    pub fn take(&mut self, sequence: &[TransitionId]) -> Result<(), ArenaFull> {
        if sequence.len() > self.sequence.capacity() {
            return Err(ArenaFull::Configurations);
        }
        self.sequence.clear();
        self.sequence.extend_from_slice(sequence);
        Ok(())
    }

    /// Begins with a segment of which all stations have been swept.
    fn begin(&mut self, segment: usize) {
        (self.segment, self.turn, self.objective) = (segment, Turn::Seek, Objective::Feasible);
        (self.trouble, self.sweeps) = (Trouble::default(), 1);
    }
}

/// The lanes, allocated once.
#[derive(Debug)]
pub struct Lanes {
    lanes: [Lane; SEGMENT_SEARCHES_MAX],
    current: usize,
    /// The first segment that no lane has begun with.
    next_segment: usize,
}

impl Lanes {
    /// Lanes at rest.
    pub fn new(config: &PlannerConfig) -> Self {
        Self { lanes: std::array::from_fn(|_| Lane::new(config)), current: 0, next_segment: 0 }
    }

    /// The lane whose turn it is.
    pub fn current(&self) -> &Lane {
        &self.lanes[self.current]
    }

    /// The same, to be changed.
    pub fn current_mut(&mut self) -> &mut Lane {
        &mut self.lanes[self.current]
    }

    /// Those that do not wait, by their index.
    pub fn going(&mut self) -> impl Iterator<Item = (usize, &mut Lane)> {
        let last = self.last_segment();
        self.lanes.iter_mut().enumerate().filter(move |(_, lane)| lane.segment <= last)
    }

    /// Gives a lane the turn.
    pub fn go_to(&mut self, index: usize) {
        self.current = index;
    }

    /// Begins with a new route of so many segments, which nothing was swept along. Trouble on the
    /// route before still counts.
    pub fn begin_route(&mut self, segments: usize) {
        let trouble = self.current().trouble;
        (self.current, self.next_segment) = (0, 0);
        for lane in &mut self.lanes {
            lane.turn = Turn::Rest;
            lane.shortenings = 0;
            if self.next_segment < segments {
                lane.begin(self.next_segment);
                self.next_segment += 1;
            }
        }
        (self.lanes[0].trouble, self.lanes[0].sweeps) = (trouble, 0);
    }

    /// The current lane's segment is complete: it goes on with the next of so many, if there is
    /// one.
    fn next_segment(&mut self, segments: usize) {
        let segment = self.next_segment;
        let lane = self.current_mut();
        if segment == segments {
            lane.turn = Turn::Rest;
            return;
        }
        lane.begin(segment);
        self.next_segment += 1;
    }

    /// The first segment that is to be left, if any; those beyond wait.
    fn last_segment(&self) -> usize {
        let left = self.lanes.iter().filter(|lane| lane.turn == Turn::Leave);
        left.map(|lane| lane.segment).min().unwrap_or(usize::MAX)
    }

    /// The first lane whose turn is such a one, unless it waits.
    fn find(&self, is_such: impl Fn(Turn) -> bool) -> Option<usize> {
        let last = self.last_segment();
        self.lanes.iter().position(|lane| lane.segment <= last && is_such(lane.turn))
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.lanes
            .iter()
            .map(|lane| {
                (lane.sequence.capacity() + lane.best.capacity()) * size_of::<TransitionId>()
            })
            .sum()
    }
}

impl Planner {
    /// What comes next: lanes that fail go first, then those whose sequences are sought, beside
    /// others whose sequences are judged, before those that sample, and these before those that
    /// move, so that a round serves as many lanes as it can; and all before another route is looked
    /// for, which keeps what they have crossed.
    pub(crate) fn next_turn(&mut self) -> Result<Phase, ArenaFull> {
        if let Some(lane) = self.lanes.find(|turn| turn == Turn::Fail) {
            self.lanes.go_to(lane);
            return self.after_failure();
        }
        let seeking = self.lanes.find(|turn| turn == Turn::Seek);
        if let Some(lane) = seeking {
            self.lanes.go_to(lane);
            self.begin_search();
        }
        if self.lanes.find(|turn| turn == Turn::Judge).is_some() {
            self.begin_judging();
            return Ok(Phase::Judge);
        }
        if seeking.is_some() {
            return Ok(Phase::Sequence);
        }
        if self.lanes.find(|turn| matches!(turn, Turn::Sample { .. })).is_some() {
            return Ok(Phase::Sample);
        }
        if self.lanes.find(|turn| matches!(turn, Turn::Move { .. })).is_some() {
            return Ok(Phase::Move);
        }
        if let Some(lane) = self.lanes.find(|turn| turn == Turn::Leave) {
            self.lanes.go_to(lane);
            return Ok(self.begin_another_route());
        }
        self.join_segments()?;
        Ok(self.polish_or_assemble())
    }

    /// Gives the current lane its next turn.
    pub(crate) fn take_turn(&mut self, turn: Turn) {
        self.lanes.current_mut().turn = turn;
    }

    /// Lets the current lane look for a sequence.
    pub(crate) fn seek(&mut self, objective: Objective) {
        self.lanes.current_mut().objective = objective;
        self.take_turn(Turn::Seek);
    }

    /// Keeps the current lane's sequence as the walk of its segment, and goes on with another
    /// segment.
    pub(crate) fn complete_segment(&mut self) -> Result<(), ArenaFull> {
        let Self { lanes, cuts, .. } = self;
        cuts.complete(lanes.current().segment, &lanes.current().sequence)?;
        lanes.next_segment(cuts.segments());
        if let Some(station) = cuts.crossed() {
            self.growth.mark_traversed(station);
        }
        Ok(())
    }
}
