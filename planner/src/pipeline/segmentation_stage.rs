//! Divides a new route into segments, at vertices where the robot can stand on even ground
//! [Grey 3.2].

use surefoot_shared_types::Pose;
use surefoot_shared_types::message::SupportMode;

use crate::base::capacity::ArenaFull;
use crate::constraints::foothold::{FootPlacement, Foothold};
use crate::motion::ids::{GOAL, START};
use crate::motion::roadmap::Boundary;
use crate::pipeline::endpoints::{foothold_at, stand};
use crate::pipeline::search::Search;
use crate::pipeline::stage::Event;
use crate::possibility::{IdealWidth, RouteSearch};
use crate::preparation::planning_context::PlanningContext;

/// Vertices of a segment; more where the robot cannot stand there.
const SEGMENT_VERTICES: usize = 36;
/// Distance before and after a boundary over which the ground must be even, m: about one step.
const EVEN_REACH: f64 = 0.45;
/// Greatest distance (m) of a sole from its ideal at a boundary and beside it: the ground is even
/// and wide there.
const OFFSET_MAX: f64 = 1e-3;

/// Finds the boundaries of a new route, one vertex per unit of work.
#[derive(Debug, Default)]
pub(crate) struct SegmentationStage {
    /// The next vertex at which the route may be divided; none before the first.
    next: Option<usize>,
}

impl SegmentationStage {
    /// Divides the route at the next vertex if the robot can stand there.
    ///
    /// # Errors
    /// The foothold arena is full.
    pub fn step(
        &mut self,
        context: &PlanningContext,
        search: &mut Search,
        _budget: u64,
    ) -> Result<Event, ArenaFull> {
        search.stats.work += 1;
        let vertex = self.next.take().unwrap_or_else(|| {
            search.segmentation.begin(START);
            SEGMENT_VERTICES
        });
        let vertices = search.route.route().vertex_count();
        let is_last = vertex + SEGMENT_VERTICES / 2 >= vertices
            || search.footholds.uniform.may_face_anywhere();
        if is_last || search.roadmap.is_full_of_boundaries() {
            search.segmentation.push(GOAL, vertices - 1);
            search.segments.begin_route(search.segmentation.len());
            search.begin_sweep();
            return Ok(Event::Done);
        }
        self.next = Some(vertex + 1);
        if let Some(boundary) = boundary_at(context, search, vertex)? {
            let boundary = search.roadmap.add_boundary(boundary);
            search.segmentation.push(boundary, vertex);
            self.next = Some(vertex + SEGMENT_VERTICES);
        }
        Ok(Event::Continue)
    }
}

/// The robot on both feet at a vertex with even and wide ground around it; none elsewhere.
fn boundary_at(
    context: &PlanningContext,
    search: &mut Search,
    vertex: usize,
) -> Result<Option<Boundary>, ArenaFull> {
    let Some(soles) = soles_on_even_ground(&search.route, vertex) else { return Ok(None) };
    let constraints = &context.constraints;
    let scratch = &mut search.footholds.scratch[0];
    let mut stand_on =
        |limb| foothold_at(constraints, &context.surfaces, scratch, limb, &soles[limb]).ok();
    let (Some(left), Some(right)) = (stand_on(0), stand_on(1)) else { return Ok(None) };
    let footholds: [Foothold; 2] = [left, right];
    let yaw = search.route.route().pose(vertex).yaw;
    let Ok(state) = stand(constraints, &footholds, yaw) else { return Ok(None) };
    let graph = &mut search.roadmap.graph;
    let footholds =
        [graph.identical_or_new(&footholds[0])?, graph.identical_or_new(&footholds[1])?];
    Ok(Some(Boundary { footholds, state, support: SupportMode::Double }))
}

/// The poses of both soles at a vertex, if the ground is even from [`EVEN_REACH`] before it to as
/// far after it.
fn soles_on_even_ground(search: &RouteSearch, vertex: usize) -> Option<[Pose; 2]> {
    let route = search.route();
    let near_ideal = |vertex: usize, limb: usize| {
        let ideal = route.world_from_ideal_sole(vertex, limb, IdealWidth::Walking);
        let is_near = |placed: &&FootPlacement| {
            placed.limb == limb
                && placed.world_from_sole.translation.distance(ideal.translation) < OFFSET_MAX
        };
        search.placements(vertex).iter().find(is_near).map(|placed| placed.world_from_sole)
    };
    let (left, right) = (near_ideal(vertex, 0)?, near_ideal(vertex, 1)?);
    let is_even = |beside: usize| [0, 1].iter().all(|&limb| near_ideal(beside, limb).is_some());
    let is_near = |beside: &usize| {
        route.pose(*beside).position.distance(route.pose(vertex).position) < EVEN_REACH
    };
    let (mut before, mut after) = (
        (0..vertex).rev().take_while(is_near),
        (vertex + 1..route.vertex_count()).take_while(is_near),
    );
    (before.all(is_even) && after.all(is_even)).then_some([left, right])
}
