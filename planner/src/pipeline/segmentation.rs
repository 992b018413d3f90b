//! Phi_M: the guide route divided into segments that share their end states, and Omega_M, the
//! sequences of all segments joined [Grey 3.2].
//!
//! Between two segments the robot stands on both feet, so the work for a segment depends on its own
//! length alone.

use crate::base::arena::reserve;
use crate::base::capacity::ArenaFull;
use crate::motion::ids::{BOUNDARIES_MAX, TransitionId, boundary_node};
use crate::motion::roadmap::RouteSegment;

/// A segment may use footholds near this many vertices beyond its ends.
const MARGIN_VERTICES: usize = 8;

/// A boundary of a segment.
#[derive(Debug, Clone, Copy)]
struct SegmentBoundary {
    /// The boundary's index in the roadmap.
    boundary: usize,
    /// The vertex of the route at which it lies.
    vertex: usize,
    /// The complete sequence from here to the next boundary: first and count in the arena.
    sequence: Option<(usize, usize)>,
}

/// The boundaries of the current route, start and goal included, and the complete sequences between
/// them, allocated once.
#[derive(Debug)]
pub(crate) struct Segmentation {
    boundaries: Vec<SegmentBoundary>,
    sequences: Vec<TransitionId>,
    /// The transitions of the whole plan, with the nodes of the boundaries.
    plan: Vec<TransitionId>,
    /// Vertices of the route before the detour that stage P searches.
    detour_from: Option<usize>,
}

impl Segmentation {
    /// Reserves memory for sequences of `transitions_max` transitions. No segment yet.
    pub fn new(transitions_max: usize) -> Self {
        Self {
            boundaries: reserve(BOUNDARIES_MAX),
            sequences: reserve(transitions_max),
            plan: reserve(transitions_max),
            detour_from: None,
        }
    }

    /// Begins with a new route, at `start`, a boundary of the roadmap.
    pub fn begin(&mut self, start: usize) {
        self.sequences.clear();
        self.boundaries.clear();
        self.push(start, 0);
    }

    /// Ends a segment at a boundary of the roadmap and a vertex of the route.
    pub fn push(&mut self, boundary: usize, vertex: usize) {
        self.boundaries.push(SegmentBoundary { boundary, vertex, sequence: None });
    }

    /// Number of segments.
    pub fn len(&self) -> usize {
        self.boundaries.len() - 1
    }

    /// The boundaries of a segment in the roadmap.
    pub fn boundaries(&self, segment: usize) -> [usize; 2] {
        [segment, segment + 1].map(|index| self.boundaries[index].boundary)
    }

    /// The first and the last vertex of a segment.
    pub fn vertices(&self, segment: usize) -> [usize; 2] {
        [segment, segment + 1].map(|index| self.boundaries[index].vertex)
    }

    /// The first and the last vertex near which a segment may use footholds.
    pub fn vertex_range(&self, segment: usize) -> [u32; 2] {
        let [first, last] = self.vertices(segment);
        [first.saturating_sub(MARGIN_VERTICES) as u32, (last + MARGIN_VERTICES) as u32]
    }

    /// A segment with a sequence of transitions, as stage M takes it.
    pub fn segment<'a>(&self, segment: usize, sequence: &'a [TransitionId]) -> RouteSegment<'a> {
        RouteSegment { sequence, ends: self.boundaries(segment).map(boundary_node) }
    }

    /// Keeps the complete sequence of a segment.
    ///
    /// # Errors
    /// The arena is full.
    pub fn complete(&mut self, segment: usize, sequence: &[TransitionId]) -> Result<(), ArenaFull> {
        if self.sequences.len() + sequence.len() > self.sequences.capacity() {
            return Err(ArenaFull::Configurations);
        }
        self.boundaries[segment].sequence = Some((self.sequences.len(), sequence.len()));
        self.sequences.extend_from_slice(sequence);
        Ok(())
    }

    /// The vertex up to which the segments from the start are complete; none if the first is not.
    pub fn traversed(&self) -> Option<usize> {
        let complete =
            self.boundaries.iter().take_while(|boundary| boundary.sequence.is_some()).count();
        (complete > 0).then(|| self.boundaries[complete].vertex)
    }

    /// Whether stage P searches a detour.
    pub fn has_detour(&self) -> bool {
        self.detour_from.is_some()
    }

    /// Notes that stage P searches a detour of a route with `vertices` vertices.
    pub fn begin_detour(&mut self, vertices: usize) {
        self.detour_from = Some(vertices);
    }

    /// Notes that stage P searches no detour.
    pub fn cancel_detour(&mut self) {
        self.detour_from = None;
    }

    /// Moves the boundaries after a segment in which a detour was found: the route has `vertices`
    /// vertices. Returns whether stage P searched a detour.
    pub fn end_detour(&mut self, segment: usize, vertices: usize) -> bool {
        let Some(before) = self.detour_from.take() else { return false };
        for boundary in &mut self.boundaries[segment + 1..] {
            boundary.vertex = boundary.vertex + vertices - before;
        }
        true
    }

    /// Joins the sequences of all segments.
    ///
    /// # Errors
    /// The plan has too many transitions.
    pub fn join(&mut self) -> Result<(), ArenaFull> {
        self.plan.clear();
        for boundary in &self.boundaries {
            let (first, count) = boundary.sequence.unwrap_or_default();
            if self.plan.len() + count + 1 > self.plan.capacity() {
                return Err(ArenaFull::Configurations);
            }
            self.plan.push(boundary_node(boundary.boundary));
            self.plan.extend_from_slice(&self.sequences[first..first + count]);
        }
        Ok(())
    }

    /// The transitions of the whole plan after [`Segmentation::join`], with the boundaries' nodes.
    pub fn plan(&self) -> &[TransitionId] {
        &self.plan
    }

    /// Makes `nodes` the whole plan: its transitions with the nodes of its ends.
    pub fn set_plan(&mut self, nodes: &[TransitionId]) {
        self.plan.clear();
        let fitting = nodes.len().min(self.plan.capacity());
        self.plan.extend_from_slice(&nodes[..fitting]);
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.boundaries.capacity() * size_of::<SegmentBoundary>()
            + (self.sequences.capacity() + self.plan.capacity()) * size_of::<TransitionId>()
    }
}
