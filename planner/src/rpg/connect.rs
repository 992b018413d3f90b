//! Transitions between the placements [Grey 4.4.2].

use crate::base::work_budget::items_in;
use crate::constraints::foothold::{Foothold, left_and_right};
use crate::motion::mode_graph::{ArenaFull, FootholdId};
use crate::possibility::MidFeetPose;
use crate::rpg::{Phase, Planner};
use crate::seeding::{Neighbours, Seeding};
use crate::trouble::nearest_station;

/// Placements that are looked at side by side.
const AT_ONCE: usize = 64;
/// The station of a placement that is not used on the route.
const NOWHERE: u32 = u32::MAX;

type Batch<T> = heapless::Vec<T, AT_ONCE>;

impl Planner {
    /// Connects the next placements with their neighbours, as many as a budget allows, each one
    /// unit of work; once all are, counts each to the nearest station.
    pub(crate) fn connect(&mut self, next: FootholdId, budget: u64) -> Result<Phase, ArenaFull> {
        let count = self.roadmap.graph.footholds().len();
        if next as usize == count {
            return if self.locate_next(budget) {
                Ok(Phase::Connect { next })
            } else {
                self.after_connecting()
            };
        }
        let ids: Batch<FootholdId> =
            (next..count as FootholdId).take(items_in(budget, AT_ONCE)).collect();
        let steps = self.shared.preparation.step_limits();
        let (seeding, graph, stretches) =
            (Seeding::of(&self.shared), &self.roadmap.graph, self.stretches);
        let neighbours = |id: FootholdId| {
            let is_due = |a: &Foothold, b: &Foothold| {
                let soles = left_and_right(a, b).map(|foothold| &foothold.world_from_sole);
                if steps.may_step(soles) { id >= graph.connected() } else { stretches }
            };
            seeding.neighbours(id, steps.reach(), is_due, graph)
        };
        let connected: Batch<Neighbours> = self.shared.threads.map(&ids, neighbours);
        for (&id, neighbours) in ids.iter().zip(connected) {
            self.tally.work += 1;
            for neighbour in neighbours {
                self.roadmap.graph.connect(id, neighbour)?;
            }
            self.roadmap.graph.mark_connected(id);
        }
        Ok(Phase::Connect { next: next + ids.len() as FootholdId })
    }

    /// Finds the nearest stations of the next placements that are new, as many as a budget allows;
    /// of all, after the route has changed. `false` when each has been looked at.
    fn locate_next(&mut self, budget: u64) -> bool {
        let (route, footholds) = (self.growth.route(), self.roadmap.graph.footholds());
        let ids: Batch<usize> = (self.nearest_stations.len()..footholds.len())
            .take(items_in(budget, AT_ONCE))
            .collect();
        let locate = |id: usize| {
            let world_from_sole = &footholds[id].world_from_sole;
            let suits = route.is_aligned_with(&MidFeetPose::of_sole(world_from_sole));
            (nearest_station(route, world_from_sole.translation), suits)
        };
        let located: Batch<(usize, bool)> = self.shared.threads.map(&ids, locate);
        self.tally.work += ids.len().max(1) as u64;
        for (&id, (station, suits)) in ids.iter().zip(located) {
            self.roadmap.graph.set_crouch(id as FootholdId, self.stooping.crouch(station));
            self.nearest_stations.push(if suits { station as u32 } else { NOWHERE });
        }
        !ids.is_empty()
    }

    /// Connects placements, too, that are farther apart than primitive postures reach: they burden
    /// the search, so only where the others lead nowhere.
    pub(crate) fn stretch(&mut self) -> Phase {
        self.stretches = true;
        Phase::Connect { next: 0 }
    }
}
