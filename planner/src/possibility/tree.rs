//! A tree of Gamma_P. Every vertex except the root is reached from another one.

use std::ops::{Deref, DerefMut};

use crate::base::arena::{ArenaSlice, reserve, slice_at};
use crate::constraints::foothold::{FootPair, FootPlacement};
use crate::possibility::mid_feet_pose::MidFeetPose;
use crate::possibility::root_vertex::{PostureId, RootVertex, UPRIGHT};
use crate::possibility::tuning::NEIGHBOUR_RADIUS;

/// A vertex of a tree.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Vertex {
    pub pose: MidFeetPose,
    /// Index of the parent vertex; the root is its own parent.
    pub parent: u32,
    /// Its placements, in the arena.
    pub placements: ArenaSlice,
    /// The pair of placements below the pose, if their feet do not collide.
    pub pair: Option<FootPair>,
    /// Whether primitives are possible on its pair (C_S); `None` until tested.
    pub has_primitives: Option<bool>,
    /// Whether the upper body of the upright robot is free there.
    pub is_upright: bool,
    /// Whether stage M has solved the edge that leads to it from the previous route vertex.
    pub is_traversed: bool,
    /// Heading of the robot relative to the walking direction, rad.
    pub heading_offset: f64,
    /// The root posture there.
    pub posture: PostureId,
    /// Number of vertices of its tree near it, plus samples drawn around it.
    pub neighbour_count: u32,
}

impl Vertex {
    /// Its root pose.
    pub(crate) fn root_vertex(&self) -> RootVertex {
        RootVertex { pose: self.pose, posture: self.posture }
    }

    /// A vertex without placements that is its own parent.
    pub(crate) fn root(pose: MidFeetPose, pair: Option<FootPair>) -> Self {
        Self {
            pose,
            parent: 0,
            placements: (0, 0),
            pair,
            has_primitives: None,
            is_upright: true,
            is_traversed: false,
            heading_offset: 0.0,
            posture: UPRIGHT,
            neighbour_count: 0,
        }
    }
}

/// A tree, allocated once.
#[derive(Debug)]
pub(crate) struct PossibilityTree {
    vertices: Vec<Vertex>,
    /// The vertices' poses in one array, for distance queries.
    poses: Vec<MidFeetPose>,
}

impl PossibilityTree {
    /// An empty tree with capacity for `vertices_max` vertices. Allocates.
    pub fn new(vertices_max: usize) -> Self {
        Self { vertices: reserve(vertices_max), poses: reserve(vertices_max) }
    }

    /// Whether the arena of vertices is full.
    pub fn is_full(&self) -> bool {
        self.vertices.len() == self.vertices.capacity()
    }

    /// Replaces the vertices; does nothing if the new ones do not fit.
    pub fn set(&mut self, vertices: &[Vertex]) {
        if vertices.len() > self.vertices.capacity() {
            return;
        }
        self.vertices.clear();
        self.poses.clear();
        self.vertices.extend_from_slice(vertices);
        self.poses.extend(vertices.iter().map(|vertex| vertex.pose));
    }

    /// Adds a vertex and updates the neighbour counts. Returns its index. The tree must not be
    /// full.
    pub fn add(&mut self, mut vertex: Vertex) -> u32 {
        let at = vertex.pose;
        let is_near = |near: &MidFeetPose| {
            near.position_distance_squared(at.position) < NEIGHBOUR_RADIUS * NEIGHBOUR_RADIUS
                && near.distance(&at) < NEIGHBOUR_RADIUS
        };
        for (index, _) in self.poses.iter().enumerate().filter(|(_, near)| is_near(near)) {
            self.vertices[index].neighbour_count += 1;
            vertex.neighbour_count += 1;
        }
        self.vertices.push(vertex);
        self.poses.push(at);
        (self.vertices.len() - 1) as u32
    }

    /// Index of the vertex whose pose has the least distance; the first of several.
    pub fn nearest(&self, distance: impl Fn(&MidFeetPose) -> f64) -> u32 {
        let mut best = (0, f64::INFINITY);
        for (index, pose) in self.poses.iter().enumerate() {
            let d = distance(pose);
            if d < best.1 {
                best = (index, d);
            }
        }
        best.0 as u32
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.vertices.capacity() * size_of::<Vertex>()
            + self.poses.capacity() * size_of::<MidFeetPose>()
    }
}

/// The vertices. Their poses must not be changed.
impl Deref for PossibilityTree {
    type Target = [Vertex];

    fn deref(&self) -> &[Vertex] {
        &self.vertices
    }
}

impl DerefMut for PossibilityTree {
    fn deref_mut(&mut self) -> &mut [Vertex] {
        &mut self.vertices
    }
}

/// The last vertex of a branch.
#[derive(Debug, Clone, Copy)]
pub struct Tip<'a> {
    /// The pose.
    pub pose: &'a MidFeetPose,
    /// The placements there; empty if they are not known.
    pub placements: &'a [FootPlacement],
    /// The root posture there.
    pub posture: PostureId,
}

impl Tip<'_> {
    /// The tip's root pose.
    pub(crate) fn root(&self) -> RootVertex {
        RootVertex { pose: *self.pose, posture: self.posture }
    }
}

/// The tip at a vertex, with all its placements if they are kept, else with its pair.
pub(crate) fn tip_at<'a>(vertex: &'a Vertex, placements: &'a [FootPlacement]) -> Tip<'a> {
    let kept = slice_at(placements, vertex.placements);
    let known = if kept.is_empty() { vertex.pair.as_ref().map_or(kept, |pair| pair) } else { kept };
    Tip { pose: &vertex.pose, placements: known, posture: vertex.posture }
}

/// Appends a vertex and its ancestors to `out`, the root last, up to the capacity of `out`.
pub(crate) fn push_branch(tree: &[Vertex], tip: u32, out: &mut Vec<Vertex>) {
    let mut at = tip as usize;
    while out.len() < out.capacity() {
        out.push(tree[at]);
        if at == 0 {
            break;
        }
        at = tree[at].parent as usize;
    }
}
