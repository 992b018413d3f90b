//! The memory of one single-mode search, allocated once and used by one task at a time.

use crate::body::Configuration;
use crate::constraint::Rejection;
use crate::motion::track::State;

/// A node of a tree: a state and the node it was reached from.
#[derive(Debug, Clone, Copy)]
pub struct TreeNode {
    /// The state.
    pub state: State,
    /// The node before; the root's is itself.
    pub parent: u32,
}

/// A search's memory.
#[derive(Debug)]
pub struct Workspace {
    /// The motion found: waypoints after the first state, the last one included.
    pub track: Vec<Configuration>,
    /// The two trees.
    pub trees: [Vec<TreeNode>; 2],
    /// Work spent.
    pub work: u64,
    /// How often each condition turned something down.
    pub rejections: [u64; Rejection::COUNT],
}

impl Workspace {
    /// Memory for tracks and trees of these lengths.
    pub fn new(track_max: usize, tree_nodes_max: usize) -> Self {
        let tree = || Vec::with_capacity(tree_nodes_max);
        Self { track: Vec::with_capacity(track_max), trees: [tree(), tree()], work: 0, rejections: [0; Rejection::COUNT] }
    }

    /// Appends a waypoint; `false` where the track is full.
    pub fn push(&mut self, configuration: &Configuration) -> bool {
        let fits = self.track.len() < self.track.capacity();
        if fits {
            self.track.push(*configuration);
        }
        fits
    }

    /// Counts a rejection.
    pub fn count(&mut self, rejection: Rejection) {
        self.rejections[rejection as usize] += 1;
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.track.capacity() * size_of::<Configuration>()
            + self.trees.iter().map(|tree| tree.capacity() * size_of::<TreeNode>()).sum::<usize>()
    }
}
