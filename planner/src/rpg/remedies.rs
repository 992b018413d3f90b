//! What the planner does where a segment cannot be completed.

use std::ops::Range;

use surefoot_shared_types::config::scenario::Scenario;

use crate::base::work_budget::items_in;
use crate::constraints::foothold::Foothold;
use crate::foot_placement::Scratch;
use crate::motion::mode_costs::ModeId;
use crate::motion::mode_graph::{ArenaFull, TransitionId};
use crate::motion::transition_sampling::ATTEMPTS_MAX;
use crate::motion::transition_sequence::Objective;
use crate::possibility::{MidFeetPose, RouteSearch};
use crate::rpg::lanes::{Lane, Turn};
use crate::rpg::{Phase, Planner};
use crate::seeding::{Seeding, VARIATIONS_MAX};
use crate::trouble::{Remedy, detour_about, most_laboured, nearest_station, place_of};

/// Around both ends (m, in the metric of Gamma_P) no place is given up: every route passes there.
const END_RADIUS: f64 = 0.6;
/// A new route keeps this far (m, in the metric of Gamma_P) from a place that is given up.
const GIVEN_UP_RADIUS: f64 = 0.25;
/// The same after many routes in vain: what is nearer has much the same steps.
const LATE_GIVEN_UP_RADIUS: f64 = 0.6;
/// That many routes, detours included.
const MANY_ROUTES: u64 = 5;
/// S(T) at which the placements of a transition are varied, once: after its second round of
/// attempts in vain, or the first where no primitive posture holds on it.
const VARIED_AT: Range<u32> = 2 * ATTEMPTS_MAX + 1..3 * ATTEMPTS_MAX + 1;

impl Planner {
    /// What to do after a sequence could not be completed: try the next one, or sample more
    /// placements near the trouble.
    pub(crate) fn after_failure(&mut self) -> Result<Phase, ArenaFull> {
        self.seek(Objective::Feasible);
        let lane = self.lanes.current_mut();
        let cost = |id: &TransitionId| self.roadmap.graph.transitions()[*id as usize].cost();
        let dearest = lane.sequence.iter().map(cost).fold(0.0, f64::max);
        let remedy = lane.trouble.sequence_failed(dearest);
        let segment = self.cuts.segment(lane);
        let sequence = segment.sequence;
        let unsolved = |index: &usize| self.roadmap.is_unsolved(segment, *index);
        let attempts =
            |index: &usize| self.roadmap.graph.transitions()[sequence[*index] as usize].attempts;
        let worst = (0..sequence.len()).filter(unsolved).max_by_key(attempts).unwrap_or(0);
        let place = place_of(&self.roadmap.graph, sequence[worst]);
        self.hindrances.note(place);
        let route = self.growth.route();
        match remedy {
            None => self.try_another(worst),
            Some(Remedy::Sweep) => {
                let nearest = |index: usize| {
                    nearest_station(route, place_of(&self.roadmap.graph, sequence[index]).position)
                };
                self.focus.only_about(
                    route.vertex_count(),
                    (0..sequence.len()).filter(unsolved).map(nearest),
                );
                Ok(Phase::Seed { next: 0 })
            }
            Some(Remedy::Sample) => Ok(Phase::Scatter { index: 0 }),
            Some(Remedy::Detour) => {
                self.look_for_detour(nearest_station(route, place.position), place)
            }
            Some(Remedy::Reroute) => {
                let radius = reroute_radius(self.tally.routes);
                for index in (0..sequence.len()).filter(unsolved) {
                    give_up(
                        &mut self.growth,
                        &self.scenario,
                        place_of(&self.roadmap.graph, sequence[index]),
                        radius,
                    );
                }
                self.look_for_another_route(place)
            }
        }
    }

    /// Goes on to the next sequence; varies the transition at an index of this one before, if it is
    /// time.
    fn try_another(&mut self, index: usize) -> Result<Phase, ArenaFull> {
        let transition = self
            .lanes
            .current()
            .sequence
            .get(index)
            .map(|&id| &self.roadmap.graph.transitions()[id as usize]);
        if transition.is_some_and(|transition| {
            !transition.is_found() && VARIED_AT.contains(&transition.attempts)
        }) {
            return Ok(Phase::Vary { index, tried: 0, end: index + 1 });
        }
        self.next_turn()
    }

    /// Where no sequence leads to the goal, notes how far walks lead from the start, and asks how
    /// far they lead from the goal.
    pub(crate) fn after_no_sequence(&mut self) {
        let [first, _] = self.cuts.stations(self.lanes.current().segment);
        self.lanes.current_mut().frontier = self.entered_stations().max().unwrap_or(first);
        self.seek(Objective::FromGoal);
    }

    /// What to do between what the start reaches and what the goal reaches: sample more placements
    /// at both edges [Grey 4.4.4].
    pub(crate) fn between_frontiers(&mut self) -> Result<Phase, ArenaFull> {
        self.seek(Objective::Feasible);
        let Lane { segment, frontier, .. } = *self.lanes.current();
        let [_, last] = self.cuts.stations(segment);
        let frontiers = [frontier, self.entered_stations().min().unwrap_or(last)];
        let route = self.growth.route();
        self.hindrances.note(route.pose(frontier));
        match self.lanes.current_mut().trouble.next_remedy() {
            Remedy::Sweep | Remedy::Sample => {
                self.focus.only_about(route.vertex_count(), frontiers.into_iter());
                Ok(Phase::Seed { next: 0 })
            }
            Remedy::Detour => self.look_for_detour(frontier, route.pose(frontier)),
            Remedy::Reroute if !self.stretches => Ok(self.stretch()),
            Remedy::Reroute => self.look_for_another_route(route.pose(frontier)),
        }
    }

