//! The guide route: vertices from the start to the goal [Grey 3.2].

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::config::scenario::StancePose;

use crate::base::arena::reserve;
use crate::constraints::foothold::{FootPair, FootPlacement};
use crate::possibility::edge_labels::Label;
use crate::possibility::forest::LabelStats;
use crate::possibility::mid_feet_pose::MidFeetPose;
use crate::possibility::root_vertex::UPRIGHT;
use crate::possibility::tree::Vertex;
use crate::possibility::tuning::{ALIGNED_DISTANCE, STRAIGHT_END_DISTANCE};
use crate::possibility::vertex_sampling::BACKWARD;

/// How far the ideal soles at a vertex are apart.
#[derive(Debug, Clone, Copy)]
pub enum IdealWidth {
    /// As narrow as the robot walks, on routes for which that holds.
    Walking,
    /// A multiple of the stance width at start and goal.
    OfEnds(f64),
}

/// Vertices from start to goal, both included. The route search keeps their placements.
#[derive(Debug)]
pub struct GuideRoute {
    pub(crate) vertices: Vec<Vertex>,
    /// The label of the edge that leads to each vertex; that of the first is not used.
    pub(crate) labels: Vec<Label>,
    /// Stance widths at start and goal, m.
    stance_width: [f64; 2],
    /// Largest stance width between them, m.
    walking_width: f64,
    /// Memory in which a changed route is assembled.
    spare: Vec<Vertex>,
}

impl GuideRoute {
    /// An empty route with capacity for two trees of `vertices_max` vertices. Allocates.
    pub(crate) fn new(
        [start, goal]: [&StancePose; 2],
        walking_width: f64,
        vertices_max: usize,
    ) -> Self {
        Self {
            vertices: reserve(2 * vertices_max),
            labels: reserve(2 * vertices_max),
            stance_width: [start.stance_width, goal.stance_width],
            walking_width,
            spare: reserve(2 * vertices_max),
        }
    }

    /// Sets the stance width of another start stance.
    pub(crate) fn set_start(&mut self, start: &StancePose) {
        self.stance_width[0] = start.stance_width;
    }

    /// Largest stance width between the ends, m; infinite where it is as there.
    pub(crate) fn walking_width(&self) -> f64 {
        self.walking_width
    }

    /// Lets stances be as wide between the ends as there.
    pub(crate) fn widen_stances(&mut self) {
        self.walking_width = f64::INFINITY;
    }

    /// Removes all vertices.
    pub(crate) fn clear(&mut self) {
        self.vertices.clear();
        self.labels.clear();
    }

    /// Makes the straight line between two poses the route, in strides of `spacing` metres.
    pub(crate) fn make_straight(&mut self, [mut at, goal]: [MidFeetPose; 2], spacing: f64) {
        self.clear();
        let count_max = self.vertices.capacity() - 1;
        while self.vertices.len() < count_max && at.distance(&goal) > STRAIGHT_END_DISTANCE {
            self.vertices.push(Vertex { is_upright: false, ..Vertex::root(at, None) });
            at = at.step_toward(&goal, spacing, 0.0);
            at.position.z += (goal.position.z - at.position.z)
                * (spacing / at.horizontal_offset_to(&goal).length().max(spacing));
        }
        self.vertices.push(Vertex::root(goal, None));
        self.labels.resize(self.vertices.len(), Label::Indeterminate);
    }

    /// Replaces the vertices between two of the route. `is_upright` is whether the upright robot
    /// fits on the edge to the second.
    pub(crate) fn splice(&mut self, [from, to]: [usize; 2], between: &[Vertex], is_upright: bool) {
        self.spare.clear();
        self.spare.extend_from_slice(&self.vertices[..=from]);
        self.spare.extend_from_slice(between);
        let joined = self.spare.len();
        self.spare.extend_from_slice(&self.vertices[to..]);
        self.spare[joined].is_traversed = false;
        self.spare[joined].is_upright &= is_upright;
        std::mem::swap(&mut self.spare, &mut self.vertices);
    }

    /// Inserts this route, a detour, into a full route in place of the vertices from `first` to
    /// `last`. This route becomes the result; it becomes the full route if the result does not fit.
    pub(crate) fn insert_into(&mut self, full_route: &mut Vec<Vertex>, [first, last]: [usize; 2]) {
        if full_route.len() + self.vertices.len() > self.spare.capacity() {
            std::mem::swap(full_route, &mut self.vertices);
            return;
        }
        self.spare.clear();
        self.spare.extend_from_slice(&full_route[..first]);
        self.spare.extend_from_slice(&self.vertices);
        self.spare.extend_from_slice(&full_route[last + 1..]);
        std::mem::swap(&mut self.spare, &mut self.vertices);
    }

