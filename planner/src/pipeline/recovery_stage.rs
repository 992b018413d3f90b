//! Recovers from a segment that cannot be completed [Grey 4.4.4].

use std::ops::Range;

use crate::base::capacity::ArenaFull;
use crate::motion::ids::{FootholdId, TransitionId, boundary_of};
use crate::motion::mode_graph::ModeGraph;
use crate::motion::roadmap::Roadmap;
use crate::motion::transition_sequence::Objective;
use crate::motion::tuning::ATTEMPTS_MAX;
use crate::pipeline::bottlenecks::{Bottleneck, Bottlenecks, mid_feet_pose};
use crate::pipeline::direct_stage::reject_steps;
use crate::pipeline::foothold_order::FootholdOrder;
use crate::pipeline::goal_postures::GoalPostures;
use crate::pipeline::recovery_policy::{
    ALTERNATIVE_FAILURES, RecoveryAction, RecoveryPolicy, detour_about,
};
use crate::pipeline::resorts::Resort;
use crate::pipeline::search::Search;
use crate::pipeline::segment_searches::{SegmentSearch, SegmentState};
use crate::pipeline::segmentation::Segmentation;
use crate::pipeline::stage::Event;
use crate::possibility::{MidFeetPose, RouteSearch};
use crate::preparation::planning_context::PlanningContext;

/// Within this distance (m, in the metric of Gamma_P) of start and goal no region is blocked: every
/// route passes there.
const ENDPOINT_RADIUS: f64 = 0.6;
/// Radius of a blocked region, m, in the metric of Gamma_P.
const BLOCKED_RADIUS: f64 = 0.25;
/// Radius of a blocked region after many routes, m: routes nearer than this have similar steps.
const LATE_BLOCKED_RADIUS: f64 = 0.6;
/// Number of routes that counts as many, detours included.
const MANY_ROUTES: u64 = 5;
/// Values of S(T) at which the footholds of a transition are perturbed, once: after its second
/// batch of failed attempts, or the first where no primitive posture holds on it.
const PERTURBED_AT: Range<u32> = 2 * ATTEMPTS_MAX + 1..3 * ATTEMPTS_MAX + 1;

/// The round of uniform footholds from which on the margins are the least ones.
const LEAST_MARGINS_FROM_ROUND: u64 = 2;

/// Chooses what follows a failed segment, without any work: the next sequence, more footholds, a
/// detour, another route, or longer steps. `recovery_policy.rs` says when.
#[derive(Debug, Default)]
pub(crate) struct RecoveryStage {
    bottlenecks: Bottlenecks,
    goal_postures: GoalPostures,
}

impl RecoveryStage {
    /// Recovers from the failure of the current segment.
    ///
    /// # Errors
    /// The transition arena is full.
    pub fn step(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        _budget: u64,
    ) -> Result<Event, ArenaFull> {
        if search.direct.is_active {
            return Ok(replace_direct_steps(search));
        }
        let current = search.segments.current_mut();
        let is_disconnected = current.state == SegmentState::Disconnected;
        current.seek(Objective::Feasible);
        if is_disconnected {
            return Ok(self.connect_frontiers(search));
        }
        self.replace_sequence(context, search)
    }

    /// The place where most sequences failed, if any did.
    pub fn bottleneck(&self) -> Option<Bottleneck> {
        self.bottlenecks.worst()
    }

    /// A sequence could not be completed: the next one is tried, or an action is taken near the
    /// failures, and the transitions of failed motions get further configurations, or the goal
    /// another posture.
    ///
    /// # Errors
    /// The transition arena is full.
    fn replace_sequence(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
    ) -> Result<Event, ArenaFull> {
        let graph = &search.roadmap.graph;
        let cost = |id: &TransitionId| graph.transitions()[*id as usize].cost();
        let current = search.segments.current_mut();
        let cost_max = current.sequence.iter().map(cost).fold(0.0, f64::max);
        let before = current.recovery;
        let action = current.recovery.count_failure(cost_max);
        let worst = worst_failure(search);
        let place = place_of(search, worst);
        if action.is_some() && search.limits.resorts.has(Resort::Alternatives) {
            add_alternatives(&mut search.roadmap, &search.segmentation, search.segments.current())?;
        }
        if search.limits.resorts.has(Resort::GoalPostures) {
            self.goal_postures.replace(context, search)?;
        }
        self.bottlenecks.count_failure(place);
        grow_beside(search, place);
        if action.is_some() && take_turn(search, before) {
            return Ok(Event::OtherRoute);
        }
        Ok(match action {
            None => try_next(search, worst),
            Some(RecoveryAction::Resweep) => {
                select_failures(search);
                search.begin_sweep();
                Event::NeedsFootholds
            }
            Some(RecoveryAction::SampleNear) if search.footholds.uniform.replace_sweeps() => {
                search.begin_sweep();
                Event::NeedsFootholds
            }
            Some(RecoveryAction::SampleNear) => {
                search.footholds.order = FootholdOrder::SampleNear { index: 0 };
                Event::NeedsFootholds
            }
            Some(RecoveryAction::Detour) => {
                let vertex = search.route.route().nearest_vertex(place.position);
                begin_detour(search, vertex, place)
            }
            Some(RecoveryAction::NewRoute) if search.is_uniform_due() => begin_uniform(search),
            Some(RecoveryAction::NewRoute) => {
                block_failures(search);
                leave_route(search, place)
            }
        })
    }

