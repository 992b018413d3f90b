//! Adjacency lists of the mode graph: the swings from each foothold, in blocks that are contiguous
//! in memory, because the sequence search reads hundreds of thousands of them.

use crate::base::arena::reserve;
use crate::motion::ids::{FootholdId, TransitionId};

/// Swings of a block, which fills two cache lines.
const BLOCK_LEN: usize = 15;
/// Index of no block.
const NONE: u32 = u32::MAX;

/// The swing of a foot to a foothold while the other foot stands.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Swing {
    /// The transition at the end of the swing.
    pub to: TransitionId,
    /// The foothold that the swing foot reaches.
    pub other: FootholdId,
}

#[derive(Debug, Clone, Copy)]
struct Block {
    swings: [Swing; BLOCK_LEN],
    len: u32,
    /// The block of the same foothold that was filled before.
    before: u32,
}

/// The lists of all footholds, allocated once.
#[derive(Debug)]
pub struct AdjacencyLists {
    /// The newest block of each foothold.
    newest: Vec<u32>,
    blocks: Vec<Block>,
}

impl AdjacencyLists {
    /// Lists with capacity for as many footholds and swings. Allocates.
    pub fn new(footholds_max: usize, swings_max: usize) -> Self {
        Self {
            newest: reserve(footholds_max),
            blocks: reserve(footholds_max + swings_max / BLOCK_LEN),
        }
    }

    /// Adds an empty list for the next foothold.
    pub fn add_stance(&mut self) {
        self.newest.push(NONE);
    }

    /// Adds a swing from a foothold.
    pub fn add(&mut self, stance: FootholdId, swing: Swing) {
        let newest = &mut self.newest[stance as usize];
        let is_open =
            self.blocks.get(*newest as usize).is_some_and(|block| (block.len as usize) < BLOCK_LEN);
        if !is_open {
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

    /// The swings from a foothold, newest first.
    pub fn of_stance(&self, stance: FootholdId) -> impl Iterator<Item = Swing> + '_ {
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
    fn lists_hold_their_own_swings_newest_first_within_the_capacity() {
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
            assert!(lists.of_stance(stance).eq(expected));
        }
        assert_eq!((size_of::<Block>(), lists.blocks.capacity()), (128, capacity));
    }
}
