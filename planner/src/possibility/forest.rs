//! The two trees of Gamma_P, from the start and from the goal, and the placements at their vertices.

use super::extension::Tip;
use super::label::Label;
use super::sampling::join_crowd;
use super::stance::{Context, PLACEMENTS_MAX, Pair, Placed, Stance};
use super::station::Station;
use crate::arena::reserve;

/// A station of a tree.
#[derive(Debug, Clone, Copy)]
pub(super) struct Vertex {
    pub station: Station,
    /// The vertex it was reached from; the root's is itself.
    pub parent: u32,
    /// Its placements: first and count in the arena.
    pub placements: (u32, u32),
    /// The placements that it stands on, if it has two that are apart.
    pub pair: Option<Pair>,
    /// Whether primitives lead over it, once that was asked.
    pub stands: Option<bool>,
    /// Whether all that the root carries has room there with the robot upright.
    pub is_upright: bool,
    /// Whether stage M has crossed the edge that leads to it from the vertex before it on the route.
    pub is_crossed: bool,
    /// How far off the way it is walked on the robot faces, rad.
    pub facing: f64,
    /// Vertices of its tree that were added near it, and samples drawn about it.
    pub crowd: u32,
}

impl Vertex {
    pub(super) fn root(station: Station, pair: Option<Pair>) -> Self {
        Self { station, parent: 0, placements: (0, 0), pair, stands: None, is_upright: true, is_crossed: false, facing: 0.0, crowd: 0 }
    }
}

/// How many edges stage P has labelled.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Labelled {
    /// Edges of the trees.
    pub edges: u64,
    /// Those of them that are possible.
    pub possible: u64,
}

/// The trees, allocated once.
#[derive(Debug)]
pub(super) struct Forest {
    pub trees: [Vec<Vertex>; 2],
    pub placements: Vec<Placed>,
    pub labelled: Labelled,
}

impl Forest {
    /// Room for so many vertices in each tree; none yet.
    pub fn new(vertices_max: usize) -> Self {
        let trees = [(); 2].map(|()| reserve(vertices_max));
        Self { trees, placements: reserve(vertices_max * PLACEMENTS_MAX / 2), labelled: Labelled::default() }
    }

    /// Adds a stance to a tree, reached from `parent`; `None` where there is no room.
    pub fn add(&mut self, (tree, parent): (usize, u32), facing: f64, stance: &Stance) -> Option<u32> {
        if self.trees[tree].len() == self.trees[tree].capacity() {
            return None;
        }
        let root = Vertex::root(stance.station, stance.pair);
        let mut vertex = Vertex { placements: self.keep(stance)?, parent, facing, is_upright: stance.is_upright, ..root };
        join_crowd(&mut self.trees[tree], &mut vertex);
        self.trees[tree].push(vertex);
        Some((self.trees[tree].len() - 1) as u32)
    }

    /// Labels the edge that leads to a vertex.
    pub fn label_edge(&mut self, (tree, vertex): (usize, u32), context: &Context<'_>) {
        let ends = [self.trees[tree][vertex as usize].parent, vertex].map(|index| index as usize);
        let [from, to] = ends.map(|index| context.pair_of(&mut self.trees[tree][index]));
        let label = from.zip(to).map_or(Label::Indeterminate, |(from, to)| context.label_between(&from, &to));
        self.labelled.edges += 1;
        self.labelled.possible += u64::from(label.is_possible());
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        let vertices = self.trees.iter().map(Vec::capacity).sum::<usize>();
        vertices * size_of::<Vertex>() + self.placements.capacity() * size_of::<Placed>()
    }

    fn keep(&mut self, stance: &Stance) -> Option<(u32, u32)> {
        let first = self.placements.len() as u32;
        if self.placements.len() + stance.placements.len() > self.placements.capacity() {
            return None;
        }
        self.placements.extend_from_slice(&stance.placements);
        Some((first, stance.placements.len() as u32))
    }
}

/// A vertex as the end of a branch, with its placements, or at least those that it stands on.
pub(super) fn tip_at<'a>(vertex: &'a Vertex, placements: &'a [Placed]) -> Tip<'a> {
    let (first, count) = vertex.placements;
    let known =
        if count > 0 { &placements[first as usize..(first + count) as usize] } else { vertex.pair.as_ref().map_or(&[][..], |pair| pair) };
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
