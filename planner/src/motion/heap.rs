//! A binary heap of node indices ordered by cost, with decrease-key, over arrays allocated once.

use crate::arena::{Uniform, reserve};

/// Position of a node that is not in the heap.
const ABSENT: u32 = u32::MAX;

/// What nodes are ordered by: cost first, then the number of edges, then the index, so that no two are equal.
type Key = (f64, u32, u32);

/// The heap.
#[derive(Debug)]
pub struct IndexHeap {
    order: Vec<u32>,
    positions: Uniform<u32>,
    keys: Uniform<(f64, u32)>,
}

impl IndexHeap {
    /// A heap over nodes `0..nodes_max`.
    pub fn new(nodes_max: usize) -> Self {
        Self { order: reserve(nodes_max), positions: Uniform::new(ABSENT, nodes_max), keys: Uniform::new((0.0, 0), nodes_max) }
    }

    /// Empties it.
    pub fn clear(&mut self) {
        for node in self.order.drain(..) {
            self.positions[node as usize] = ABSENT;
        }
    }

    /// Inserts a node or lowers its key.
    pub fn push(&mut self, node: u32, cost: f64, edges: u32) {
        self.keys[node as usize] = (cost, edges);
        if self.positions[node as usize] == ABSENT {
            self.positions[node as usize] = self.order.len() as u32;
            self.order.push(node);
        }
        self.rise(self.positions[node as usize] as usize);
    }

    /// Takes the node with the smallest key.
    pub fn pop(&mut self) -> Option<(u32, f64, u32)> {
        let node = *self.order.first()?;
        let last = self.order.pop()?;
        self.positions[node as usize] = ABSENT;
        if last != node {
            self.order[0] = last;
            self.positions[last as usize] = 0;
            self.sink(0);
        }
        let (cost, edges) = self.keys[node as usize];
        Some((node, cost, edges))
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.order.capacity() * size_of::<u32>() + self.positions.bytes() + self.keys.bytes()
    }

    fn key(&self, position: usize) -> Key {
        let node = self.order[position];
        let (cost, edges) = self.keys[node as usize];
        (cost, edges, node)
    }

    fn before(&self, a: usize, b: usize) -> bool {
        let (a, b) = (self.key(a), self.key(b));
        a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)).then(a.2.cmp(&b.2)).is_lt()
    }

    fn rise(&mut self, mut position: usize) {
        while position > 0 {
            let parent = (position - 1) / 2;
            if !self.before(position, parent) {
                return;
            }
            self.swap(position, parent);
            position = parent;
        }
    }

    fn sink(&mut self, mut position: usize) {
        loop {
            let children = [2 * position + 1, 2 * position + 2];
            let least = children.into_iter().filter(|&child| child < self.order.len()).reduce(|a, b| if self.before(b, a) { b } else { a });
            let Some(least) = least.filter(|&child| self.before(child, position)) else { return };
            self.swap(position, least);
            position = least;
        }
    }

    fn swap(&mut self, a: usize, b: usize) {
        self.order.swap(a, b);
        self.positions[self.order[a] as usize] = a as u32;
        self.positions[self.order[b] as usize] = b as u32;
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::{Random, Stream};

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
