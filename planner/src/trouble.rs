//! What to do where stage M does not get on, and where along the route [Grey 4.4.4].
//!
//! New placements bring new cheap sequences that distract from old ones. So they are added only
//! once the cheapest sequence has a transition that costs more than is acceptable, or many
//! sequences have failed, ever more rarely, and only near the trouble: first with the feet wider
//! apart and the toes turned out, then at random, then along a detour, then along another route.

use glam::DVec3;

use crate::base::arena::reserve;
use crate::motion::mode_costs::{ModeCosts, ModeId};
use crate::motion::mode_graph::{ModeGraph, TransitionId};
use crate::possibility::{GuideRoute, MidFeetPose};

/// Failed sequences after which more placements are sampled, at first and at the most.
const PATIENCE: [u32; 2] = [24, 192];
/// What a transition of the cheapest sequence may cost before more placements are sampled, at first
/// and at the most, m3: one on which no posture holds, 0.3 m long, is beyond the first from its
/// beginning.
const ACCEPTABLE_COST: [f64; 2] = [3.2, 9.6];
/// Sequences that are tried however dear they are.
const DEAR_SEQUENCES: u32 = 2;
/// TreeVertices on either side of a trouble that get more placements.
const WINDOW: usize = 2;
/// TreeVertices on either side of a trouble that a detour replaces.
const DETOUR_WINDOW: usize = 4;

/// The ways out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Remedy {
    /// Sweep the stations about what is not found once more, the feet wider apart and the toes
    /// turned out.
    Sweep,
    /// Sample placements at random about the transitions that cannot be found.
    Sample,
    /// Send stage P to look for a way around the worst trouble.
    Detour,
    /// Send stage P to look for another route.
    Reroute,
}

/// The ways out, in the order in which they are taken; all but the first again and again.
const REMEDIES: [Remedy; 6] = [
    Remedy::Sweep,
    Remedy::Sample,
    Remedy::Detour,
    Remedy::Sample,
    Remedy::Sample,
    Remedy::Reroute,
];
/// Where the repetition begins.
const REPEATED_FROM: usize = 1;

/// How long sequences have failed, and what was done about it.
#[derive(Debug, Clone, Copy)]
pub struct Trouble {
    failed_sequences: u32,
    patience: u32,
    acceptable_cost: f64,
    remedies: usize,
}

impl Default for Trouble {
    /// None so far.
    fn default() -> Self {
        Self {
            failed_sequences: 0,
            patience: PATIENCE[0],
            acceptable_cost: ACCEPTABLE_COST[0],
            remedies: 0,
        }
    }
}

impl Trouble {
    /// Counts a failed sequence, of which the dearest transition costs so much (m3); answers what
    /// to do, if patience is at its end.
    pub fn sequence_failed(&mut self, dearest: f64) -> Option<Remedy> {
        self.failed_sequences += 1;
        let is_too_dear = dearest > self.acceptable_cost && self.failed_sequences > DEAR_SEQUENCES;
        if self.failed_sequences <= self.patience && !is_too_dear {
            return None;
        }
        self.failed_sequences = 0;
        self.acceptable_cost = (2.0 * self.acceptable_cost).min(ACCEPTABLE_COST[1]);
        self.patience = (2 * self.patience).min(PATIENCE[1]);
        Some(self.next_remedy())
    }

    /// The next way out, where patience is at its end or no sequence leads to the goal.
    pub fn next_remedy(&mut self) -> Remedy {
        let remedy = REMEDIES[self.remedies];
        self.remedies += 1;
        if self.remedies == REMEDIES.len() {
            self.remedies = REPEATED_FROM;
        }
        remedy
    }
}

/// Which stations of the route get placements in a sweep, allocated once.
#[derive(Debug)]
pub struct Focus {
    is_wanted: Vec<bool>,
}

impl Focus {
    /// Room for this many stations.
    pub fn new(tree_vertices_max: usize) -> Self {
        Self { is_wanted: reserve(tree_vertices_max) }
    }

    /// Wants the stations that `is_wanted` says.
    pub fn only(&mut self, stations: usize, is_wanted: impl Fn(usize) -> bool) {
        self.is_wanted.clear();
        self.is_wanted.extend((0..stations).map(is_wanted));
    }

    /// Wants, of so many stations, those about some.
    pub fn only_about(&mut self, stations: usize, some: impl Iterator<Item = usize>) {
        self.only(stations, |_| false);
        for station in some {
            let last = (station + WINDOW + 1).min(stations);
            self.is_wanted[station.saturating_sub(WINDOW)..last].fill(true);
        }
    }

    /// Whether a station is wanted.
    pub fn wants(&self, station: usize) -> bool {
        self.is_wanted[station]
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.is_wanted.capacity()
    }
}