    /// The stations of the segment near which the last search entered a stance.
    fn entered_stations(&self) -> impl Iterator<Item = usize> + '_ {
        let [first, last] = self.cuts.stations(self.lanes.current().segment);
        let stations = self
            .seeker
            .search()
            .expanded()
            .iter()
            .map(|&id| self.nearest_stations[id as usize] as usize);
        stations.filter(move |station| (first..=last).contains(station))
    }

    /// Sends stage P to look for a way around a place where stage M gets no farther.
    fn look_for_detour(&mut self, station: usize, place: MidFeetPose) -> Result<Phase, ArenaFull> {
        let stations = self.cuts.stations(self.lanes.current().segment);
        let Some(between) = detour_about(stations, station) else {
            return self.look_for_another_route(place);
        };
        give_up(&mut self.growth, &self.scenario, place, GIVEN_UP_RADIUS);
        self.growth.begin_detour(between);
        self.stations_before = Some(self.growth.route().vertex_count());
        Ok(Phase::Route)
    }

    /// Gives up a place where stage M gets no farther, and with it the route.
    fn look_for_another_route(&mut self, place: MidFeetPose) -> Result<Phase, ArenaFull> {
        give_up(&mut self.growth, &self.scenario, place, reroute_radius(self.tally.routes));
        self.take_turn(Turn::Leave);
        self.next_turn()
    }

    /// Sends stage P to look for another route.
    pub(crate) fn begin_another_route(&mut self) -> Phase {
        self.seek(Objective::Feasible);
        self.growth.restart();
        self.stations_before = None;
        Phase::Route
    }

    /// Samples placements about those of the transition at an index of the sequence, where it has
    /// no configuration yet or belongs to the mode at which the search has laboured most
    /// [Grey 4.4.4]. Both placements are moved and turned alike, so that the step stays about what
    /// it is.
    pub(crate) fn scatter(&mut self, index: usize) -> Result<Phase, ArenaFull> {
        let sequence = &self.lanes.current().sequence;
        let Some(&id) = sequence.get(index) else {
            return Ok(Phase::Vary { index: 0, tried: 0, end: sequence.len() });
        };
        let graph = &mut self.roadmap.graph;
        let transition = &graph.transitions()[id as usize];
        let (is_found, footholds) = (transition.is_found(), [transition.stance, transition.other]);
        let is_most_laboured = |mode| ModeId::of(graph, id).contains(&mode);
        if !is_found
            || most_laboured(graph, &self.roadmap.costs, sequence).is_some_and(is_most_laboured)
        {
            let seeding = Seeding::of(&self.shared);
            for foothold in footholds {
                let placement = &graph.footholds()[foothold as usize];
                let (limb, pose) = (placement.limb, placement.world_from_sole);
                let name = (u64::from(id) | 1 << 41, self.tally.sequences);
                seeding.sample_about(&pose, limb, name, graph, &mut self.scratch[0])?;
            }
        }
        Ok(Phase::Scatter { index: index + 1 })
    }

    /// Varies the transition at an index of the sequence, unless it has a configuration: both its
    /// placements at a time, since a step at the edge of the robot's reach is found where either of
    /// them would have to be just right for the other.
    pub(crate) fn vary(
        &mut self,
        index: usize,
        tried: usize,
        end: usize,
        budget: u64,
    ) -> Result<Phase, ArenaFull> {
        let Some(&id) = self.lanes.current().sequence[..end].get(index) else {
            self.tally.work += 1;
            return Ok(Phase::Connect { next: self.roadmap.graph.connected() });
        };
        let next = Phase::Vary { index: index + 1, tried: 0, end };
        if tried == VARIATIONS_MAX || self.roadmap.graph.transitions()[id as usize].is_found() {
            self.tally.work += 1;
            return Ok(next);
        }
        let tries = tried..VARIATIONS_MAX.min(tried + items_in(budget, VARIATIONS_MAX));
        let drawn = self.first_variation(id, tries.clone());
        let drawn_last = drawn.as_ref().map_or(tries.end, |(last, _)| last + 1);
        self.tally.work += (drawn_last - tried) as u64;
        let Some((_, footholds)) = drawn else {
            return Ok(Phase::Vary { index, tried: drawn_last, end });
        };
        for foothold in footholds {
            self.roadmap.graph.add_foothold(foothold)?;
        }
        Ok(next)
    }

    /// The first of several variations of a transition that is possible, and which.
    fn first_variation(
        &mut self,
        id: TransitionId,
        tries: Range<usize>,
    ) -> Option<(usize, [Foothold; 2])> {
        let seeding = Seeding::of(&self.shared);
        let (graph, sequences) = (&self.roadmap.graph, self.tally.sequences);
        let vary = |tried: usize, scratch: &mut Scratch| {
            seeding.variation(id, (tried as u64, sequences), graph, scratch)
        };
        self.shared.threads.find_first(tries, self.scratch.each_mut(), vary)
    }
}

/// How far another route keeps away from what was given up after so many routes.
fn reroute_radius(routes: u64) -> f64 {
    if routes < MANY_ROUTES { GIVEN_UP_RADIUS } else { LATE_GIVEN_UP_RADIUS }
}

/// Gives up a place and what is within a radius of it, unless it is so near to an end that every
/// route passes there.
fn give_up(growth: &mut RouteSearch, scenario: &Scenario, place: MidFeetPose, radius: f64) {
    let ends = [scenario.start, scenario.goal].map(|mark| MidFeetPose::of_stance(&mark));
    if ends.iter().all(|end| end.distance(&place) > END_RADIUS) {
        growth.block(place, radius);
    }
}
