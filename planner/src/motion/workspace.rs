//! The memory of one single-mode search, allocated once and used by one search at a time.

use crate::arena::reserve;
use crate::body::Configuration;
use crate::constraint::Rejection;
use crate::motion::track::Follower;
use crate::motion::trees::{Tree, TreeNode, new_tree};

/// Most waypoints that lift a foot off its placement or set it down.
const LIFT_MAX: usize = 128;
/// Most waypoints of a shortcut.
const SHORTCUT_MAX: usize = 256;

/// A search's memory.
#[derive(Debug)]
pub struct Workspace {
    /// The motion found: waypoints after the first state, the last one included.
    pub track: Vec<Configuration>,
    /// How the swing foot leaves its placement at either end, waypoints after the end itself.
    pub lifts: [Vec<Configuration>; 2],
    /// A shortcut of the track: waypoints after the one where it begins.
    pub shortcut: Vec<Configuration>,
    /// What follows the stretch that is being tried.
    pub follower: Follower,
    /// The trees of both ends.
    pub trees: [Tree; 2],
    /// How often each condition turned something down.
    pub rejections: [u64; Rejection::COUNT],
}

impl Workspace {
    /// Memory for tracks and trees of these lengths.
    pub fn new(track_max: usize, tree_nodes_max: usize) -> Self {
        Self {
            track: reserve(track_max),
            lifts: [0, 1].map(|_| reserve(LIFT_MAX)),
            shortcut: reserve(SHORTCUT_MAX),
            follower: Follower::default(),
            trees: [0, 1].map(|_| new_tree(tree_nodes_max)),
            rejections: [0; Rejection::COUNT],
        }
    }

    /// Empties it, but for what it counts.
    pub fn clear(&mut self) {
        self.track.clear();
        self.lifts.iter_mut().for_each(Vec::clear);
        self.follower.stop();
        self.trees.iter_mut().for_each(Vec::clear);
    }

    /// Counts a rejection.
    pub fn count(&mut self, rejection: Rejection) {
        self.rejections[rejection as usize] += 1;
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        let tracks = [&self.track, &self.lifts[0], &self.lifts[1], &self.shortcut];
        tracks.iter().map(|track| track.capacity() * size_of::<Configuration>()).sum::<usize>()
            + self.trees.iter().map(|tree| tree.capacity() * size_of::<TreeNode>()).sum::<usize>()
    }
}

/// Appends to a list of fixed capacity.
///
/// # Errors
/// The list is full: [`Rejection::Discontinuous`], as the motion needs more steps than allowed.
pub fn push<T>(list: &mut Vec<T>, item: T) -> Result<(), Rejection> {
    if list.len() == list.capacity() {
        return Err(Rejection::Discontinuous);
    }
    list.push(item);
    Ok(())
}
