//! The trees of single-mode planning: one for each transition and mode, kept from batch to batch
//! [Grey 4.4.3].

use crate::base::arena::reserve_written;
use crate::constraints::mode_state::ModeState;
use crate::motion::ids::TransitionId;

/// A node of a tree.
#[derive(Debug, Clone, Copy)]
pub struct TreeNode {
    /// The state.
    pub state: ModeState,
    /// Index of the parent; the root is its own parent.
    pub parent: u32,
}

/// A tree; the first node is the root.
pub type StateTree = Vec<TreeNode>;

/// Key of a tree: a transition or boundary node, and one of the two modes that it joins.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct TreeKey {
    /// The transition or boundary node.
    pub node: TransitionId,
    /// Whether the mode is double support.
    pub is_double: bool,
}

#[derive(Debug)]
struct PooledTree {
    key: Option<TreeKey>,
    nodes: StateTree,
    /// Batch number, plus one, in which it was lent last.
    lent_at: u64,
}

/// Trees that are kept, allocated once. If the pool is full, the least recently used tree is
/// dropped.
#[derive(Debug)]
pub struct TreePool {
    slots: Vec<PooledTree>,
    /// Number of batches that have ended.
    clock: u64,
}

/// Bytes of a tree that are written on allocation. Most trees stay small or are never used.
const TREE_WRITTEN_MAX: usize = 16 << 10;

/// An empty tree with capacity for `nodes_max` nodes. Allocates.
pub fn new_tree(nodes_max: usize) -> StateTree {
    reserve_written(nodes_max, TREE_WRITTEN_MAX)
}

impl TreePool {
    /// A pool of `trees_max` empty trees of `nodes_max` nodes each. Allocates.
    pub fn new(trees_max: usize, nodes_max: usize) -> Self {
        let slot = |_| PooledTree { key: None, nodes: new_tree(nodes_max), lent_at: 0 };
        Self { slots: (0..trees_max).map(slot).collect(), clock: 0 }
    }

    /// Lends the tree of a key by swapping it with an empty tree of the caller. Returns the slot
    /// for [`TreePool::return_tree`]; `None` if all trees are lent, or this one is.
    pub fn lend(&mut self, key: TreeKey, tree: &mut StateTree) -> Option<usize> {
        let known = self.slots.iter().position(|slot| slot.key == Some(key));
        let index = known.or_else(|| self.oldest())?;
        let clock = self.clock;
        let slot = &mut self.slots[index];
        if slot.lent_at > clock {
            return None;
        }
        if known.is_none() {
            slot.key = Some(key);
            slot.nodes.clear();
        }
        slot.lent_at = clock + 1;
        std::mem::swap(&mut slot.nodes, tree);
        Some(index)
    }

    /// Takes back a tree that was lent from a slot.
    pub fn return_tree(&mut self, index: usize, tree: &mut StateTree) {
        std::mem::swap(&mut self.slots[index].nodes, tree);
    }

    /// Drops the trees of a node, whose state has changed.
    pub fn forget(&mut self, node: TransitionId) {
        for slot in &mut self.slots {
            slot.key = slot.key.filter(|key| key.node != node);
        }
    }

    /// Ends a batch. All trees must be back.
    pub fn end_batch(&mut self) {
        self.clock += 1;
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.slots
            .iter()
            .map(|slot| size_of::<PooledTree>() + slot.nodes.capacity() * size_of::<TreeNode>())
            .sum()
    }

    /// The least recently used slot that is not lent; the first of several.
    fn oldest(&self) -> Option<usize> {
        let free = (0..self.slots.len()).filter(|&index| self.slots[index].lent_at <= self.clock);
        free.min_by_key(|&index| self.slots[index].lent_at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::robot::configuration::Configuration;
    use surefoot_shared_types::Pose;
    use surefoot_shared_types::base::limits::JOINTS_MAX;

    fn node() -> TreeNode {
        let configuration = Configuration { world_from_root: Pose::IDENTITY, q: [0.0; JOINTS_MAX] };
        TreeNode {
            state: ModeState { configuration, world_from_soles: [Pose::IDENTITY; 2] },
            parent: 0,
        }
    }

    fn key(node: TransitionId) -> TreeKey {
        TreeKey { node, is_double: false }
    }

    /// Adds a node to the tree of a key. Returns the number of nodes before; `None` if it is lent.
    fn grow(pool: &mut TreePool, node_key: TreeKey, tree: &mut StateTree) -> Option<usize> {
        let index = pool.lend(node_key, tree)?;
        let count = tree.len();
        tree.push(node());
        pool.return_tree(index, tree);
        pool.end_batch();
        Some(count)
    }

    #[test]
    fn trees_persist_until_the_least_recently_used_is_dropped() {
        let (mut pool, mut mine) = (TreePool::new(2, 4), Vec::with_capacity(4));
        assert_eq!(grow(&mut pool, key(7), &mut mine), Some(0));
        assert_eq!(grow(&mut pool, key(8), &mut mine), Some(0));
        assert_eq!(grow(&mut pool, key(7), &mut mine), Some(1));
        assert_eq!(
            grow(&mut pool, TreeKey { node: 7, is_double: true }, &mut mine),
            Some(0),
            "another mode, another tree"
        );
        assert_eq!(grow(&mut pool, key(7), &mut mine), Some(2));
        assert_eq!(
            grow(&mut pool, key(8), &mut mine),
            Some(0),
            "the least recently used tree was dropped"
        );
    }

    #[test]
    fn a_tree_is_lent_once_at_a_time() {
        let mut pool = TreePool::new(1, 4);
        let (mut mine, mut yours) = (Vec::with_capacity(4), Vec::with_capacity(4));
        let index = pool.lend(key(1), &mut mine).unwrap_or_default();
        assert_eq!(pool.lend(key(1), &mut yours), None);
        assert_eq!(pool.lend(key(2), &mut yours), None, "the only slot is lent");
        pool.return_tree(index, &mut mine);
        pool.end_batch();
        assert!(pool.lend(key(2), &mut yours).is_some());
    }
}
