//! What to do where stage M does not get on, and where along the route [Grey 4.4.4].
//!
//! New placements bring new cheap sequences that distract from old ones. So they are added only after many sequences have
//! failed, ever more rarely, and only near the trouble: first along the segment with the feet wider apart, then at random, then along a detour, then
//! along another route.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::spatial::yaw_of;

use crate::arena::reserve;
use crate::motion::graph::{Graph, TransitionId};
use crate::possibility::{Route, Station};

/// Failed sequences after which more placements are sampled, at first and at the most.
const PATIENCE: [u32; 2] = [48, 192];
/// Stations on either side of a trouble that get more placements.
const WINDOW: usize = 2;
/// Stations on either side of a trouble that a detour replaces.
const DETOUR_WINDOW: usize = 4;

/// The ways out.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Remedy {
    /// Sweep the stations of the segment once more.
    Sweep,
    /// Sample placements at random about the transitions that cannot be found.
    Sample,
    /// Send stage P to look for a way around the worst trouble.
    Detour,
    /// Send stage P to look for another route.
    Reroute,
}

/// The ways out, in the order in which they are taken; all but the first again and again.
const REMEDIES: [Remedy; 6] = [Remedy::Sweep, Remedy::Sample, Remedy::Detour, Remedy::Sample, Remedy::Sample, Remedy::Reroute];
/// Where the repetition begins.
const REPEATED_FROM: usize = 1;

/// How long sequences have failed, and what was done about it.
#[derive(Debug, Clone, Copy)]
pub struct Trouble {
    failed_sequences: u32,
    patience: u32,
    remedies: usize,
}

impl Default for Trouble {
    /// None so far.
    fn default() -> Self {
        Self { failed_sequences: 0, patience: PATIENCE[0], remedies: 0 }
    }
}

impl Trouble {
    /// Counts a failed sequence; answers what to do, if patience is at its end.
    pub fn sequence_failed(&mut self) -> Option<Remedy> {
        self.failed_sequences += 1;
        if self.failed_sequences <= self.patience {
            return None;
        }
        self.failed_sequences = 0;
        self.patience = (2 * self.patience).min(PATIENCE[1]);
        Some(self.next_remedy())
    }

    /// What to do where no sequence leads to the goal.
    pub fn no_sequence(&mut self) -> Remedy {
        match self.next_remedy() {
            Remedy::Sample => Remedy::Sweep,
            remedy => remedy,
        }
    }

    fn next_remedy(&mut self) -> Remedy {
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
    pub fn new(stations_max: usize) -> Self {
        Self { is_wanted: reserve(stations_max) }
    }

    /// Wants the stations that `is_wanted` says.
    pub fn only(&mut self, stations: usize, is_wanted: impl Fn(usize) -> bool) {
        self.is_wanted.clear();
        self.is_wanted.extend((0..stations).map(is_wanted));
    }

    /// Wants the stations about one besides.
    pub fn add(&mut self, station: usize) {
        let last = (station + WINDOW + 1).min(self.is_wanted.len());
        self.is_wanted[station.saturating_sub(WINDOW)..last].fill(true);
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
pub fn nearest_station(route: &Route, place: DVec3) -> usize {
    let distance = |index: usize| route.station(index).place_distance_squared(place);
    let nearer = |best: usize, index: usize| if distance(index) < distance(best) { index } else { best };
    (1..route.stations()).fold(0, nearer)
}

/// The ends of a detour about a station: far enough on either side within a segment, or `None` where that is all of it.
pub fn detour_about([first, last]: [usize; 2], station: usize) -> Option<[usize; 2]> {
    let ends = [station.saturating_sub(DETOUR_WINDOW).max(first), (station + DETOUR_WINDOW).min(last)];
    (ends != [first, last] && ends[0] < ends[1]).then_some(ends)
}

/// Where a transition's feet stand.
pub fn place_of(graph: &Graph, id: TransitionId) -> Station {
    let (stance, other) = graph.pair(id);
    let on = |sole: &Pose| Station { position: sole.translation, yaw: yaw_of(sole.rotation) };
    on(&stance.world_from_sole).toward_share(&on(&other.world_from_sole), 0.5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patience_grows_and_the_ways_out_take_turns() {
        let mut trouble = Trouble::default();
        let rounds: Vec<(u32, Remedy)> = (0..12)
            .map(|_| {
                let mut failures = 1;
                loop {
                    match trouble.sequence_failed() {
                        Some(remedy) => break (failures, remedy),
                        None => failures += 1,
                    }
                }
            })
            .collect();
        assert!(rounds.windows(2).all(|pair| pair[0].0 <= pair[1].0));
        assert_eq!(rounds[0], (PATIENCE[0] + 1, Remedy::Sweep));
        assert!(rounds[1..6].iter().any(|round| round.1 == Remedy::Detour) && rounds[6..].iter().any(|round| round.1 == Remedy::Reroute));
        assert!(rounds[1..].iter().all(|round| round.1 != Remedy::Sweep));
    }
}
