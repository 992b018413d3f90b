//! The coarse path of the relaxed problem, which the tree of the start follows before samples are
//! drawn.

use glam::DVec3;

use crate::base::arena::reserve;
use crate::possibility::tree::PossibilityTree;
use crate::possibility::tuning::{COARSE_LEGS_MAX, LEG_END_DISTANCE};

/// A path of straight legs from start to goal.
#[derive(Debug)]
pub struct CoarsePath {
    /// The ends of the legs after the start, m.
    ends: Vec<DVec3>,
    /// Number of legs that branches have followed, or that are left out.
    followed: usize,
    /// The vertex of the tree of the start from which the next leg begins.
    tip: u32,
    /// Whether the tree was trapped on the leg before.
    was_trapped: bool,
}

impl CoarsePath {
    /// No path, with reserved memory. Allocates.
    pub fn new() -> Self {
        Self { ends: reserve(COARSE_LEGS_MAX), followed: 0, tip: 0, was_trapped: false }
    }

    /// Sets the ends of its legs after the start, m. A longer path than memory is reserved for is
    /// left out.
    pub fn set(&mut self, ends: &[DVec3]) {
        self.ends.clear();
        self.restart();
        if ends.len() <= COARSE_LEGS_MAX {
            self.ends.extend_from_slice(ends);
        }
    }

    /// Begins with the first leg, at the start.
    pub fn restart(&mut self) {
        (self.followed, self.tip, self.was_trapped) = (0, 0, false);
    }

    /// Begins after the last leg whose end a tree has reached.
    pub fn begin_after(&mut self, tree: &PossibilityTree) {
        let vertex_at = |end: &DVec3| {
            let near = tree.nearest(|pose| pose.position_distance_squared(*end));
            (tree[near as usize].pose.position.distance(*end) <= LEG_END_DISTANCE).then_some(near)
        };
        let mut reached = self.ends.iter().enumerate().rev();
        let last = reached.find_map(|(index, end)| Some((index + 1, vertex_at(end)?)));
        (self.followed, self.tip) = last.unwrap_or((0, 0));
        self.was_trapped = false;
    }

    /// Whether branches have followed any of its legs.
    pub fn is_begun(&self) -> bool {
        self.followed > 0
    }

    /// The next leg: the vertex from which it begins, its end, m, and whether it is the last one;
    /// none after that.
    pub fn next_leg(&self) -> Option<(u32, DVec3, bool)> {
        let end = *self.ends.get(self.followed)?;
        Some((self.tip, end, self.followed + 1 == self.ends.len()))
    }

    /// A branch along the next leg has ended at a vertex. Returns whether that is the end of the
    /// last one. The rest of a path is left out where the tree is trapped on two legs in a row.
    pub fn end_leg(&mut self, is_reached: bool, tip: u32) -> bool {
        if !is_reached && self.was_trapped {
            self.followed = self.ends.len();
            return false;
        }
        (self.followed, self.tip, self.was_trapped) = (self.followed + 1, tip, !is_reached);
        is_reached && self.followed == self.ends.len()
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.ends.capacity() * size_of::<DVec3>()
    }
}
