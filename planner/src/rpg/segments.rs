//! Cutting the route into segments that share their end states, and putting them together: Phi_M and Omega_M [Grey 3.2].
//!
//! Between two segments the robot stands on both feet. So what a segment costs depends on its own length alone, and trouble
//! in one disturbs no other.

use surefoot_shared_types::message::SupportMode;

use super::{Boundary, GOAL, Phase, Planner, Purpose, START, boundary_node};
use crate::arena::reserve;
use crate::ends::{foothold_at, stand};
use crate::motion::graph::{ArenaFull, BOUNDARIES_MAX, TransitionId};
use crate::motion::roadmap::Segment;
use crate::possibility::Placed;
use crate::trouble::{Trouble, nearest_station};

/// Stations of a segment, more where the robot cannot stand there.
const SEGMENT_STATIONS: usize = 36;
/// A segment may step near this many stations beyond its ends.
const MARGIN_STATIONS: usize = 8;
/// How far the ground must be even before and after a boundary, m: about one step.
const EVEN_REACH: f64 = 0.45;
/// How far from its ideal a sole may stand at a boundary and beside it, m: the ground is even and wide there.
const ASIDE_MAX: f64 = 1e-3;

/// Where the route is cut.
#[derive(Debug, Clone, Copy)]
struct Cut {
    boundary: usize,
    station: usize,
}

/// The cuts of the route that is followed, start and goal included, and which segment is being planned.
#[derive(Debug)]
pub struct Cuts {
    cuts: Vec<Cut>,
    current: usize,
}

impl Cuts {
    /// None yet.
    pub fn new() -> Self {
        Self { cuts: reserve(BOUNDARIES_MAX), current: 0 }
    }

    /// The boundaries of the segment that is being planned.
    pub fn boundaries(&self) -> [usize; 2] {
        [0, 1].map(|side| self.cuts[self.current + side].boundary)
    }

    /// The first and the last station of the segment that is being planned.
    pub fn stations(&self) -> [usize; 2] {
        [0, 1].map(|side| self.cuts[self.current + side].station)
    }

    /// The stations near which the segment that is being planned may step.
    pub fn window(&self) -> [u32; 2] {
        let [first, last] = self.stations();
        [first.saturating_sub(MARGIN_STATIONS) as u32, (last + MARGIN_STATIONS) as u32]
    }

    /// The segment that is being planned, along a sequence.
    pub fn segment<'a>(&self, sequence: &'a [TransitionId]) -> Segment<'a> {
        Segment { sequence, ends: self.boundaries().map(boundary_node) }
    }

    fn begin(&mut self) {
        self.current = 0;
        self.cuts.clear();
        self.cuts.push(Cut { boundary: START, station: 0 });
    }

    fn push(&mut self, boundary: usize, station: usize) {
        self.cuts.push(Cut { boundary, station });
    }

    /// The segment that is being planned has got longer by so many stations.
    fn shift(&mut self, more: usize, fewer: usize) {
        for cut in &mut self.cuts[self.current + 1..] {
            cut.station = cut.station + more - fewer;
        }
    }

    fn next(&mut self) -> bool {
        self.current += 1;
        self.current + 1 < self.cuts.len()
    }
}

impl Planner {
    /// After a new route, which now has this many stations: cuts it; after a detour within a segment the cuts stay.
    pub(super) fn cut_anew_or_shift(&mut self, stations: usize) -> Phase {
        match self.stations_before.take() {
            Some(before) => {
                self.cuts.shift(stations, before);
                Phase::Seed { next: 0 }
            }
            None => {
                self.walk.clear();
                self.walk.push(boundary_node(START));
                self.cuts.begin();
                Phase::Cut { station: SEGMENT_STATIONS }
            }
        }
    }

    /// Cuts the route at a station if the robot can stand there, and goes on to the next.
    pub(super) fn cut(&mut self, station: usize) -> Result<Phase, ArenaFull> {
        let stations = self.growth.route().stations();
        if station + SEGMENT_STATIONS / 2 >= stations || self.cuts.cuts.len() + 1 >= BOUNDARIES_MAX {
            self.cuts.push(GOAL, stations - 1);
            return Ok(Phase::Seed { next: 0 });
        }
        let Some(boundary) = self.stand_at(station)? else { return Ok(Phase::Cut { station: station + 1 }) };
        let boundary = self.roadmap.add_boundary(boundary)?;
        self.cuts.push(boundary, station);
        Ok(Phase::Cut { station: station + SEGMENT_STATIONS })
    }

    /// Finds the nearest station of the next placement that is new; of all, one by one, after the route has changed. `false` when
    /// each has one.
    pub(super) fn locate_next(&mut self) -> bool {
        let next = self.roadmap.graph.footholds().get(self.nearest_stations.len());
        let station = next.map(|foothold| nearest_station(self.growth.route(), foothold.world_from_sole.translation));
        self.nearest_stations.extend(station.map(|station| station as u32));
        station.is_some()
    }

    /// Stands the robot at a station where the ground is even and wide, and so it is before and after it.
    fn stand_at(&mut self, station: usize) -> Result<Option<Boundary>, ArenaFull> {
        let ideal = |station: usize, limb: usize| {
            let ideal = self.growth.route().world_from_ideal_sole(station, limb, 1.0);
            let near = |placed: &&Placed| placed.limb == limb && placed.world_from_sole.translation.distance(ideal.translation) < ASIDE_MAX;
            self.growth.placements(station).iter().find(near).map(|placed| placed.world_from_sole)
        };
        let [Some(left), Some(right)] = [0, 1].map(|limb| ideal(station, limb)) else { return Ok(None) };
        let route = self.growth.route();
        let is_even = |beside: usize| [0, 1].iter().all(|&limb| ideal(beside, limb).is_some());
        let is_near = |beside: &usize| route.station(*beside).position.distance(route.station(station).position) < EVEN_REACH;
        let (before, after) = ((0..station).rev(), station + 1..route.stations());
        if !before.take_while(is_near).all(is_even) || !after.take_while(is_near).all(is_even) {
            return Ok(None);
        }
        let constraints = &self.shared.constraints;
        let mut stand_on = |limb, sole| foothold_at(constraints, &self.surfaces, &mut self.scratch[0], limb, sole).ok();
        let [Some(left), Some(right)] = [stand_on(0, &left), stand_on(1, &right)] else { return Ok(None) };
        let placed = [left, right];
        let Ok(state) = stand(constraints, &placed, self.growth.route().station(station).yaw) else { return Ok(None) };
        let graph = &mut self.roadmap.graph;
        let footholds = [graph.identical_or_new(&placed[0])?, graph.identical_or_new(&placed[1])?];
        Ok(Some(Boundary { footholds, state, support: SupportMode::Double }))
    }

    /// Adds the segment to the walk and goes on to the next, or to the end.
    pub(super) fn complete_segment(&mut self) -> Result<Phase, ArenaFull> {
        let [_, to] = self.cuts.boundaries();
        if self.walk.len() + self.search.sequence().len() + 1 > self.walk.capacity() {
            return Err(ArenaFull::Configurations);
        }
        self.walk.extend_from_slice(self.search.sequence());
        self.walk.push(boundary_node(to));
        self.growth.note_crossed(self.cuts.stations()[1]);
        self.trouble = Trouble::default();
        self.route_sweeps = 1;
        if self.cuts.next() { Ok(Phase::seek(Purpose::Find)) } else { Ok(self.polish_or_assemble()) }
    }
}
