//! Omega_M where C_S holds: along the possible edges of the guide route, stage M takes what pi_S
//! gives, configurations and motions alike, and searches for nothing [Grey 3.2, 4.4.5].
//!
//! The feet step in turn, each past the other to the next station, as long as C_S lets them; else
//! one closes up first. A step is a swing and a shift, emitted waypoint by waypoint.

use surefoot_shared_types::message::SupportMode;

use crate::constraints::constraints::Rejection;
use crate::ends::End;
use crate::motion::mode_graph::{ArenaFull, ModeGraph, TransitionId};
use crate::motion::roadmap::ModeEdge;
use crate::possibility::{FootPair, GuideRoute, Label};
use crate::preparation::FootPlacement;
use crate::preparation::is_whole;
use crate::primitives::PrimitiveTrajectory;
use crate::robot::mechanism::Mechanism;
use crate::rpg::{Phase, Planner};

/// A transition on two placements: the foot that carries, the foot that touches.
type Node = [FootPlacement; 2];

/// The robot on its way along the route's possible edges.
#[derive(Debug, Clone, Copy, Default)]
pub struct Walker {
    /// The station of the foot that stepped last.
    station: usize,
    /// The transition it is at, the foot that may step next touching; none between stretches.
    at: Option<Node>,
    /// Whether the other foot is a station behind.
    is_open: bool,
    /// A shift that is due, to this transition.
    due: Option<Node>,
}

impl Walker {
    /// The next motion, or `None` at the end of the route.
    fn next(&mut self, route: &GuideRoute) -> Option<[Node; 2]> {
        loop {
            let Some(at) = self.at else {
                self.at = Some(self.enter(route)?);
                continue;
            };
            if let Some(to) = self.due.take() {
                self.at = Some(to);
                return Some([at, to]);
            }
            if let Some(motion) = self.step(route, at) {
                return Some(motion);
            }
            (self.at, self.station) = (None, self.station + 1);
        }
    }

    /// The first transition of the next stretch of possible edges.
    fn enter(&mut self, route: &GuideRoute) -> Option<Node> {
        while self.station + 1 < route.vertex_count() {
            if let (Some(leads), Some(pair)) =
                (leads(route, self.station), route.pair(self.station))
            {
                let lead = usize::from(!leads[0]);
                return Some([pair[1 - lead], pair[lead]]);
            }
            self.station += 1;
        }
        None
    }

    /// The swing, or the shift where the other foot must lead, from a transition; `None` at the end
    /// of a stretch.
    fn step(&mut self, route: &GuideRoute, at: Node) -> Option<[Node; 2]> {
        let [stance, swings] = at;
        let leads = leads(route, self.station);
        let target = match leads {
            Some(leads) if leads[swings.limb] => self.station + 1,
            _ if self.is_open => self.station,
            Some(_) => {
                self.at = Some([swings, stance]);
                return Some([at, [swings, stance]]);
            }
            None => return None,
        };
        let placed = route.pair(target)?[swings.limb];
        (self.is_open, self.station) = (target > self.station, target);
        self.at = Some([stance, placed]);
        self.due = Some([placed, stance]);
        Some([at, [stance, placed]])
    }
}

/// Which feet may lead along the edge that follows a station, if it is possible.
fn leads(route: &GuideRoute, station: usize) -> Option<[bool; 2]> {
    match (station + 1 < route.vertex_count()).then(|| route.label(station + 1)) {
        Some(Label::Primitive { leads }) => Some(leads),
        _ => None,
    }
}

impl Planner {
    /// Where to go on once all placements are connected: to the primitives of a new route, else to
    /// the search.
    pub(crate) fn after_connecting(&mut self) -> Result<Phase, ArenaFull> {
        if self.walker.is_some() { Ok(Phase::Primitive) } else { self.next_turn() }
    }

    /// Begins the next motion along the route's possible edges, unless Gamma_M has it. Once a round
    /// is full or there is no more, all that have begun are emitted side by side.
    pub(crate) fn begin_primitive(&mut self) -> Result<Phase, ArenaFull> {
        if !self.round.is_running() {
            self.round.begin();
        }
        let Some([from, to]) =
            self.walker.as_mut().and_then(|walker| walker.next(self.growth.route()))
        else {
            self.walker = None;
            return Ok(Phase::Emit);
        };
        if let [Some(from), Some(to)] = [self.transition_on(from)?, self.transition_on(to)?]
            && self.roadmap.edges.get(from, to).motion.is_none()
        {
            match self.primitive(ModeEdge { from, to }) {
                Ok(trajectory) => self.round.add_primitive(ModeEdge { from, to }, trajectory),
                Err(_) => self.tally.primitives_failed += 1,
            }
        }
        Ok(if self.round.is_full() { Phase::Emit } else { Phase::Primitive })
    }

    /// The shift or the swing between two transitions.
    fn primitive(&self, edge: ModeEdge) -> Result<PrimitiveTrajectory, Rejection> {
        let (graph, constraints, gait) =
            (&self.roadmap.graph, &self.shared.constraints, self.shared.preparation.gait());
        let (stance, touched) = graph.pair(edge.from);
        if edge.to == ModeGraph::twin(edge.from) {
            PrimitiveTrajectory::shift(constraints, gait, [stance, touched])
        } else {
            PrimitiveTrajectory::swing(constraints, gait, stance, [touched, graph.pair(edge.to).1])
        }
    }

    /// Emits the motions of a round. One that fails, which it never does where C_S holds, is left
    /// to pi_N.
    pub(crate) fn emit_primitives(&mut self, budget: u64) -> Result<Phase, ArenaFull> {
        let Some(round) = self.advance_round(budget)? else { return Ok(Phase::Emit) };
        self.tally.primitives += u64::from(round.found);
        self.tally.primitives_failed += u64::from(round.failures[0]);
        if self.walker.is_some() { Ok(Phase::Primitive) } else { self.next_turn() }
    }

    /// The transition on two placements, added if the graph does not have it; `None` where it has
    /// not both placements.
    fn transition_on(&mut self, node: Node) -> Result<Option<TransitionId>, ArenaFull> {
        let graph = &mut self.roadmap.graph;
        let [Some(stance), Some(other)] =
            node.map(|placed| graph.identical(placed.limb, &placed.world_from_sole))
        else {
            return Ok(None);
        };
        if graph.find(stance, other).is_none() {
            graph.connect(stance, other)?;
        }
        Ok(graph.find(stance, other))
    }
}

/// The pair on which the robot stands at an end, if it does so on both feet.
pub fn pair_on(robot: &Mechanism, end: &End) -> Option<FootPair> {
    let placed = |limb: usize| {
        let foothold = &end.footholds[limb];
        FootPlacement {
            limb,
            world_from_sole: foothold.world_from_sole,
            is_whole: is_whole(robot, limb, &foothold.support),
        }
    };
    (end.support == SupportMode::Double).then(|| [placed(0), placed(1)])
}
