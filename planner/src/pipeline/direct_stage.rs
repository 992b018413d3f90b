//! Tries direct steps to a near goal before any guide route, and tests them [Grey 4.4.2].

use surefoot_shared_types::base::spatial::wrap_angle;

use crate::base::capacity::ArenaFull;
use crate::constraints::foothold::left_and_right;
use crate::motion::ids::{FootholdId, GOAL, START, TransitionId};
use crate::motion::mode_graph::ModeGraph;
use crate::motion::roadmap::RouteSegment;
use crate::motion::transition_prior::transition_prior;
use crate::pipeline::direct_steps::{AT_GOAL, AT_START, StepPlacement};
use crate::pipeline::endpoints::{Nearness, foothold_near};
use crate::pipeline::search::Search;
use crate::pipeline::segment_searches::SegmentState;
use crate::pipeline::stage::Event;
use crate::possibility::{IdealWidth, MidFeetPose};
use crate::preparation::planning_context::PlanningContext;

/// Greatest horizontal distance of a near goal, m.
const NEAR_DISTANCE: f64 = 1.6;
/// Greatest difference in height of a near goal, m.
const NEAR_HEIGHT: f64 = 0.3;
/// Greatest distance (m) and turn (rad) between two interpolated poses.
const SPACING: (f64, f64) = (0.1, 0.15);
/// Most intervals between interpolated poses.
const INTERVALS_MAX: usize = 21;
/// Difference between two stance widths, m.
const WIDTH_DIFFERENCE_MIN: f64 = 0.02;
/// Smallest turn (rad) on which a wide stance is tried, and its width relative to the other ones:
/// feet that turn inward collide in a narrow stance.
const WIDE: (f64, f64) = (0.3, 1.4);
/// Smallest turn (rad) and distance (m) of a way on which turns come early or late, too.
const EARLY_TURN_MIN: f64 = 0.5;
const EARLY_DISTANCE_MIN: f64 = 0.3;
/// Smallest turn (rad) and distance (m) of a way on which both may be separated.
const SEPARATE: (f64, f64) = (0.3, 0.1);
/// Work units after which the turn and the way are separated, and stage P searches a route.
const MIXED_WORK_MAX: u64 = 4_000;
const WORK_MAX: u64 = 30_000;

/// Searches the cheapest path of direct steps, and tests it. One unit of work for each placement
/// that the search expands, and for each test.
#[derive(Debug, Default)]
pub(crate) struct DirectStage;

impl DirectStage {
    /// Searches the next path, or tests it. A path that passes every test becomes the sequence of
    /// the only segment. If there is none, stage P searches a route.
    ///
    /// # Errors
    /// An arena is full.
    pub fn step(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        _budget: u64,
    ) -> Result<Event, ArenaFull> {
        search.stats.work += 1;
        if search.direct.placements.is_empty() {
            add_placements(context, search);
        }
        if let Some(next) = search.direct.tests.next {
            return test(context, search, next);
        }
        let collision = &context.constraints.collision;
        let limits = context.preparation.step_limits();
        let has_path = search.direct.advance(limits, |soles| collision.feet_hit(soles));
        let may_separate = !search.direct.is_separate && is_separable(search);
        let work_max = if may_separate { MIXED_WORK_MAX } else { WORK_MAX };
        if has_path == Some(false) || search.stats.work > work_max {
            if !may_separate {
                search.roadmap.graph.forget_connected();
                return Ok(Event::NewRoute);
            }
            search.direct.begin_separate();
            return Ok(Event::Continue);
        }
        (search.direct.tests.next, search.direct.tests.has_failed) = (has_path.map(|_| 0), false);
        Ok(Event::Continue)
    }
}

