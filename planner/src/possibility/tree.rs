//! A tree of Gamma_P: stations, each reached from another one.

use std::ops::{Deref, DerefMut};

use super::branch::Tip;
use super::stance::{Pair, Placed};
use super::station::Station;
use crate::arena::{Place, list_at, reserve};

/// Vertices this near (in the metric of Gamma_P, m) crowd each other.
const CROWD_RADIUS: f64 = 0.5;

/// A station of a tree.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vertex {
    pub station: Station,
    /// The vertex it was reached from; the root's is itself.
    pub parent: u32,
    /// Its placements, in the arena.
    pub placements: Place,
    /// The placements that it stands on, if it has two that are apart.
    pub pair: Option<Pair>,
    /// Whether primitives lead over it, once that was asked.
    pub stands: Option<bool>,
    /// Whether all that the root carries has room there with the robot upright.
    pub is_upright: bool,
    /// Whether stage M has crossed the edge that leads to it from the vertex before it on the
    /// route.
    pub is_crossed: bool,
    /// How far off the way it is walked on the robot faces, rad.
    pub facing: f64,
    /// Vertices of its tree that were added near it, and samples drawn about it.
    pub crowd: u32,
}

impl Vertex {
    pub(super) fn root(station: Station, pair: Option<Pair>) -> Self {
        Self {
            station,
            parent: 0,
            placements: (0, 0),
            pair,
            stands: None,
            is_upright: true,
            is_crossed: false,
            facing: 0.0,
            crowd: 0,
        }
    }
}

/// A tree, allocated once.
#[derive(Debug)]
pub(super) struct Tree {
    vertices: Vec<Vertex>,
    /// The vertices' stations, side by side for whoever looks at all of them.
    stations: Vec<Station>,
}

impl Tree {
    /// Room for so many vertices; none yet.
    pub fn new(vertices_max: usize) -> Self {
        Self { vertices: reserve(vertices_max), stations: reserve(vertices_max) }
    }

    /// Whether there is room for no more vertices.
    pub fn is_full(&self) -> bool {
        self.vertices.len() == self.vertices.capacity()
    }

    /// Makes these its vertices, if there is room for them.
    pub fn set(&mut self, vertices: &[Vertex]) {
        if vertices.len() > self.vertices.capacity() {
            return;
        }
        self.vertices.clear();
        self.stations.clear();
        self.vertices.extend_from_slice(vertices);
        self.stations.extend(vertices.iter().map(|vertex| vertex.station));
    }

    /// Adds a vertex, for which there must be room: it counts to the crowd about each that is near
    /// it, and these to the crowd about it. Answers its index.
    pub fn add(&mut self, mut vertex: Vertex) -> u32 {
        let at = vertex.station;
        let is_near = |near: &Station| {
            near.place_distance_squared(at.position) < CROWD_RADIUS * CROWD_RADIUS
                && near.distance(&at) < CROWD_RADIUS
        };
        for (index, _) in self.stations.iter().enumerate().filter(|(_, near)| is_near(near)) {
            self.vertices[index].crowd += 1;
            vertex.crowd += 1;
        }
        self.vertices.push(vertex);
        self.stations.push(at);
        (self.vertices.len() - 1) as u32
    }

    /// The vertex whose station is the least in some distance.
    pub fn nearest(&self, distance: impl Fn(&Station) -> f64) -> u32 {
        let mut best = (0, f64::INFINITY);
        for (index, station) in self.stations.iter().enumerate() {
            let d = distance(station);
            if d < best.1 {
                best = (index, d);
            }
        }
        best.0 as u32
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.vertices.capacity() * size_of::<Vertex>()
            + self.stations.capacity() * size_of::<Station>()
    }
}

/// Its vertices; stations stay where they are.
impl Deref for Tree {
    type Target = [Vertex];

    fn deref(&self) -> &[Vertex] {
        &self.vertices
    }
}

impl DerefMut for Tree {
    fn deref_mut(&mut self) -> &mut [Vertex] {
        &mut self.vertices
    }
}

/// A vertex as the end of a branch, with its placements, or at least those that it stands on.
pub(super) fn tip_at<'a>(vertex: &'a Vertex, placements: &'a [Placed]) -> Tip<'a> {
    let kept = list_at(placements, vertex.placements);
    let known = if kept.is_empty() { vertex.pair.as_ref().map_or(kept, |pair| pair) } else { kept };
    Tip { station: &vertex.station, placements: known }
}

/// Appends a vertex and those it was reached from, the root last.
pub(super) fn push_branch(tree: &[Vertex], tip: u32, out: &mut Vec<Vertex>) {
    let mut at = tip as usize;
    while out.len() < out.capacity() {
        out.push(tree[at]);
        if at == 0 {
            break;
        }
        at = tree[at].parent as usize;
    }
}
