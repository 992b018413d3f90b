//! Looking for the cheapest sequence of a lane [Grey 4.4.2], by itself or while other lanes'
//! sequences are judged.

use surefoot_shared_types::message::SupportMode;

use crate::base::threads::Threads;
use crate::motion::mode_graph::{ArenaFull, FootholdId, ModeGraph, TransitionId};
use crate::motion::roadmap::Roadmap;
use crate::motion::transition_sequence::{Objective, SequenceProblem, SequenceSearch};
use crate::rpg::lanes::{Lane, Turn};
use crate::rpg::segments::Cuts;
use crate::rpg::{Boundary, Phase, Planner, boundary_node};

/// Transitions that a start on one foot leads to at the most; the others are reached through these.
const STARTS_MAX: usize = 256;

/// Between what a sequence is sought, and what for.
#[derive(Debug)]
struct Sought {
    objective: Objective,
    /// The first and the last station near which it may step.
    range: [u32; 2],
    /// The nodes before and after it.
    ends: [TransitionId; 2],
    starts: heapless::Vec<TransitionId, STARTS_MAX>,
    goal: [FootholdId; 2],
}

impl Sought {
    /// What the next sequence of a lane has to be. One that returns leads from the segment's end to
    /// its start.
    fn by(lane: &Lane, roadmap: &Roadmap, cuts: &Cuts) -> Self {
        let [start, goal] = cuts.boundaries(lane.segment);
        let [from, to] =
            if lane.objective == Objective::FromGoal { [goal, start] } else { [start, goal] };
        Self {
            objective: lane.objective,
            range: cuts.window(lane.segment),
            ends: [from, to].map(boundary_node),
            starts: start_transitions(&roadmap.graph, roadmap.boundary(from)),
            goal: roadmap.boundary(to).footholds,
        }
    }

    fn query<'a>(&'a self, roadmap: &'a Roadmap, stations: &'a [u32]) -> SequenceProblem<'a> {
        let Self { objective, range, ends, ref starts, goal } = *self;
        let Roadmap { graph, edges, costs: modes, .. } = roadmap;
        SequenceProblem { graph, edges, modes, objective, stations, range, ends, starts, goal }
    }
}

/// The search for the current lane's sequence, allocated once.
#[derive(Debug)]
pub struct Seeker {
    search: SequenceSearch,
    /// What it looks for, until the lane has learnt what came of it.
    sought: Option<Sought>,
    is_going: bool,
}

impl Seeker {
    /// Arrays for this many placements and transitions.
    pub fn new(footholds_max: usize, transitions_max: usize) -> Self {
        Self {
            search: SequenceSearch::new(footholds_max, transitions_max),
            sought: None,
            is_going: false,
        }
    }

    /// The search, with what was found last.
    pub fn search(&self) -> &SequenceSearch {
        &self.search
    }

    /// Whether a search has begun and not ended.
    pub fn is_going(&self) -> bool {
        self.is_going
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.search.bytes()
    }

    /// Works on something with a budget of its own while the search goes on; answers what each has
    /// spent. It has its share of the budget until it has ended, the rest is the other's.
    /// `stations` are the nearest to each placement.
    pub fn advance_beside<T: Send>(
        &mut self,
        (roadmap, stations): (&Roadmap, &[u32]),
        threads: &Threads,
        budget: u64,
        work: impl FnOnce(u64) -> T + Send,
    ) -> (u64, T) {
        if !self.is_going {
            return (0, work(budget));
        }
        let share = budget.div_ceil(2);
        threads.join(|| self.advance(roadmap, stations, share), || work(budget - share))
    }

    /// Spends at most so many units of work; answers how many it spent.
    fn advance(&mut self, roadmap: &Roadmap, stations: &[u32], budget: u64) -> u64 {
        let Some(sought) = &self.sought else { return 0 };
        let spent = self.search.advance(&sought.query(roadmap, stations), budget);
        self.is_going = spent == budget;
        spent
    }
}

/// The transitions that a boundary leads to: on both feet those between its two placements, on one
/// foot all that this one carries.
fn start_transitions(
    graph: &ModeGraph,
    boundary: &Boundary,
) -> heapless::Vec<TransitionId, STARTS_MAX> {
    let [left, right] = boundary.footholds;
    match boundary.support {
        SupportMode::Left => graph.from_stance(left).take(STARTS_MAX).collect(),
        SupportMode::Right => graph.from_stance(right).take(STARTS_MAX).collect(),
        SupportMode::Double => {
            [graph.find(left, right), graph.find(right, left)].into_iter().flatten().collect()
        }
    }
}

impl Planner {
    /// Begins to look for the cheapest sequence of the current lane, which has the turn until it
    /// has learnt what came of it.
    pub(crate) fn begin_search(&mut self) {
        let Self { seeker, roadmap, lanes, cuts, nearest_stations, .. } = self;
        let lane = lanes.current();
        let sought = Sought::by(lane, roadmap, cuts);
        match lane.objective {
            Objective::ConnectModes => {
                roadmap.costs.update_connections(&roadmap.graph, sought.ends)
            }
            Objective::FewerSteps => seeker.search.restrict_to(&roadmap.graph, &lane.best),
            Objective::Feasible | Objective::FromGoal => {}
        }
        seeker.search.begin(&sought.query(roadmap, nearest_stations));
        (seeker.sought, seeker.is_going) = (Some(sought), true);
    }

    /// Looks for the current lane's sequence, and does nothing besides.
    pub(crate) fn seek_alone(&mut self, budget: u64) -> Result<Phase, ArenaFull> {
        self.tally.work += self.seeker.advance(&self.roadmap, &self.nearest_stations, budget);
        if self.seeker.is_going {
            return Ok(Phase::Sequence);
        }
        self.tally.work += 1;
        self.after_search()
    }

    /// Gives the current lane its next turn, if a sequence was sought for it; then goes on.
    pub(crate) fn after_search(&mut self) -> Result<Phase, ArenaFull> {
        let Some(Sought { objective, .. }) = self.seeker.sought.take() else {
            return self.next_turn();
        };
        let has_found = self.seeker.search.has_found();
        let is_unestimated = |id: &TransitionId| self.roadmap.graph.is_unestimated(*id);
        match objective {
            Objective::Feasible | Objective::FewerSteps
                if has_found && self.seeker.search.sequence().iter().any(is_unestimated) =>
            {
                self.take_sequence(Turn::Judge)?;
            }
            Objective::Feasible => {
                self.tally.sequences += 1;
                if has_found {
                    self.take_sequence(Turn::Sample { next: 0, failed: false })?
                } else {
                    self.after_no_sequence()
                }
            }
            Objective::FromGoal => return self.between_frontiers(),
            Objective::ConnectModes if has_found => {
                self.take_sequence(Turn::Move { next: 0, failed: false })?
            }
            Objective::ConnectModes => self.take_turn(Turn::Fail),
            Objective::FewerSteps => self.take_shorter()?,
        }
        self.next_turn()
    }

    /// Makes the sequence that was found the one that the current lane completes, beginning with a
    /// turn.
    pub(crate) fn take_sequence(&mut self, turn: Turn) -> Result<(), ArenaFull> {
        self.take_turn(turn);
        self.lanes.current_mut().take(self.seeker.search.sequence())
    }
}