    /// No sequence connects both ends of the segment: more footholds are sampled where the
    /// sequences from both ends stop, or another action is taken there [Grey 4.4.4].
    fn connect_frontiers(&mut self, search: &mut Search) -> Event {
        let current = search.segments.current_mut();
        let before = current.recovery;
        let (action, frontiers) = (current.recovery.next_action(), current.frontiers);
        let frontier = search.route.route().pose(frontiers[0]);
        self.bottlenecks.count_failure(frontier);
        grow_beside(search, frontier);
        if take_turn(search, before) {
            return Event::OtherRoute;
        }
        match action {
            RecoveryAction::Resweep | RecoveryAction::SampleNear => {
                let vertices = search.route.route().vertex_count();
                search.footholds.selection.select_about(vertices, frontiers.into_iter());
                search.begin_sweep();
                Event::NeedsFootholds
            }
            RecoveryAction::Detour => begin_detour(search, frontiers[0], frontier),
            RecoveryAction::NewRoute if !search.connections.long_steps => {
                search.connections.begin_long_steps();
                Event::LongSteps
            }
            RecoveryAction::NewRoute if search.is_uniform_due() => begin_uniform(search),
            RecoveryAction::NewRoute => leave_route(search, frontier),
        }
    }
}

/// Lets another route grow that avoids a place where the current one failed.
fn grow_beside(search: &mut Search, place: MidFeetPose) {
    if search.route.ends().iter().all(|end| end.distance(&place) > ENDPOINT_RADIUS) {
        search.guide.live.begin_growth(&search.route, (place, BLOCKED_RADIUS));
    }
}

/// An action is due on the current route: turns to another live one in its place. The action then
/// follows in the next turn. A route of several segments keeps its turn, because its complete
/// segments would be lost.
fn take_turn(search: &mut Search, before: RecoveryPolicy) -> bool {
    let may_turn = search.segmentation.len() == 1;
    if may_turn && search.guide.live.take_turn(&mut search.route, before) {
        return true;
    }
    search.guide.live.count_action();
    false
}

/// Direct steps could not be completed: others are tried, or stage P searches a route.
fn replace_direct_steps(search: &mut Search) -> Event {
    if reject_steps(search) {
        return Event::Near;
    }
    search.segments.current_mut().state = SegmentState::Leave;
    Event::Done
}

/// Whether a transition of the current sequence has no configuration, or the motion to it failed.
fn is_unsolved(search: &Search, index: usize) -> bool {
    let current = search.segments.current();
    let segment = search.segmentation.segment(current.segment, &current.sequence);
    search.roadmap.is_unsolved(segment, index)
}

/// The indices of the unsolved transitions of the current sequence.
fn unsolved(search: &Search) -> impl Iterator<Item = usize> + '_ {
    let transitions = search.segments.current().sequence.len();
    (0..transitions).filter(|&index| is_unsolved(search, index))
}

/// The index of the unsolved transition of the current sequence with the most attempts.
fn worst_failure(search: &Search) -> usize {
    let (transitions, sequence) =
        (search.roadmap.graph.transitions(), &search.segments.current().sequence);
    let attempts = |index: &usize| transitions[sequence[*index] as usize].attempts;
    unsolved(search).max_by_key(attempts).unwrap_or(0)
}

/// The pose midway between the feet of a transition of the current sequence.
fn place_of(search: &Search, index: usize) -> MidFeetPose {
    mid_feet_pose(&search.roadmap.graph, search.segments.current().sequence[index])
}