    /// Bytes reserved.
    pub(crate) fn bytes(&self) -> usize {
        (self.vertices.capacity() + self.spare.capacity()) * size_of::<Vertex>()
            + self.labels.capacity() * size_of::<Label>()
    }

    /// The label of the edge from the previous vertex to this one.
    pub fn label(&self, index: usize) -> Label {
        self.labels[index]
    }

    /// Number of edges, and of those that are possible.
    pub fn labelled(&self) -> LabelStats {
        let edges = self.labels.len().saturating_sub(1) as u64;
        LabelStats {
            edges,
            possible: self.labels.iter().filter(|label| label.is_possible()).count() as u64,
        }
    }

    /// Whether a primitive along the route uses a placement at a vertex.
    pub fn is_used_by_primitives(&self, index: usize, placement: &FootPlacement) -> bool {
        let is_primitive = |label: Option<&Label>| matches!(label, Some(Label::Primitive { .. }));
        let is_possible =
            is_primitive(self.labels.get(index)) || is_primitive(self.labels.get(index + 1));
        is_possible && self.pair(index).is_some_and(|pair| pair.contains(placement))
    }

    /// The pair of placements of a vertex.
    pub fn pair(&self, index: usize) -> Option<&FootPair> {
        self.vertices[index].pair.as_ref()
    }

    /// Number of vertices.
    pub fn vertex_count(&self) -> usize {
        self.vertices.len()
    }

    /// Whether the upright robot fits along the whole route.
    pub fn is_upright(&self) -> bool {
        self.vertices.iter().all(|vertex| vertex.is_upright)
    }

    /// Whether the upright robot fits after one vertex and up to another.
    pub(crate) fn is_upright_between(&self, [from, to]: [usize; 2]) -> bool {
        self.vertices[from + 1..=to].iter().all(|vertex| vertex.is_upright)
    }

    /// Whether the upright robot fits at a vertex and at `reach` vertices before and after it.
    pub fn is_upright_about(&self, index: usize, reach: usize) -> bool {
        let about = index.saturating_sub(reach)..self.vertices.len().min(index + reach + 1);
        self.vertices[about].iter().all(|vertex| vertex.is_upright)
    }

    /// Whether the root leans somewhere on the route.
    pub fn is_leaning(&self) -> bool {
        self.vertices.iter().any(|vertex| vertex.posture != UPRIGHT)
    }

    /// Whether a part of the route is walked backward.
    pub fn is_backward(&self) -> bool {
        self.vertices.iter().any(|vertex| vertex.heading_offset == BACKWARD)
    }

    /// Whether a foot at `pose` has the heading of the robot on this route. On a route that is
    /// partly walked backward, feet that face forward would repeat earlier failures.
    pub fn is_aligned_with(&self, pose: &MidFeetPose) -> bool {
        !self.is_backward()
            || self.vertices.iter().any(|vertex| vertex.pose.distance(pose) < ALIGNED_DISTANCE)
    }

    /// The pose of a vertex.
    pub fn pose(&self, index: usize) -> MidFeetPose {
        self.vertices[index].pose
    }

    /// The index of the vertex nearest to a position (world, m); the first of several.
    pub fn nearest_vertex(&self, position: DVec3) -> usize {
        let distance = |index: usize| self.pose(index).position_distance_squared(position);
        let nearer =
            |best: usize, index: usize| if distance(index) < distance(best) { index } else { best };
        (1..self.vertex_count()).fold(0, nearer)
    }

    /// Ideal sole pose at a vertex: beside the route, with its heading. The stance width of the
    /// ends is interpolated between start and goal.
    pub fn world_from_ideal_sole(&self, index: usize, limb: usize, width: IdealWidth) -> Pose {
        let fraction = index as f64 / (self.vertex_count() - 1).max(1) as f64;
        let [from, to] = self.stance_width;
        let of_ends = from + fraction * (to - from);
        let stance_width = match width {
            IdealWidth::Walking => of_ends.min(self.walking_width),
            IdealWidth::OfEnds(factor) => factor * of_ends,
        };
        self.pose(index).world_from_ideal_sole(limb, stance_width)
    }
}
