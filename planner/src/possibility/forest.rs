//! The two trees of Gamma_P, from the start and from the goal, and the placements at their
//! vertices.

use crate::base::arena::{ArenaSlice, reserve};
use crate::constraints::foothold::FootPlacement;
use crate::possibility::edge_labels::Label;
use crate::possibility::tree::{PossibilityTree, Vertex};
use crate::possibility::tuning::VERTEX_PLACEMENTS_MAX;
use crate::possibility::vertex_candidates::{StageContext, VertexCandidate};

/// Number of labelled edges of stage P.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct LabelStats {
    /// All labelled edges.
    pub edges: u64,
    /// Edges labelled possible.
    pub possible: u64,
}

/// The trees, allocated once.
#[derive(Debug)]
pub(crate) struct Forest {
    pub trees: [PossibilityTree; 2],
    pub placements: Vec<FootPlacement>,
    pub labelled: LabelStats,
}

impl Forest {
    /// Two empty trees with capacity for `vertices_max` vertices each. Allocates.
    pub fn new(vertices_max: usize) -> Self {
        let trees = [(); 2].map(|()| PossibilityTree::new(vertices_max));
        Self {
            trees,
            placements: reserve(vertices_max * VERTEX_PLACEMENTS_MAX / 2),
            labelled: LabelStats::default(),
        }
    }

    /// Adds a candidate to a tree as a child of `parent`; `None` if an arena is full.
    pub fn add(
        &mut self,
        (tree, parent): (usize, u32),
        heading_offset: f64,
        candidate: &VertexCandidate,
    ) -> Option<u32> {
        if self.trees[tree].is_full() {
            return None;
        }
        let pair = candidate.pair.filter(|_| candidate.are_apart);
        let root = Vertex::root(candidate.pose, pair);
        let vertex = Vertex {
            placements: self.store_placements(candidate)?,
            parent,
            heading_offset,
            is_upright: candidate.is_upright,
            posture: candidate.posture,
            ..root
        };
        Some(self.trees[tree].add(vertex))
    }

    /// Labels the edge from the parent of a vertex to it, and counts it.
    pub fn label_edge(&mut self, (tree, vertex): (usize, u32), context: &StageContext<'_>) {
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
        self.trees.iter().map(PossibilityTree::bytes).sum::<usize>()
            + self.placements.capacity() * size_of::<FootPlacement>()
    }

    /// Stores the placements of a candidate; `None` if the arena is full.
    fn store_placements(&mut self, candidate: &VertexCandidate) -> Option<ArenaSlice> {
        let first = self.placements.len() as u32;
        if self.placements.len() + candidate.placements.len() > self.placements.capacity() {
            return None;
        }
        self.placements.extend_from_slice(&candidate.placements);
        Some((first, candidate.placements.len() as u32))
    }
}
