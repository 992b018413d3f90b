//! The two trees of Gamma_P, from the start and from the goal, and the placements at their
//! vertices.

use super::label::Label;
use super::stance::{Context, PLACEMENTS_MAX, Placed, Stance};
use super::tree::{Tree, Vertex};
use crate::arena::{Place, reserve};

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
    pub trees: [Tree; 2],
    pub placements: Vec<Placed>,
    pub labelled: Labelled,
}

impl Forest {
    /// Room for so many vertices in each tree; none yet.
    pub fn new(vertices_max: usize) -> Self {
        let trees = [(); 2].map(|()| Tree::new(vertices_max));
        Self {
            trees,
            placements: reserve(vertices_max * PLACEMENTS_MAX / 2),
            labelled: Labelled::default(),
        }
    }

    /// Adds a stance to a tree, reached from `parent`; `None` where there is no room.
    pub fn add(
        &mut self,
        (tree, parent): (usize, u32),
        facing: f64,
        stance: &Stance,
    ) -> Option<u32> {
        if self.trees[tree].is_full() {
            return None;
        }
        let root = Vertex::root(stance.station, stance.pair);
        let vertex = Vertex {
            placements: self.keep(stance)?,
            parent,
            facing,
            is_upright: stance.is_upright,
            ..root
        };
        Some(self.trees[tree].add(vertex))
    }

    /// Labels the edge that leads to a vertex.
    pub fn label_edge(&mut self, (tree, vertex): (usize, u32), context: &Context<'_>) {
        let ends = [self.trees[tree][vertex as usize].parent, vertex].map(|index| index as usize);
        let [from, to] = ends.map(|index| context.pair_of(&mut self.trees[tree][index]));
        let label = from
            .zip(to)
            .map_or(Label::Indeterminate, |(from, to)| context.label_between(&from, &to));
        self.labelled.edges += 1;
        self.labelled.possible += u64::from(label.is_possible());
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.trees.iter().map(Tree::bytes).sum::<usize>()
            + self.placements.capacity() * size_of::<Placed>()
    }

    fn keep(&mut self, stance: &Stance) -> Option<Place> {
        let first = self.placements.len() as u32;
        if self.placements.len() + stance.placements.len() > self.placements.capacity() {
            return None;
        }
        self.placements.extend_from_slice(&stance.placements);
        Some((first, stance.placements.len() as u32))
    }
}
