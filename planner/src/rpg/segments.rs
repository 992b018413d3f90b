//! Cutting the route into segments that share their end states, and putting them together: Phi_M
//! and Omega_M [Grey 3.2].
//!
//! Between two segments the robot stands on both feet. So what a segment costs depends on its own
//! length alone.

use surefoot_shared_types::message::SupportMode;

use crate::base::arena::reserve;
use crate::ends::{foothold_at, stand};
use crate::motion::mode_graph::{ArenaFull, BOUNDARIES_MAX, TransitionId};
use crate::motion::roadmap::RouteSegment;
use crate::preparation::FootPlacement;
use crate::rpg::lanes::Lane;
use crate::rpg::{Boundary, GOAL, Phase, Planner, START, boundary_node};

/// TreeVertices of a segment, more where the robot cannot stand there.
const SEGMENT_STATIONS: usize = 36;
/// A segment may step near this many stations beyond its ends.
const MARGIN_STATIONS: usize = 8;
/// How far the ground must be even before and after a boundary, m: about one step.
const EVEN_REACH: f64 = 0.45;
/// How far from its ideal a sole may stand at a boundary and beside it, m: the ground is even and
/// wide there.
const ASIDE_MAX: f64 = 1e-3;

/// Where the route is cut.
#[derive(Debug, Clone, Copy)]
struct Cut {
    boundary: usize,
    station: usize,
    /// The walk from here to the next cut once it is complete: first and count in the arena.
    walk: Option<(usize, usize)>,
}

/// The cuts of the route that is followed, start and goal included, and the walks between them that
/// are complete.
#[derive(Debug)]
pub struct Cuts {
    cuts: Vec<Cut>,
    walks: Vec<TransitionId>,
}

impl Cuts {
    /// None yet, and room for walks of so many transitions.
    pub fn new(transitions_max: usize) -> Self {
        Self { cuts: reserve(BOUNDARIES_MAX), walks: reserve(transitions_max) }
    }

    /// How many segments there are.
    pub fn segments(&self) -> usize {
        self.cuts.len() - 1
    }

    /// The boundaries of a segment.
    pub fn boundaries(&self, segment: usize) -> [usize; 2] {
        [segment, segment + 1].map(|cut| self.cuts[cut].boundary)
    }

    /// The first and the last station of a segment.
    pub fn stations(&self, segment: usize) -> [usize; 2] {
        [segment, segment + 1].map(|cut| self.cuts[cut].station)
    }

    /// The stations near which a segment may step.
    pub fn window(&self, segment: usize) -> [u32; 2] {
        let [first, last] = self.stations(segment);
        [first.saturating_sub(MARGIN_STATIONS) as u32, (last + MARGIN_STATIONS) as u32]
    }

    /// What a lane plans: its segment, along its sequence.
    pub fn segment<'a>(&self, lane: &'a Lane) -> RouteSegment<'a> {
        RouteSegment {
            sequence: &lane.sequence,
            ends: self.boundaries(lane.segment).map(boundary_node),
        }
    }

    /// Keeps the walk of a segment.
    ///
    /// # Errors
    /// It does not fit.
    pub fn complete(&mut self, segment: usize, walk: &[TransitionId]) -> Result<(), ArenaFull> {
        if self.walks.len() + walk.len() > self.walks.capacity() {
            return Err(ArenaFull::Configurations);
        }
        self.cuts[segment].walk = Some((self.walks.len(), walk.len()));
        self.walks.extend_from_slice(walk);
        Ok(())
    }

    /// How far walks that are complete lead from the start, as a station; `None` where the first is
    /// not.
    pub fn crossed(&self) -> Option<usize> {
        let complete = self.cuts.iter().take_while(|cut| cut.walk.is_some()).count();
        (complete > 0).then(|| self.cuts[complete].station)
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.cuts.capacity() * size_of::<Cut>() + self.walks.capacity() * size_of::<TransitionId>()
    }

    fn begin(&mut self) {
        self.walks.clear();
        self.cuts.clear();
        self.push(START, 0);
    }

    fn push(&mut self, boundary: usize, station: usize) {
        self.cuts.push(Cut { boundary, station, walk: None });
    }

    /// A detour in a segment has changed how many stations the route has.
    fn shift(&mut self, segment: usize, before: usize, now: usize) {
        for cut in &mut self.cuts[segment + 1..] {
            cut.station = cut.station + now - before;
        }
    }
}

