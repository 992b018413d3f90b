//! Connects footholds by transitions [Grey 4.4.2].

use crate::base::capacity::ArenaFull;
use crate::base::work_budget::items_in;
use crate::constraints::foothold::{Foothold, left_and_right};
use crate::motion::ids::FootholdId;
use crate::motion::mode_graph::ModeGraph;
use crate::pipeline::search::Search;
use crate::pipeline::stage::Event;
use crate::possibility::MidFeetPose;
use crate::preparation::planning_context::PlanningContext;

/// Footholds that are processed in parallel.
const BATCH_MAX: usize = 64;
/// The nearest vertex of a foothold that is not used on the route.
const NO_VERTEX: u32 = u32::MAX;
/// Most neighbours that a foothold is connected with.
const NEIGHBOURS_MAX: usize = 128;
/// Of all neighbours in one cell of this width (m) around a foothold only the nearest is connected,
/// so that many near ones do not displace the few across a gap.
const NEIGHBOUR_CELL: f64 = 0.1;

type Batch<T> = heapless::Vec<T, BATCH_MAX>;
type Neighbours = heapless::Vec<FootholdId, NEIGHBOURS_MAX>;

/// Connects new footholds with their neighbours by transitions, and finds the vertex of the route
/// nearest to each. One unit of work for each foothold. Has no state: [`Search`] has the next
/// foothold.
#[derive(Debug, Default)]
pub(crate) struct ConnectionStage;

impl ConnectionStage {
    /// Connects the next footholds, as many as `budget` allows; once all are connected, locates
    /// them on the route.
    ///
    /// # Errors
    /// The transition arena is full.
    pub fn step(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        budget: u64,
    ) -> Result<Event, ArenaFull> {
        let graph = &search.roadmap.graph;
        let count = graph.footholds().len() as FootholdId;
        let next = search.connections.next.unwrap_or(graph.connected());
        if next < count {
            let ids: Batch<FootholdId> = (next..count).take(items_in(budget, BATCH_MAX)).collect();
            connect(context, search, &ids)?;
            search.connections.next = Some(next + ids.len() as FootholdId);
            return Ok(Event::Continue);
        }
        search.connections.next = Some(next);
        if locate_next(context, search, budget) {
            return Ok(Event::Continue);
        }
        search.connections.next = None;
        let is_new_route = std::mem::take(&mut search.connections.is_new_route);
        Ok(if is_new_route { Event::NewRoute } else { Event::Done })
    }
}

/// Connects footholds with their neighbours.
fn connect(
    context: &PlanningContext,
    search: &mut Search,
    ids: &Batch<FootholdId>,
) -> Result<(), ArenaFull> {
    let steps = context.preparation.step_limits();
    let (graph, long_steps) = (&search.roadmap.graph, search.connections.long_steps);
    let neighbours = |id: FootholdId| {
        let is_due = |a: &Foothold, b: &Foothold| {
            let soles = left_and_right(a, b).map(|foothold| &foothold.world_from_sole);
            if steps.may_step(soles) { id >= graph.connected() } else { long_steps }
        };
        neighbours(context, graph, id, steps.reach(), is_due)
    };
    let connected: Batch<Neighbours> = context.threads.map(ids, neighbours);
    for (&id, neighbours) in ids.iter().zip(connected) {
        search.stats.work += 1;
        for neighbour in neighbours {
            search.roadmap.graph.connect(id, neighbour)?;
        }
        search.roadmap.graph.mark_connected(id);
    }
    Ok(())
}

/// Finds the nearest vertices of the next footholds without one, as many as a budget allows; after
/// the route has changed, of all. Returns `false` if no foothold was left.
fn locate_next(context: &PlanningContext, search: &mut Search, budget: u64) -> bool {
    let (route, footholds) = (search.route.route(), search.roadmap.graph.footholds());
    let ids: Batch<usize> = (search.connections.nearest_vertices.len()..footholds.len())
        .take(items_in(budget, BATCH_MAX))
        .collect();
    let locate = |id: usize| {
        let world_from_sole = &footholds[id].world_from_sole;
        let suits = route.is_aligned_with(&MidFeetPose::of_sole(world_from_sole));
        (route.nearest_vertex(world_from_sole.translation), suits)
    };
    let located: Batch<(usize, bool)> = context.threads.map(&ids, locate);
    search.stats.work += ids.len().max(1) as u64;
    for (&id, (vertex, suits)) in ids.iter().zip(located) {
        search.roadmap.graph.set_crouch(id as FootholdId, search.crouch.crouch(vertex));
        search.connections.nearest_vertices.push(if suits { vertex as u32 } else { NO_VERTEX });
    }
    !ids.is_empty()
}

/// A foothold that another may form a step with.
#[derive(Debug, Clone, Copy)]
struct Neighbour {
    cell: glam::IVec3,
    distance: f64,
    id: FootholdId,
}

/// The earlier footholds of the other foot that a foothold is to be connected with: within `reach`
/// (m), due, and such that the feet do not collide.
fn neighbours(
    context: &PlanningContext,
    graph: &ModeGraph,
    foothold: FootholdId,
    reach: f64,
    is_due: impl Fn(&Foothold, &Foothold) -> bool,
) -> Neighbours {
    let mut neighbours: heapless::Vec<Neighbour, NEIGHBOURS_MAX> = heapless::Vec::new();
    let here = &graph.footholds()[foothold as usize];
    let position = here.world_from_sole.translation;
    for (id, other) in graph.near(1 - here.limb, position).take_while(|&(id, _)| id < foothold) {
        let distance = here.distance(other);
        if distance > reach || !is_due(here, other) {
            continue;
        }
        let offset = other.world_from_sole.translation - position;
        let cell = (offset / NEIGHBOUR_CELL).round().as_ivec3();
        let neighbour = Neighbour { cell, distance, id };
        match neighbours.iter_mut().find(|known| known.cell == cell) {
            Some(known) if known.distance <= distance => {}
            Some(known) => *known = neighbour,
            None => drop(neighbours.push(neighbour)),
        }
    }
    let ids = neighbours.iter().map(|neighbour| neighbour.id);
    ids.filter(|&id| !do_feet_collide(context, graph, [foothold, id])).collect()
}

/// Whether the two feet would intersect on two footholds: such a transition cannot exist
/// [Grey 4.4.2].
fn do_feet_collide(context: &PlanningContext, graph: &ModeGraph, ids: [FootholdId; 2]) -> bool {
    let [a, b] = ids.map(|id| &graph.footholds()[id as usize]);
    let soles = left_and_right(a, b).map(|foothold| &foothold.world_from_sole);
    context.constraints.collision.feet_hit(soles)
}