/// The station of a route that is nearest to a place.
pub fn nearest_station(route: &GuideRoute, place: DVec3) -> usize {
    let distance = |index: usize| route.pose(index).position_distance_squared(place);
    let nearer =
        |best: usize, index: usize| if distance(index) < distance(best) { index } else { best };
    (1..route.vertex_count()).fold(0, nearer)
}

/// The ends of a detour about a station: far enough on either side within a segment, or `None`
/// where that is all of it.
pub fn detour_about([first, last]: [usize; 2], station: usize) -> Option<[usize; 2]> {
    let ends =
        [station.saturating_sub(DETOUR_WINDOW).max(first), (station + DETOUR_WINDOW).min(last)];
    (ends != [first, last] && ends[0] < ends[1]).then_some(ends)
}

/// The mode along a sequence with the highest S(sigma), if any was searched in vain; the first of
/// several.
pub fn most_laboured(
    graph: &ModeGraph,
    costs: &ModeCosts,
    sequence: &[TransitionId],
) -> Option<ModeId> {
    let modes = sequence.iter().flat_map(|&id| ModeId::of(graph, id));
    let more = |best: Option<ModeId>, mode: ModeId| {
        let least = best.map_or(1, |best| costs.attempts(best));
        if costs.attempts(mode) > least { Some(mode) } else { best }
    };
    modes.fold(None, more)
}

/// Where a transition's feet stand.
pub fn place_of(graph: &ModeGraph, id: TransitionId) -> MidFeetPose {
    let (stance, other) = graph.pair(id);
    MidFeetPose::of_sole(&stance.world_from_sole)
        .interpolate(&MidFeetPose::of_sole(&other.world_from_sole), 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::constraints::foothold::Foothold;
    use glam::DQuat;
    use surefoot_shared_types::Pose;

    #[test]
    fn patience_grows_and_the_ways_out_take_turns() {
        let mut trouble = Trouble::default();
        let rounds: Vec<(u32, Remedy)> = (0..12)
            .map(|_| {
                let mut failures = 1;
                loop {
                    match trouble.sequence_failed(0.0) {
                        Some(remedy) => break (failures, remedy),
                        None => failures += 1,
                    }
                }
            })
            .collect();
        assert!(rounds.windows(2).all(|pair| pair[0].0 <= pair[1].0));
        assert_eq!(rounds[0], (PATIENCE[0] + 1, Remedy::Sweep));
        assert!(
            rounds[1..6].iter().any(|round| round.1 == Remedy::Detour)
                && rounds[6..].iter().any(|round| round.1 == Remedy::Reroute)
        );
        assert!(rounds[1..].iter().all(|round| round.1 != Remedy::Sweep));
    }

    #[test]
    fn what_is_too_dear_ends_patience_early_and_the_more_remedies_the_later() {
        let failures = |trouble: &mut Trouble, cost: f64| {
            (1..).find(|_| trouble.sequence_failed(cost).is_some()).unwrap()
        };
        let mut trouble = Trouble::default();
        assert_eq!(failures(&mut trouble, 1.5 * ACCEPTABLE_COST[0]), DEAR_SEQUENCES + 1);
        assert!(failures(&mut trouble, 1.5 * ACCEPTABLE_COST[0]) > PATIENCE[0], "acceptable now");
        assert_eq!(failures(&mut trouble, 2.0 * ACCEPTABLE_COST[1]), DEAR_SEQUENCES + 1);
    }

    #[test]
    fn the_most_laboured_mode_is_the_one_searched_in_vain_most() {
        let mut graph = ModeGraph::new(3, 4, 4, 1.0);
        let foothold = |limb, x| {
            Foothold::new(
                limb,
                Pose::from_parts(DVec3::new(x, 0.0, 0.0), DQuat::IDENTITY),
                heapless::Vec::new(),
            )
        };
        let [left, right, ahead] = [(0, 0.0), (1, 0.1), (1, 0.3)]
            .map(|(limb, x)| graph.add_foothold(foothold(limb, x)).unwrap());
        graph.connect(left, right).unwrap();
        graph.connect(left, ahead).unwrap();
        let mut costs = ModeCosts::new(3, 4, 4);
        let sequence = [graph.find(right, left).unwrap(), graph.find(left, ahead).unwrap()];
        assert_eq!(most_laboured(&graph, &costs, &sequence), None, "nothing was searched");
        costs.add_attempts(ModeId::Single(left), 7);
        costs.add_attempts(ModeId::Single(right), 3);
        assert_eq!(most_laboured(&graph, &costs, &sequence), Some(ModeId::Single(left)));
        assert_eq!(
            most_laboured(&graph, &costs, &sequence[..1]),
            Some(ModeId::Single(right)),
            "of this sequence alone"
        );
    }
}