impl Planner {
    /// After a new route: cuts it; after a detour within a segment the cuts stay.
    pub(crate) fn cut_anew_or_shift(&mut self) -> Phase {
        match self.stations_before.take() {
            Some(before) => {
                self.cuts.shift(
                    self.lanes.current().segment,
                    before,
                    self.growth.route().vertex_count(),
                );
                self.lanes.current_mut().sweeps = 0;
                Phase::Seed { next: 0 }
            }
            None => {
                self.cuts.begin();
                Phase::Cut { station: SEGMENT_STATIONS }
            }
        }
    }

    /// Cuts the route at a station if the robot can stand there, and goes on to the next.
    pub(crate) fn cut(&mut self, station: usize) -> Result<Phase, ArenaFull> {
        let stations = self.growth.route().vertex_count();
        if station + SEGMENT_STATIONS / 2 >= stations || self.roadmap.is_full_of_boundaries() {
            self.cuts.push(GOAL, stations - 1);
            self.lanes.begin_route(self.cuts.segments());
            return Ok(Phase::Seed { next: 0 });
        }
        let Some(boundary) = self.stand_at(station)? else {
            return Ok(Phase::Cut { station: station + 1 });
        };
        let boundary = self.roadmap.add_boundary(boundary);
        self.cuts.push(boundary, station);
        Ok(Phase::Cut { station: station + SEGMENT_STATIONS })
    }

    /// Stands the robot at a station where the ground is even and wide, and so it is before and
    /// after it.
    fn stand_at(&mut self, station: usize) -> Result<Option<Boundary>, ArenaFull> {
        let ideal = |station: usize, limb: usize| {
            let ideal = self.growth.route().world_from_ideal_sole(station, limb, 1.0);
            let near = |placed: &&FootPlacement| {
                placed.limb == limb
                    && placed.world_from_sole.translation.distance(ideal.translation) < ASIDE_MAX
            };
            self.growth.placements(station).iter().find(near).map(|placed| placed.world_from_sole)
        };
        let [Some(left), Some(right)] = [0, 1].map(|limb| ideal(station, limb)) else {
            return Ok(None);
        };
        let route = self.growth.route();
        let is_even = |beside: usize| [0, 1].iter().all(|&limb| ideal(beside, limb).is_some());
        let is_near = |beside: &usize| {
            route.pose(*beside).position.distance(route.pose(station).position) < EVEN_REACH
        };
        let (before, after) = ((0..station).rev(), station + 1..route.vertex_count());
        if !before.take_while(is_near).all(is_even) || !after.take_while(is_near).all(is_even) {
            return Ok(None);
        }
        let constraints = &self.shared.constraints;
        let mut stand_on = |limb, sole| {
            foothold_at(constraints, &self.shared.surfaces, &mut self.scratch[0], limb, sole).ok()
        };
        let [Some(left), Some(right)] = [stand_on(0, &left), stand_on(1, &right)] else {
            return Ok(None);
        };
        let placed = [left, right];
        let Ok(state) = stand(constraints, &placed, self.growth.route().pose(station).yaw) else {
            return Ok(None);
        };
        let graph = &mut self.roadmap.graph;
        let footholds = [graph.identical_or_new(&placed[0])?, graph.identical_or_new(&placed[1])?];
        Ok(Some(Boundary { footholds, state, support: SupportMode::Double }))
    }

    /// Puts the walks of all segments together.
    ///
    /// # Errors
    /// The walk is too long.
    pub(crate) fn join_segments(&mut self) -> Result<(), ArenaFull> {
        self.walk.clear();
        for cut in &self.cuts.cuts {
            let (first, count) = cut.walk.unwrap_or_default();
            if self.walk.len() + count + 1 > self.walk.capacity() {
                return Err(ArenaFull::Configurations);
            }
            self.walk.push(boundary_node(cut.boundary));
            self.walk.extend_from_slice(&self.cuts.walks[first..first + count]);
        }
        Ok(())
    }
}