/// Goes on to the next sequence. If it is time, the transition at an index of the current one is
/// perturbed before.
fn try_next(search: &mut Search, index: usize) -> Event {
    let transitions = search.roadmap.graph.transitions();
    let id = search.segments.current().sequence.get(index);
    let is_due = id.map(|&id| &transitions[id as usize]).is_some_and(|transition| {
        !transition.is_found() && PERTURBED_AT.contains(&transition.attempts)
    });
    if !is_due || search.footholds.uniform.replace_sweeps() {
        return Event::Done;
    }
    search.footholds.order = FootholdOrder::Perturb { index, tried: 0, end: index + 1 };
    Event::NeedsFootholds
}

/// Adds a further transition, for another configuration of Q(T), at each end of the motions that
/// failed again and again between two configurations: others on the same footholds may be joined.
/// Does nothing once the arena is nearly full.
fn add_alternatives(
    roadmap: &mut Roadmap,
    segmentation: &Segmentation,
    current: &SegmentSearch,
) -> Result<(), ArenaFull> {
    let segment = segmentation.segment(current.segment, &current.sequence);
    let mut last = None;
    for index in 0..=current.sequence.len() {
        let edge = segment.edge(index);
        let record = roadmap.edges.get(edge.from, edge.to);
        if record.motion.is_some() || record.failures < ALTERNATIVE_FAILURES {
            continue;
        }
        for node in [edge.from, edge.to] {
            let pair = node.min(ModeGraph::twin(node));
            let is_new = boundary_of(node).is_none() && last.replace(pair) != Some(pair);
            if is_new && !roadmap.graph.is_nearly_full() {
                roadmap.graph.add_alternative(node)?;
            }
        }
    }
    Ok(())
}

/// Begins a round of uniform footholds. From the first on, footholds of any heading may be used.
fn begin_uniform(search: &mut Search) -> Event {
    if search.footholds.uniform.rounds == 1 {
        search.connections.nearest_vertices.clear();
    }
    if search.footholds.uniform.rounds == LEAST_MARGINS_FROM_ROUND {
        search.relax_margins();
    }
    let first = search.roadmap.graph.footholds().len() as FootholdId;
    search.connections.uniform_from = Some(first);
    search.footholds.order =
        FootholdOrder::Uniform { left: search.footholds.uniform.round_footholds() };
    Event::NeedsFootholds
}

/// Selects the vertices near the unsolved transitions.
fn select_failures(search: &mut Search) {
    let route = search.route.route();
    let mut selection = std::mem::take(&mut search.footholds.selection);
    let nearest = |index: usize| route.nearest_vertex(place_of(search, index).position);
    selection.select_about(route.vertex_count(), unsolved(search).map(nearest));
    search.footholds.selection = selection;
}

/// Blocks the regions around the unsolved transitions.
fn block_failures(search: &mut Search) {
    let radius = new_route_radius(search);
    for index in 0..search.segments.current().sequence.len() {
        if is_unsolved(search, index) {
            let place = place_of(search, index);
            block(&mut search.route, place, radius);
        }
    }
}

/// Sends stage P to find a detour around a place near a vertex; another route where the detour
/// would replace the whole segment.
fn begin_detour(search: &mut Search, vertex: usize, place: MidFeetPose) -> Event {
    let vertices = search.segmentation.vertices(search.segments.current().segment);
    let Some(between) = detour_about(vertices, vertex) else { return leave_route(search, place) };
    block(&mut search.route, place, BLOCKED_RADIUS);
    search.route.begin_detour(between);
    search.segmentation.begin_detour(search.route.route().vertex_count());
    Event::Detour
}

/// Blocks the region around a place. The current segment waits for another route.
fn leave_route(search: &mut Search, place: MidFeetPose) -> Event {
    let radius = new_route_radius(search);
    block(&mut search.route, place, radius);
    search.guide.live.end_route();
    search.segments.current_mut().state = SegmentState::Leave;
    Event::Done
}

/// The radius (m) of the regions that another route avoids.
fn new_route_radius(search: &Search) -> f64 {
    if search.stats.routes < MANY_ROUTES { BLOCKED_RADIUS } else { LATE_BLOCKED_RADIUS }
}

/// Blocks the region around a place, unless it is near the start or the goal.
fn block(route: &mut RouteSearch, place: MidFeetPose, radius: f64) {
    if route.ends().iter().all(|end| end.distance(&place) > ENDPOINT_RADIUS) {
        route.block(place, radius);
    }
}
