//! A binary heap of node indices ordered by cost, with decrease-key, over arrays allocated once.

use crate::base::arena::{LazilyFilled, reserve};

/// Position of a node that is not in the heap.
const ABSENT: u32 = u32::MAX;

/// A node and its key: cost first, then the number of edges, then the index, so that no two entries
/// are equal. Packed into one integer, which is compared at once.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
struct Entry(u128);

/// A binary min-heap of node indices.
#[derive(Debug)]
pub struct IndexHeap {
    order: Vec<Entry>,
    positions: LazilyFilled<u32>,
}

impl IndexHeap {
    /// An empty heap over the nodes `0..nodes_max`. Allocates.
    pub fn new(nodes_max: usize) -> Self {
        Self { order: reserve(nodes_max), positions: LazilyFilled::new(ABSENT, nodes_max) }
    }

    /// Removes all entries.
    pub fn clear(&mut self) {
        for entry in self.order.drain(..) {
            self.positions[entry.node() as usize] = ABSENT;
        }
    }

    /// Inserts a node or decreases its key. The cost must not be negative.
    pub fn push(&mut self, node: u32, cost: f64, edges: u32) {
        let entry = Entry::new(node, cost, edges);
        let position = self.positions[node as usize];
        if position == ABSENT {
            self.order.push(entry);
            self.sift_up(entry, self.order.len() - 1);
        } else {
            self.sift_up(entry, position as usize);
        }
    }

    /// Removes the node with the smallest key. Returns node, cost and number of edges.
    pub fn pop(&mut self) -> Option<(u32, f64, u32)> {
        let first = *self.order.first()?;
        let last = self.order.pop()?;
        self.positions[first.node() as usize] = ABSENT;
        if last != first {
            self.sift_down(last, 0);
        }
        Some((first.node(), first.cost(), first.edges()))
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.order.capacity() * size_of::<Entry>() + self.positions.bytes()
    }

    /// Moves an entry from a position toward the root to its place.
    fn sift_up(&mut self, entry: Entry, mut position: usize) {
        while position > 0 {
            let parent = (position - 1) / 2;
            if entry > self.order[parent] {
                break;
            }
            self.put(self.order[parent], position);
            position = parent;
        }
        self.put(entry, position);
    }

    /// Moves an entry from a position toward the leaves to its place.
    fn sift_down(&mut self, entry: Entry, mut position: usize) {
        loop {
            let left = 2 * position + 1;
            let Some(&first) = self.order.get(left) else { break };
            let second = *self.order.get(left + 1).unwrap_or(&first);
            let (least, child) = (first.min(second), left + usize::from(second < first));
            if least > entry {
                break;
            }
            self.put(least, position);
            position = child;
        }
        self.put(entry, position);
    }

    fn put(&mut self, entry: Entry, position: usize) {
        self.order[position] = entry;
        self.positions[entry.node() as usize] = position as u32;
    }
}

impl Entry {
    /// The bits of non-negative floating-point numbers are ordered like the numbers.
    fn new(node: u32, cost: f64, edges: u32) -> Self {
        debug_assert!(cost.is_sign_positive(), "{cost}");
        Self(u128::from(cost.to_bits()) << 64 | u128::from(edges) << 32 | u128::from(node))
    }

    fn node(self) -> u32 {
        self.0 as u32
    }

    fn edges(self) -> u32 {
        (self.0 >> 32) as u32
    }

    fn cost(self) -> f64 {
        f64::from_bits((self.0 >> 64) as u64)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::{Random, Stream};

    #[test]
    fn pops_in_order_after_random_pushes_and_decreases() {
        let mut random = Random::new(1, Stream::Preparation, 0, 0);
        let mut heap = IndexHeap::new(500);
        heap.clear();
        let mut least = vec![f64::INFINITY; 500];
        for _ in 0..3_000 {
            let node = random.below(500);
            let cost = random.uniform(0.0, 1.0);
            if cost < least[node] {
                least[node] = cost;
                heap.push(node as u32, cost, 0);
            }
        }
        let popped: Vec<_> = std::iter::from_fn(|| heap.pop()).collect();
        assert!(popped.windows(2).all(|pair| pair[0].1 <= pair[1].1));
        assert!(popped.iter().all(|&(node, cost, _)| cost == least[node as usize]));
        assert_eq!(popped.len(), least.iter().filter(|cost| cost.is_finite()).count());
    }
}
