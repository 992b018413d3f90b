//! What the foothold stage samples next, and at which vertices of the route.

use crate::base::arena::reserve;

/// Vertices on either side of a selected one that get footholds, too.
const NEIGHBOURS: usize = 2;

/// The next task of the foothold stage.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FootholdOrder {
    /// Sample at the selected vertices of the route. `next` counts both feet of each vertex.
    Sweep { next: usize },
    /// Sample near the transitions of the current sequence, from `index` on.
    SampleNear { index: usize },
    /// Perturb the footholds of the transitions of the current sequence, from `index` to `end`;
    /// `tried` perturbations of the first are done.
    Perturb { index: usize, tried: usize, end: usize },
    /// Sample a round of footholds uniformly; this many are left.
    Uniform { left: u32 },
}

/// The vertices of the route that a sweep visits, allocated once.
#[derive(Debug, Default)]
pub(crate) struct VertexSelection {
    is_selected: Vec<bool>,
}

impl VertexSelection {
    /// Reserves memory for `vertices_max` vertices.
    pub fn new(vertices_max: usize) -> Self {
        Self { is_selected: reserve(vertices_max) }
    }

    /// Selects those of `vertices` vertices for which `is_selected` holds.
    pub fn select(&mut self, vertices: usize, is_selected: impl Fn(usize) -> bool) {
        self.is_selected.clear();
        self.is_selected.extend((0..vertices).map(is_selected));
    }

    /// Selects, of `vertices` vertices, the given ones and their neighbours.
    pub fn select_about(&mut self, vertices: usize, given: impl Iterator<Item = usize>) {
        self.select(vertices, |_| false);
        for vertex in given {
            let end = (vertex + NEIGHBOURS + 1).min(vertices);
            self.is_selected[vertex.saturating_sub(NEIGHBOURS)..end].fill(true);
        }
    }

    /// Whether a vertex is selected.
    pub fn contains(&self, vertex: usize) -> bool {
        self.is_selected[vertex]
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.is_selected.capacity()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_selection_includes_the_neighbours_of_the_given_vertices() {
        let mut selection = VertexSelection::new(10);
        selection.select_about(10, [0, 6].into_iter());
        let selected: Vec<usize> = (0..10).filter(|&vertex| selection.contains(vertex)).collect();
        assert_eq!(selected, [0, 1, 2, 4, 5, 6, 7, 8]);
    }
}
