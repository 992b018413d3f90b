//! Looking for the cheapest sequence of a lane [Grey 4.4.2], by itself or while other lanes' sequences are judged.

use surefoot_shared_types::message::SupportMode;

use super::lanes::{Lane, Lanes, Turn};
use super::segments::Cuts;
use super::{Boundary, Phase, Planner, boundary_node};
use crate::motion::graph::{ArenaFull, Graph, TransitionId};
use crate::motion::roadmap::Roadmap;
use crate::motion::sequence::{Purpose, Query, SequenceSearch};
use crate::threads::Threads;

/// Transitions that a start on one foot leads to at the most; the others are reached through these.
const STARTS_MAX: usize = 256;

/// What a search reads and leaves as it is.
#[derive(Debug, Clone, Copy)]
pub struct Site<'a> {
    pub roadmap: &'a Roadmap,
    pub lanes: &'a Lanes,
    pub cuts: &'a Cuts,
    /// The station nearest to each placement.
    pub stations: &'a [u32],
}

/// The search for a lane's sequence, allocated once.
#[derive(Debug)]
pub struct Seeker {
    search: SequenceSearch,
    /// The lane that it is for, until that has learnt what came of it.
    lane: Option<usize>,
    starts: heapless::Vec<TransitionId, STARTS_MAX>,
    is_going: bool,
}

impl Seeker {
    /// Arrays for this many placements and transitions.
    pub fn new(footholds_max: usize, transitions_max: usize) -> Self {
        let search = SequenceSearch::new(footholds_max, transitions_max);
        Self { search, lane: None, starts: heapless::Vec::new(), is_going: false }
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

    /// Works on something with a budget of its own while the search goes on; answers what each has spent. It has its share of the
    /// budget until it has ended, the rest is the other's.
    pub fn advance_beside<T: Send>(
        &mut self,
        site: Site<'_>,
        threads: &Threads,
        budget: u64,
        work: impl FnOnce(u64) -> T + Send,
    ) -> (u64, T) {
        if !self.is_going {
            return (0, work(budget));
        }
        let share = budget.div_ceil(2);
        threads.both(|| self.advance(site, share), || work(budget - share))
    }

    /// Spends at most so many units of work; answers how many it spent.
    fn advance(&mut self, site: Site<'_>, budget: u64) -> u64 {
        let Some(lane) = self.lane else { return 0 };
        let spent = self.search.advance(&query(site, lane, &self.starts), budget);
        self.is_going = spent == budget;
        spent
    }
}

/// The boundaries between which a lane's sequence leads, in the order in which it is sought.
fn boundaries(cuts: &Cuts, lane: &Lane) -> [usize; 2] {
    let [start, goal] = cuts.boundaries(lane.segment);
    if lane.purpose == Purpose::Return { [goal, start] } else { [start, goal] }
}

fn query<'a>(site: Site<'a>, lane: usize, starts: &'a [TransitionId]) -> Query<'a> {
    let Site { roadmap, lanes, cuts, stations } = site;
    let lane = lanes.lane(lane);
    let [from, to] = boundaries(cuts, lane);
    Query {
        graph: &roadmap.graph,
        edges: &roadmap.edges,
        modes: &roadmap.costs,
        purpose: lane.purpose,
        stations,
        range: cuts.window(lane.segment),
        ends: [from, to].map(boundary_node),
        starts,
        goal: roadmap.boundary(to).footholds,
    }
}

/// The transitions that a boundary leads to: on both feet those between its two placements, on one foot all that this one carries.
fn start_transitions(graph: &Graph, boundary: &Boundary) -> heapless::Vec<TransitionId, STARTS_MAX> {
    let [left, right] = boundary.footholds;
    match boundary.support {
        SupportMode::Left => graph.from_stance(left).take(STARTS_MAX).collect(),
        SupportMode::Right => graph.from_stance(right).take(STARTS_MAX).collect(),
        SupportMode::Double => [graph.find(left, right), graph.find(right, left)].into_iter().flatten().collect(),
    }
}

impl Planner {
    /// Begins to look for the cheapest sequence of a lane.
    pub(super) fn begin_search(&mut self, index: usize) {
        let Self { seeker, roadmap, lanes, cuts, nearest_stations, .. } = self;
        let lane = lanes.lane(index);
        let [from, to] = boundaries(cuts, lane);
        match lane.purpose {
            Purpose::Join => roadmap.costs.spread(&roadmap.graph, [from, to].map(boundary_node)),
            Purpose::Shorten => seeker.search.use_only(&roadmap.graph, &lane.best),
            Purpose::Find | Purpose::Return => {}
        }
        seeker.starts = start_transitions(&roadmap.graph, roadmap.boundary(from));
        (seeker.lane, seeker.is_going) = (Some(index), true);
        let site = Site { roadmap, lanes, cuts, stations: nearest_stations };
        seeker.search.begin(&query(site, index, &seeker.starts));
    }

    /// Looks for the sequence of the lane that waits for it, and does nothing besides.
    pub(super) fn seek_alone(&mut self, budget: u64) -> Result<Phase, ArenaFull> {
        let Self { seeker, roadmap, lanes, cuts, nearest_stations, .. } = self;
        self.tally.work += seeker.advance(Site { roadmap, lanes, cuts, stations: nearest_stations }, budget);
        if seeker.is_going {
            return Ok(Phase::Sequence);
        }
        self.tally.work += 1;
        self.after_search()
    }

    /// Gives the lane for which a sequence was sought, if there is one, its next turn; then goes on.
    pub(super) fn after_search(&mut self) -> Result<Phase, ArenaFull> {
        let Some(lane) = self.seeker.lane.take() else { return self.next_turn() };
        self.lanes.go_to(lane);
        let has_found = self.seeker.search.has_found();
        let is_unjudged = |id: &TransitionId| self.roadmap.graph.is_unjudged(*id);
        match self.lanes.current().purpose {
            Purpose::Find | Purpose::Shorten if has_found && self.seeker.search.sequence().iter().any(is_unjudged) => {
                self.take_sequence(Turn::Judge)?;
            }
            Purpose::Find => {
                self.tally.sequences += 1;
                if has_found { self.take_sequence(Turn::Sample { next: 0, failed: false })? } else { self.after_no_sequence() }
            }
            Purpose::Return => return self.between_frontiers(),
            Purpose::Join if has_found => self.take_sequence(Turn::Move { next: 0, failed: false })?,
            Purpose::Join => self.take_turn(Turn::Fail),
            Purpose::Shorten => self.take_shorter()?,
        }
        self.next_turn()
    }

    /// Makes the sequence that was found the one that the current lane completes, beginning with a turn.
    pub(super) fn take_sequence(&mut self, turn: Turn) -> Result<(), ArenaFull> {
        self.take_turn(turn);
        self.lanes.current_mut().take(self.seeker.search.sequence())
    }
}