/// Tests the placements of the path, then its steps, from `next` on: the first that was not tested
/// before. A path that passes all tests is taken, otherwise the next one is searched.
fn test(context: &PlanningContext, search: &mut Search, next: usize) -> Result<Event, ArenaFull> {
    let count = search.direct.path.len();
    for index in next..2 * count - 1 {
        search.direct.tests.next = Some(index + 1);
        let is_due = if index < count {
            search.direct.placements[search.direct.path[index]].foothold.is_none()
        } else {
            let [a, b] = search.direct.step(index - count);
            !search.direct.tests.has_failed && !search.direct.is_tested(a, b)
        };
        if is_due {
            let passes = if index < count {
                test_placement(context, search, search.direct.path[index])?
            } else {
                test_step(context, search, search.direct.step(index - count))?
            };
            search.direct.tests.has_failed |= !passes;
            return Ok(Event::Continue);
        }
    }
    search.direct.tests.next = None;
    if search.direct.tests.has_failed {
        search.direct.tests.failed_paths += 1;
        return Ok(Event::Continue);
    }
    take_path(search)?;
    Ok(Event::Done)
}

/// The interpolated poses from a start to a goal that is near.
pub(crate) fn poses_between(
    start: MidFeetPose,
    goal: MidFeetPose,
) -> Option<impl Iterator<Item = MidFeetPose>> {
    let distance = start.horizontal_offset_to(&goal).length();
    let is_near =
        distance <= NEAR_DISTANCE && (goal.position.z - start.position.z).abs() <= NEAR_HEIGHT;
    let turn = wrap_angle(goal.yaw - start.yaw).abs();
    let intervals = libm::ceil((distance / SPACING.0).max(turn / SPACING.1)) as usize;
    let intervals = intervals.clamp(1, INTERVALS_MAX);
    is_near.then(|| {
        (0..=intervals).map(move |index| start.interpolate(&goal, index as f64 / intervals as f64))
    })
}

/// Adds the placements of start and goal, and candidates about the route.
fn add_placements(context: &PlanningContext, search: &mut Search) {
    search.connections.nearest_vertices.clear();
    search.connections.nearest_vertices.resize(search.roadmap.graph.footholds().len(), 0);
    let last = search.route.route().vertex_count() - 1;
    for (end, vertex) in [(START, 0), (GOAL, last)] {
        let footholds = search.roadmap.boundary(end).footholds;
        for (limb, id) in footholds.into_iter().enumerate() {
            let world_from_sole = search.roadmap.graph.footholds()[id as usize].world_from_sole;
            let foothold = Some(id);
            search.direct.add(StepPlacement {
                limb,
                world_from_sole,
                vertex,
                foothold,
                is_rejected: false,
            });
        }
    }
    if search.direct.is_separate {
        return add_separate(context, search);
    }
    for vertex in 0..=last {
        let widths = widths_at(context, search, vertex, turn_of(search));
        for pose in poses_at(search, vertex) {
            add_at(search, &pose, vertex, &widths);
        }
    }
}

/// Adds the placements of both feet at a pose.
fn add_at(search: &mut Search, pose: &MidFeetPose, vertex: usize, widths: &[f64]) {
    for (&width, limb) in widths.iter().flat_map(|width| [(width, 0), (width, 1)]) {
        let world_from_sole = pose.world_from_ideal_sole(limb, width);
        let (foothold, is_rejected) = (None, false);
        search.direct.add(StepPlacement { limb, world_from_sole, vertex, foothold, is_rejected });
    }
}

/// Whether the way has a turn and a distance that can be separated.
fn is_separable(search: &Search) -> bool {
    let [start, goal] = search.route.ends();
    turn_of(search).abs() >= SEPARATE.0 && start.horizontal_offset_to(&goal).length() >= SEPARATE.1
}

/// Adds the placements of a turn on the spot at the start and a walk without a turn, and of such a
/// walk and a turn at the goal. Steps that walk and turn at once are beyond some robots.
fn add_separate(context: &PlanningContext, search: &mut Search) {
    let [start, goal] = search.route.ends();
    let turn = turn_of(search);
    let last = search.route.route().vertex_count() - 1;
    let distance = start.horizontal_offset_to(&goal).length();
    let [turns, strides] = [turn.abs() / SPACING.1, distance / SPACING.0]
        .map(|count| (libm::ceil(count) as usize).clamp(1, INTERVALS_MAX));
    for (turning, walking, vertex) in [(start, goal, 0), (goal, start, last)] {
        let widths = widths_at(context, search, vertex, turn);
        for index in 0..=turns {
            let yaw = start.yaw + turn * index as f64 / turns as f64;
            add_at(search, &MidFeetPose { yaw, ..turning }, vertex, &widths);
        }
        let widths = widths_at(context, search, vertex, 0.0);
        for index in 0..=strides {
            let fraction = index as f64 / strides as f64;
            let position = start.position.lerp(goal.position, fraction);
            let pose = MidFeetPose { position, yaw: walking.yaw };
            add_at(search, &pose, index * last / strides, &widths);
        }
    }
}

