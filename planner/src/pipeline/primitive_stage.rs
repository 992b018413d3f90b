//! Omega_M where C_S holds: along the possible edges of the guide route, stage M takes the
//! configurations and motions of pi_S, without any search [Grey 3.2, 4.4.5].
//!
//! The feet step in turn, each past the other to the next vertex, as long as C_S lets them; else
//! one foot first closes up to the other. A step is a swing and a shift of weight.

use crate::base::capacity::ArenaFull;
use crate::constraints::foothold::FootPlacement;
use crate::constraints::rejection::Rejection;
use crate::motion::ids::TransitionId;
use crate::motion::mode_graph::ModeGraph;
use crate::motion::roadmap::ModeEdge;
use crate::pipeline::search::Search;
use crate::pipeline::stage::Event;
use crate::possibility::{GuideRoute, Label};
use crate::preparation::planning_context::PlanningContext;
use crate::primitives::PrimitiveTrajectory;

/// A transition on two placements: the foot that carries, and the foot that touches.
type Node = [FootPlacement; 2];

/// Steps along the possible edges of a route.
#[derive(Debug, Clone, Copy, Default)]
struct PrimitiveStepper {
    /// The vertex of the foot that stepped last.
    vertex: usize,
    /// The current transition, the foot that may step next touching; none between two runs of
    /// possible edges.
    at: Option<Node>,
    /// Whether the other foot is a vertex behind.
    is_open: bool,
    /// A shift of weight that is due, to this transition.
    due: Option<Node>,
}

impl PrimitiveStepper {
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
            (self.at, self.vertex) = (None, self.vertex + 1);
        }
    }

    /// The first transition of the next run of possible edges.
    fn enter(&mut self, route: &GuideRoute) -> Option<Node> {
        while self.vertex + 1 < route.vertex_count() {
            if let (Some(leads), Some(pair)) = (leads(route, self.vertex), route.pair(self.vertex))
            {
                let lead = usize::from(!leads[0]);
                return Some([pair[1 - lead], pair[lead]]);
            }
            self.vertex += 1;
        }
        None
    }

    /// The swing from a transition, or the shift of weight where the other foot must lead; `None`
    /// at the end of a run of possible edges.
    fn step(&mut self, route: &GuideRoute, at: Node) -> Option<[Node; 2]> {
        let [stance, swings] = at;
        let leads = leads(route, self.vertex);
        let target = match leads {
            Some(leads) if leads[swings.limb] => self.vertex + 1,
            _ if self.is_open => self.vertex,
            Some(_) => {
                self.at = Some([swings, stance]);
                return Some([at, [swings, stance]]);
            }
            None => return None,
        };
        let placed = route.pair(target)?[swings.limb];
        (self.is_open, self.vertex) = (target > self.vertex, target);
        self.at = Some([stance, placed]);
        self.due = Some([placed, stance]);
        Some([at, [stance, placed]])
    }
}

/// Which feet may lead along the edge that follows a vertex, if it is possible.
fn leads(route: &GuideRoute, vertex: usize) -> Option<[bool; 2]> {
    match (vertex + 1 < route.vertex_count()).then(|| route.label(vertex + 1)) {
        Some(Label::Primitive { leads }) => Some(leads),
        _ => None,
    }
}

/// Adds the motions of pi_S along the possible edges of a new route, in batches. One unit of work
/// for each motion that begins, and one for each waypoint.
#[derive(Debug, Default)]
pub(crate) struct PrimitiveStage {
    stepper: PrimitiveStepper,
    /// Whether the batch is complete and its waypoints are being computed.
    is_sampling: bool,
    is_at_end: bool,
}

impl PrimitiveStage {
    /// Begins the next motion, or computes waypoints of the batch.
    ///
    /// # Errors
    /// An arena is full.
    pub fn step(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        budget: u64,
    ) -> Result<Event, ArenaFull> {
        if !self.is_sampling {
            search.stats.work += 1;
            self.begin_motion(context, search)?;
            return Ok(Event::Continue);
        }
        let Some(batch) = search.advance_batch(context, budget)? else {
            return Ok(Event::Continue);
        };
        search.stats.primitives += u64::from(batch.found);
        search.stats.primitives_failed += u64::from(batch.failures[0]);
        self.is_sampling = false;
        if !self.is_at_end {
            return Ok(Event::Continue);
        }
        *self = Self::default();
        Ok(Event::Done)
    }

    /// Begins the next motion along the route's possible edges, unless Gamma_M has it. The batch is
    /// complete once it is full or the route ends.
    fn begin_motion(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
    ) -> Result<(), ArenaFull> {
        if !search.batch.is_running() {
            search.batch.begin();
        }
        let Some([from, to]) = self.stepper.next(search.route.route()) else {
            (self.is_sampling, self.is_at_end) = (true, true);
            return Ok(());
        };
        let graph = &mut search.roadmap.graph;
        if let [Some(from), Some(to)] = [transition_on(graph, from)?, transition_on(graph, to)?]
            && search.roadmap.edges.get(from, to).motion.is_none()
        {
            let edge = ModeEdge { from, to };
            match trajectory(context, &search.roadmap.graph, edge) {
                Ok(trajectory) => search.batch.add_primitive(edge, trajectory),
                Err(_) => search.stats.primitives_failed += 1,
            }
        }
        self.is_sampling = search.batch.is_full();
        Ok(())
    }
}

/// The shift or the swing between two transitions.
fn trajectory(
    context: &PlanningContext,
    graph: &ModeGraph,
    edge: ModeEdge,
) -> Result<PrimitiveTrajectory, Rejection> {
    let (constraints, gait) = (&context.constraints, context.preparation.gait());
    let (stance, touched) = graph.pair(edge.from);
    if edge.to == ModeGraph::twin(edge.from) {
        PrimitiveTrajectory::shift(constraints, gait, [stance, touched])
    } else {
        PrimitiveTrajectory::swing(constraints, gait, stance, [touched, graph.pair(edge.to).1])
    }
}

/// The transition on two placements, added if the graph does not have it; `None` where the graph
/// does not have both placements.
fn transition_on(graph: &mut ModeGraph, node: Node) -> Result<Option<TransitionId>, ArenaFull> {
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
