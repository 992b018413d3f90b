//! The swings from each placement, contiguously in memory: the search for sequences looks at
//! hundreds of thousands of them.

use crate::base::arena::reserve;
use crate::motion::mode_graph::{FootholdId, TransitionId};

/// Swings of a block: two lines of a cache.
const BLOCK_LEN: usize = 15;
/// No block.
const NONE: u32 = u32::MAX;

/// A foot swung to a placement while the other one stands.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Swing {
    /// The transition at its end.
    pub to: TransitionId,
    /// The placement that is touched there.
    pub other: FootholdId,
}

#[derive(Debug, Clone, Copy)]
struct Block {
    swings: [Swing; BLOCK_LEN],
    len: u32,
    /// The block that was filled before, of the same placement.
    before: u32,
}

/// The lists of all placements, allocated once.
#[derive(Debug)]
pub struct AdjacencyLists {
    newest: Vec<u32>,
    blocks: Vec<Block>,
}

impl AdjacencyLists {
    /// Room for the swings of so many placements.
    pub fn new(stances_max: usize, swings_max: usize) -> Self {
        Self { newest: reserve(stances_max), blocks: reserve(stances_max + swings_max / BLOCK_LEN) }
    }

    /// Adds a placement.
    pub fn add_stance(&mut self) {
        self.newest.push(NONE);
    }

    /// Adds a swing from a placement.
    pub fn add(&mut self, stance: FootholdId, swing: Swing) {
        let newest = &mut self.newest[stance as usize];
        let has_room =
            self.blocks.get(*newest as usize).is_some_and(|block| (block.len as usize) < BLOCK_LEN);
        if !has_room {
            self.blocks.push(Block {
                swings: [Swing::default(); BLOCK_LEN],
                len: 0,
                before: *newest,
            });
            *newest = (self.blocks.len() - 1) as u32;
        }
        let block = &mut self.blocks[*newest as usize];
        block.swings[block.len as usize] = swing;
        block.len += 1;
    }

    /// The swings from a placement, newest first.
    pub fn from_stance(&self, stance: FootholdId) -> impl Iterator<Item = Swing> + '_ {
        let block = |index: u32| self.blocks.get(index as usize);
        let blocks = std::iter::successors(block(self.newest[stance as usize]), move |newer| {
            block(newer.before)
        });
        blocks.flat_map(|block| block.swings[..block.len as usize].iter().rev().copied())
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.newest.capacity() * size_of::<u32>() + self.blocks.capacity() * size_of::<Block>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_placement_has_its_own_newest_first_and_they_fit_however_they_come() {
        let (stances, swings) = (7, 700);
        let mut lists = AdjacencyLists::new(stances, swings);
        let capacity = lists.blocks.capacity();
        (0..stances).for_each(|_| lists.add_stance());
        let stance_of = |to: u32| if to < 600 { to % 3 } else { to % 7 };
        for to in 0..swings as u32 {
            lists.add(stance_of(to), Swing { to, other: to + 1 });
        }
        for stance in 0..stances as u32 {
            let expected = (0..swings as u32)
                .rev()
                .filter(|&to| stance_of(to) == stance)
                .map(|to| Swing { to, other: to + 1 });
            assert!(lists.from_stance(stance).eq(expected));
        }
        assert_eq!((size_of::<Block>(), lists.blocks.capacity()), (128, capacity));
    }
}