/// The stance widths of the placements at a vertex, m: that of the route, that of the gait, and on
/// a `turn` (rad) a wide one.
fn widths_at(
    context: &PlanningContext,
    search: &Search,
    vertex: usize,
    turn: f64,
) -> heapless::Vec<f64, 3> {
    let route = search.route.route();
    let ideal = |limb| route.world_from_ideal_sole(vertex, limb, IdealWidth::Walking);
    let [left, right] = [0, 1].map(ideal);
    let route_width = left.translation.distance(right.translation);
    let gait_width = context.preparation.gait().width;
    let is_turn = turn.abs() >= WIDE.0;
    let wide = is_turn.then(|| WIDE.1 * route_width.max(gait_width));
    let mut widths: heapless::Vec<f64, 3> = heapless::Vec::new();
    for width in [Some(route_width), Some(gait_width), wide].into_iter().flatten() {
        if widths.iter().all(|known| (width - known).abs() > WIDTH_DIFFERENCE_MIN) {
            let _full = widths.push(width);
        }
    }
    widths
}

/// The turn from the start to the goal, rad.
fn turn_of(search: &Search) -> f64 {
    let route = search.route.route();
    wrap_angle(route.pose(route.vertex_count() - 1).yaw - route.pose(0).yaw)
}

/// The poses of the placements at a vertex: that of the route, and where it both walks and turns,
/// those of a turn in the first half of the way, and in the second.
fn poses_at(search: &Search, vertex: usize) -> heapless::Vec<MidFeetPose, 3> {
    let route = search.route.route();
    let last = route.vertex_count() - 1;
    let [start, pose, goal] = [0, vertex, last].map(|vertex| route.pose(vertex));
    let turn = turn_of(search);
    let mut poses = heapless::Vec::new();
    let _full = poses.push(pose);
    let walks = start.horizontal_offset_to(&goal).length() >= EARLY_DISTANCE_MIN;
    if walks && turn.abs() >= EARLY_TURN_MIN {
        let fraction = vertex as f64 / last as f64;
        for turned in [(2.0 * fraction).min(1.0), (2.0 * fraction - 1.0).max(0.0)] {
            let _full = poses.push(MidFeetPose { yaw: start.yaw + turned * turn, ..pose });
        }
    }
    poses
}

/// Tests a placement against the ground, and adds its foothold. Returns whether it is supported.
fn test_placement(
    context: &PlanningContext,
    search: &mut Search,
    index: usize,
) -> Result<bool, ArenaFull> {
    let PlanningContext { constraints, surfaces, .. } = context;
    let Search { direct, footholds, roadmap, connections, .. } = search;
    let placement = &mut direct.placements[index];
    let (limb, wanted) = (placement.limb, placement.world_from_sole);
    let scratch = &mut footholds.scratch[0];
    let nearness = Nearness::USUAL;
    let Ok(foothold) = foothold_near(constraints, surfaces, scratch, limb, (&wanted, nearness))
    else {
        placement.is_rejected = true;
        return Ok(false);
    };
    placement.world_from_sole = foothold.world_from_sole;
    let known = roadmap.graph.find_equivalent(&foothold);
    placement.foothold = Some(match known {
        Some(id) => id,
        None => roadmap.graph.add_foothold(foothold)?,
    });
    let count = roadmap.graph.footholds().len();
    connections.nearest_vertices.resize(count, placement.vertex as u32);
    roadmap.graph.mark_connected(count as FootholdId - 1);
    Ok(true)
}

