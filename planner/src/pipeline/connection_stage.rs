//! Connects footholds by transitions [Grey 4.4.2].

use crate::base::capacity::ArenaFull;
use crate::base::random::{Random, Stream};
use crate::base::work_budget::items_in;
use crate::constraints::foothold::{Foothold, left_and_right};
use crate::motion::ids::{FootholdId, GOAL, START};
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
/// so that many near ones do not displace the few across a gap. Footholds of start and goal do not
/// displace each other: a step may lead from one to the other.
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
        search.connections.uniform_from = None;
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
    let (graph, connections) = (&search.roadmap.graph, &search.connections);
    let ends = [START, GOAL].map(|end| search.roadmap.boundary(end).footholds);
    let neighbours = |id: FootholdId| {
        let is_new = id >= graph.connected();
        if is_new && connections.uniform_from.is_some_and(|first| id >= first) {
            return any_neighbours(context, graph, id, steps.farthest());
        }
        let is_due = |a: &Foothold, b: &Foothold| {
            let soles = left_and_right(a, b).map(|foothold| &foothold.world_from_sole);
            if steps.may_step(soles) { is_new } else { connections.long_steps }
        };
        let mut found =
            neighbours(context, (graph, ends.as_flattened()), id, steps.reach(), is_due);
        if is_new {
            add_partner(graph, id, &mut found);
        }
        found.retain(|&neighbour| graph.find(id, neighbour).is_none());
        found
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

/// Adds the foothold on which a posture holds together with this one, whatever else is near it.
fn add_partner(graph: &ModeGraph, foothold: FootholdId, neighbours: &mut Neighbours) {
    let Some(partner) = graph.partner(foothold) else { return };
    if neighbours.contains(&partner) {
        return;
    }
    if neighbours.is_full() {
        neighbours.pop();
    }
    let _has_capacity = neighbours.push(partner);
}

/// Finds the nearest vertices of the next footholds without one, as many as a budget allows; after
/// the route has changed, of all. Returns `false` if no foothold was left.
fn locate_next(context: &PlanningContext, search: &mut Search, budget: u64) -> bool {
    let (route, footholds) = (search.route.route(), search.roadmap.graph.footholds());
    let may_face_anywhere = search.footholds.uniform.may_face_anywhere();
    let ids: Batch<usize> = (search.connections.nearest_vertices.len()..footholds.len())
        .take(items_in(budget, BATCH_MAX))
        .collect();
    let locate = |id: usize| {
        let world_from_sole = &footholds[id].world_from_sole;
        let suits =
            may_face_anywhere || route.is_aligned_with(&MidFeetPose::of_sole(world_from_sole));
        (route.nearest_vertex(world_from_sole.translation), suits)
    };
    let located: Batch<(usize, bool)> = context.threads.map(&ids, locate);
    search.stats.work += ids.len().max(1) as u64;
    for (&id, (vertex, suits)) in ids.iter().zip(located) {
        let crouch = search.route.crouch(vertex);
        let crouch = crouch.unwrap_or_else(|| search.guide.crouch.crouch(vertex));
        search.roadmap.graph.set_crouch(id as FootholdId, crouch);
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
/// (m), due, and such that the feet do not collide. `ends` are the footholds of start and goal.
fn neighbours(
    context: &PlanningContext,
    (graph, ends): (&ModeGraph, &[FootholdId]),
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
        let competes = |known: &&mut Neighbour| {
            known.cell == cell && !(ends.contains(&known.id) && ends.contains(&id))
        };
        match neighbours.iter_mut().find(competes) {
            Some(known) if known.distance <= distance => {}
            Some(known) => *known = neighbour,
            None => drop(neighbours.push(neighbour)),
        }
    }
    let ids = neighbours.iter().map(|neighbour| neighbour.id);
    ids.filter(|&id| !do_feet_collide(context, graph, [foothold, id])).collect()
}

/// The earlier footholds of the other foot within `reach` (m) of a foothold such that the feet do
/// not collide, whatever steps primitive postures make; a random choice of them if they are many.
fn any_neighbours(
    context: &PlanningContext,
    graph: &ModeGraph,
    foothold: FootholdId,
    reach: f64,
) -> Neighbours {
    let here = &graph.footholds()[foothold as usize];
    let near = graph
        .near(1 - here.limb, here.world_from_sole.translation)
        .take_while(|&(id, _)| id < foothold)
        .filter(|(id, other)| {
            here.distance(other) <= reach && !do_feet_collide(context, graph, [foothold, *id])
        });
    let mut random = Random::new(context.seed, Stream::Connection, u64::from(foothold), 0);
    let mut neighbours = Neighbours::new();
    for (count, (id, _)) in near.enumerate() {
        if let Err(id) = neighbours.push(id)
            && let Some(known) = neighbours.get_mut(random.below(count + 1))
        {
            *known = id;
        }
    }
    neighbours
}

/// Whether the two feet would intersect on two footholds: such a transition cannot exist
/// [Grey 4.4.2].
fn do_feet_collide(context: &PlanningContext, graph: &ModeGraph, ids: [FootholdId; 2]) -> bool {
    let [a, b] = ids.map(|id| &graph.footholds()[id as usize]);
    let soles = left_and_right(a, b).map(|foothold| &foothold.world_from_sole);
    context.constraints.collision.feet_hit(soles)
}

#[cfg(test)]
mod tests {
    use super::*;
    use surefoot_shared_types::Pose;

    fn foothold(limb: usize, x: f64) -> Foothold {
        let pose = Pose::from_translation(glam::DVec3::new(x, 0.0, 0.0));
        Foothold::new(limb, pose, heapless::Vec::new())
    }

    #[test]
    fn a_pair_on_which_a_posture_holds_is_connected_whatever_is_near() {
        let mut graph = ModeGraph::new(300, 8, 8, 1.0);
        for _ in 0..200 {
            graph.add_foothold(foothold(0, 0.3)).unwrap();
        }
        graph.add_pair([foothold(0, 0.31), foothold(1, 0.6)]).unwrap();
        let mut neighbours: Neighbours = (0..NEIGHBOURS_MAX as FootholdId).collect();
        add_partner(&graph, 201, &mut neighbours);
        assert_eq!((neighbours.len(), neighbours.last()), (NEIGHBOURS_MAX, Some(&200)));
        add_partner(&graph, 201, &mut neighbours);
        assert_eq!(neighbours.iter().filter(|&&id| id == 200).count(), 1, "only once");
        let mut of_another: Neighbours = heapless::Vec::new();
        add_partner(&graph, 200, &mut of_another);
        assert!(of_another.is_empty(), "only the second of a pair has a partner");
    }
}
