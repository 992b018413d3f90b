//! What the planner does where a segment cannot be completed.

use super::{Phase, Planner, Purpose};
use crate::motion::graph::{ArenaFull, TransitionId};
use crate::motion::mode_costs::ModeId;
use crate::possibility::Station;
use crate::seeding::Seeding;
use crate::trouble::{Remedy, detour_about, most_laboured, nearest_station, place_of};

/// Around both ends (m, in the metric of Gamma_P) no place is given up: every route passes there.
const END_RADIUS: f64 = 0.6;

impl Planner {
    /// What to do after a sequence could not be completed: try the next one, or sample more placements near the trouble.
    pub(super) fn after_failure(&mut self) -> Result<Phase, ArenaFull> {
        let segment = self.cuts.segment(self.search.sequence());
        let sequence = segment.sequence;
        let cost = |id: &TransitionId| self.roadmap.graph.transitions()[*id as usize].cost();
        let dearest = sequence.iter().map(cost).fold(0.0, f64::max);
        let Some(remedy) = self.trouble.sequence_failed(dearest) else { return Ok(Phase::seek(Purpose::Find)) };
        let unsolved = |index: &usize| self.roadmap.is_unsolved(segment, *index);
        let attempts = |index: &usize| self.roadmap.graph.transitions()[sequence[*index] as usize].attempts;
        let worst = (0..sequence.len()).filter(unsolved).max_by_key(attempts).unwrap_or(0);
        let place = place_of(&self.roadmap.graph, sequence[worst]);
        let route = self.growth.route();
        match remedy {
            Remedy::Sweep => {
                let [first, last] = self.cuts.stations();
                self.focus.only(route.stations(), |station| (first..=last).contains(&station));
                Ok(Phase::Seed { next: 0 })
            }
            Remedy::Sample => self.sample_near_trouble(),
            Remedy::Detour => Ok(self.look_for_detour(nearest_station(route, place.position), place)),
            Remedy::Reroute => Ok(self.look_for_another_route(place)),
        }
    }

    /// What to do where no sequence leads to the goal: sample more placements where those reached from the start end.
    pub(super) fn after_no_sequence(&mut self) -> Phase {
        let route = self.growth.route();
        let [first, last] = self.cuts.stations();
        let stations = self.search.entered().iter().map(|&id| self.nearest_stations[id as usize] as usize);
        let frontier = stations.filter(|station| (first..=last).contains(station)).max().unwrap_or(first);
        match self.trouble.no_sequence() {
            Remedy::Sweep | Remedy::Sample => {
                self.focus.only(route.stations(), |_| false);
                self.focus.add(frontier);
                Phase::Seed { next: 0 }
            }
            Remedy::Detour => self.look_for_detour(frontier, route.station(frontier)),
            Remedy::Reroute => self.look_for_another_route(route.station(frontier)),
        }
    }

    /// Sends stage P to look for a way around a place where stage M gets no farther.
    fn look_for_detour(&mut self, station: usize, place: Station) -> Phase {
        let Some(between) = detour_about(self.cuts.stations(), station) else { return self.look_for_another_route(place) };
        self.give_up(place);
        self.growth.begin_detour(between);
        self.stations_before = Some(self.growth.route().stations());
        Phase::Route
    }

    /// Sends stage P to look for a route that avoids a place where stage M gets no farther.
    fn look_for_another_route(&mut self, place: Station) -> Phase {
        self.give_up(place);
        self.growth.begin_again();
        self.stations_before = None;
        Phase::Route
    }

    fn give_up(&mut self, place: Station) {
        let ends = [self.scenario.start, self.scenario.goal].map(|mark| Station::on(&mark));
        if ends.iter().all(|end| end.distance(&place) > END_RADIUS) {
            self.growth.give_up(place);
        }
    }

    /// Samples placements about those of the sequence's transitions that have no configuration yet, and about those of the mode at
    /// which the search has laboured most [Grey 4.4.4].
    fn sample_near_trouble(&mut self) -> Result<Phase, ArenaFull> {
        let seeding = Seeding { constraints: &self.shared.constraints, surfaces: &self.surfaces, seed: self.scenario.seed };
        let most = most_laboured(&self.roadmap.graph, &self.roadmap.costs, self.search.sequence());
        for &id in self.search.sequence() {
            let transition = &self.roadmap.graph.transitions()[id as usize];
            if transition.is_found() && most.is_none_or(|mode| !ModeId::of(&self.roadmap.graph, id).contains(&mode)) {
                continue;
            }
            for foothold in [transition.stance, transition.other] {
                let placement = &self.roadmap.graph.footholds()[foothold as usize];
                let (limb, pose) = (placement.limb, placement.world_from_sole);
                let name = (u64::from(id) | 1 << 41, self.tally.sequences);
                seeding.sample_about(&pose, limb, name, &mut self.roadmap.graph, &mut self.scratch)?;
            }
        }
        Ok(Phase::Connect { next: self.roadmap.graph.connected() })
    }
}
