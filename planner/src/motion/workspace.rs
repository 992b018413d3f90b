//! Memory of one search of a batch, allocated once and used by one search after another.

use crate::base::arena::reserve;
use crate::constraints::rejection::Rejection;
use crate::motion::local_planner::LocalPlanner;
use crate::motion::tree_pool::{StateTree, TreeNode, new_tree};
use crate::motion::tuning::{LIFT_OFF_WAYPOINTS_MAX, SHORTCUT_WAYPOINTS_MAX};
use crate::robot::configuration::Configuration;

/// Memory of a search.
#[derive(Debug)]
pub struct Workspace {
    /// The motion found: the waypoints after the first state.
    pub path: Vec<Configuration>,
    /// The lift-offs at both ends: the waypoints after the end itself.
    pub lift_offs: [Vec<Configuration>; 2],
    /// A shortcut of the path: the waypoints after the one where it begins.
    pub shortcut: Vec<Configuration>,
    /// The local planner of the search.
    pub local_planner: LocalPlanner,
    /// The trees of both ends.
    pub trees: [StateTree; 2],
    /// Number of rejections of each kind.
    pub rejections: [u64; Rejection::COUNT],
}

impl Workspace {
    /// Empty memory for paths and trees of these capacities. Allocates.
    pub fn new(path_waypoints_max: usize, tree_nodes_max: usize) -> Self {
        Self {
            path: reserve(path_waypoints_max),
            lift_offs: [0, 1].map(|_| reserve(LIFT_OFF_WAYPOINTS_MAX)),
            shortcut: reserve(SHORTCUT_WAYPOINTS_MAX),
            local_planner: LocalPlanner::default(),
            trees: [0, 1].map(|_| new_tree(tree_nodes_max)),
            rejections: [0; Rejection::COUNT],
        }
    }

    /// Clears everything except the rejection counts.
    pub fn clear(&mut self) {
        self.path.clear();
        self.lift_offs.iter_mut().for_each(Vec::clear);
        self.local_planner.stop();
        self.trees.iter_mut().for_each(Vec::clear);
    }

    /// Counts a rejection.
    pub fn count(&mut self, rejection: Rejection) {
        self.rejections[rejection as usize] += 1;
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        let paths = [&self.path, &self.lift_offs[0], &self.lift_offs[1], &self.shortcut];
        paths.iter().map(|path| path.capacity() * size_of::<Configuration>()).sum::<usize>()
            + self.trees.iter().map(|tree| tree.capacity() * size_of::<TreeNode>()).sum::<usize>()
    }
}

/// Appends to a list of fixed capacity.
///
/// # Errors
/// [`Rejection::Discontinuous`] if the list is full: the motion needs more waypoints than allowed.
pub fn push<T>(list: &mut Vec<T>, item: T) -> Result<(), Rejection> {
    if list.len() == list.capacity() {
        return Err(Rejection::Discontinuous);
    }
    list.push(item);
    Ok(())
}