/// Tests a step by inverse kinematics. Returns whether a posture holds on it, at an acceptable
/// effort.
fn test_step(
    context: &PlanningContext,
    search: &mut Search,
    [a, b]: [usize; 2],
) -> Result<bool, ArenaFull> {
    let is_last = AT_GOAL.contains(&a) && AT_GOAL.contains(&b);
    let effort = effort_of(context, search, [a, b])?;
    Ok(match effort.filter(|&(_, is_likely)| is_likely || is_last) {
        Some((effort, _)) => search.direct.record(a, b, effort),
        None => {
            search.direct.reject(a, b);
            false
        }
    })
}

/// The effort S(T) D^3(T) of the step between two placements with footholds, m^3, and whether a
/// primitive posture holds in both of its transitions; none where the feet collide.
fn effort_of(
    context: &PlanningContext,
    search: &mut Search,
    placements: [usize; 2],
) -> Result<Option<(f64, bool)>, ArenaFull> {
    let constraints = &context.constraints;
    let graph = &mut search.roadmap.graph;
    let [from, to] =
        placements.map(|index| search.direct.placements[index].foothold.unwrap_or_default());
    let [a, b] = [from, to].map(|id| &graph.footholds()[id as usize]);
    if constraints
        .collision
        .feet_hit(left_and_right(a, b).map(|foothold| &foothold.world_from_sole))
    {
        return Ok(None);
    }
    let id = transition(graph, from, to)?;
    let both = [id, ModeGraph::twin(id)];
    for id in
        both.into_iter().filter(|&id| graph.is_unestimated(id)).collect::<heapless::Vec<_, 2>>()
    {
        let prior = transition_prior(constraints, id, graph, true);
        graph.record_prior(id, prior);
    }
    let effort = both.map(|id| graph.transitions()[id as usize].effort()).into_iter().sum();
    let is_likely = !both.into_iter().any(|id| graph.is_unlikely(id));
    Ok(Some((effort, is_likely)))
}

/// Makes the path the sequence of the only segment.
fn take_path(search: &mut Search) -> Result<(), ArenaFull> {
    search.segments.begin_route(1);
    let Search { direct, roadmap, segments, stats, .. } = search;
    let graph = &mut roadmap.graph;
    let placements = &direct.placements;
    let foothold = |index: usize| placements[index].foothold.unwrap_or_default();
    let stands = direct.path[0];
    let other = foothold(AT_START[1 - placements[stands].limb]);
    let current = segments.current_mut();
    current.take(&[], SegmentState::Sample { next: 0, failed: false })?;
    current.push(transition(graph, foothold(stands), other)?)?;
    for steps in direct.path.windows(2) {
        let to = transition(graph, foothold(steps[0]), foothold(steps[1]))?;
        current.push(to)?;
        current.push(ModeGraph::twin(to))?;
    }
    // The walk ends as soon as both feet touch the goal.
    current.sequence.pop();
    direct.is_active = true;
    stats.sequences += 1;
    Ok(())
}

/// The transition on two footholds, added if the graph does not have it.
fn transition(
    graph: &mut ModeGraph,
    stance: FootholdId,
    other: FootholdId,
) -> Result<TransitionId, ArenaFull> {
    if let Some(id) = graph.find(stance, other) {
        return Ok(id);
    }
    graph.connect(stance, other)?;
    graph.find(stance, other).ok_or(ArenaFull::Transitions)
}

/// Excludes the steps of the current path whose transitions are unsolved. Returns whether there are
/// any.
pub(crate) fn reject_steps(search: &mut Search) -> bool {
    let Search { direct, roadmap, segments, segmentation, .. } = search;
    let sequence = &segments.current().sequence;
    let RouteSegment { ends, .. } = segmentation.segment(0, sequence);
    let steps = direct.path.len() - 1;
    let mut any = false;
    for step in 0..steps {
        // The last step has no twin; the first one begins on the start.
        let first = if step == 0 { 0 } else { 2 * step + 1 };
        let last = (2 * step + 2).min(sequence.len() - 1);
        let segment = RouteSegment { sequence, ends };
        if (first..=last).any(|index| roadmap.is_unsolved(segment, index)) {
            direct.reject(direct.path[step], direct.path[step + 1]);
            any = true;
        }
    }
    any
}
