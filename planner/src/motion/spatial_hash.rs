//! Spatial hash of footholds: those near a position, in the order in which they were added.

use glam::DVec3;

use crate::base::arena::{filled, reserve};

/// Cells around a position in the plane, its own included.
const CELLS: usize = 9;
/// Fewest buckets.
const BUCKETS_MIN: usize = 64;
/// Average number of footholds per bucket at full capacity.
const ENTRIES_PER_BUCKET: usize = 4;
/// The end of a list.
const NONE: u32 = u32::MAX;

/// Lists of footholds by foot and cell of the horizontal plane. Several cells may share a bucket.
/// Allocated once.
#[derive(Debug)]
pub struct SpatialHash {
    /// Width of a cell, m.
    width: f64,
    /// The first and the last foothold of each bucket.
    ends: Vec<[u32; 2]>,
    /// The next foothold in the bucket of each one.
    next: Vec<u32>,
}

impl SpatialHash {
    /// An empty hash for `positions_max` footholds and queries of radius `reach`, m. Allocates.
    pub fn new(reach: f64, positions_max: usize) -> Self {
        let buckets = (positions_max / ENTRIES_PER_BUCKET).next_power_of_two().max(BUCKETS_MIN);
        // Slightly wider than the reach, so that rounding never separates two positions by more
        // than one cell.
        Self {
            width: 1.001 * reach,
            ends: filled([NONE; 2], buckets),
            next: reserve(positions_max),
        }
    }

    /// Adds the next foothold, of foot `limb`.
    pub fn add(&mut self, limb: usize, position: DVec3) {
        let index = self.next.len() as u32;
        let bucket = self.bucket(limb, self.cell(position));
        let [first, last] = &mut self.ends[bucket];
        if *first == NONE {
            *first = index;
        } else {
            self.next[*last as usize] = index;
        }
        *last = index;
        self.next.push(NONE);
    }

    /// Indices of all footholds of a foot within reach of a position, and possibly others, in
    /// ascending order.
    pub fn near(&self, limb: usize, position: DVec3) -> impl Iterator<Item = u32> + '_ {
        let [x, y] = self.cell(position);
        let mut buckets: heapless::Vec<usize, CELLS> = (0..CELLS as i64)
            .map(|cell| self.bucket(limb, [x - 1 + cell / 3, y - 1 + cell % 3]))
            .collect();
        buckets.sort_unstable();
        let distinct = buckets
            .iter()
            .enumerate()
            .filter(|&(index, bucket)| index == 0 || buckets[index - 1] != *bucket);
        let mut lists: heapless::Vec<u32, CELLS> =
            distinct.map(|(_, &bucket)| self.ends[bucket][0]).collect();
        std::iter::from_fn(move || {
            let list = lists.iter_mut().min().filter(|index| **index != NONE)?;
            let next = self.next[*list as usize];
            Some(std::mem::replace(list, next))
        })
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.ends.capacity() * size_of::<[u32; 2]>() + self.next.capacity() * size_of::<u32>()
    }

    fn cell(&self, position: DVec3) -> [i64; 2] {
        [position.x, position.y].map(|along| (along / self.width).floor() as i64)
    }

    fn bucket(&self, limb: usize, [x, y]: [i64; 2]) -> usize {
        // Two odd multipliers of 64 bits that spread neighbours (from the golden ratio, and from
        // Knuth's generator).
        let mixed = (x as u64).wrapping_mul(0x9E37_79B9_7F4A_7C15)
            ^ (y as u64).wrapping_mul(0x5851_F42D_4C95_7F2D)
            ^ limb as u64;
        ((mixed ^ mixed >> 32) as usize) & (self.ends.len() - 1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::random::{Random, Stream};

    #[test]
    fn all_positions_within_reach_are_found_once_in_order() {
        for reach in [0.02, 0.7, 3.0] {
            let mut random = Random::new(1, Stream::FootPlacement, 0, 0);
            let mut anywhere =
                || DVec3::from_array(std::array::from_fn(|_| random.uniform(-4.0, 4.0)));
            let positions: Vec<DVec3> = (0..2_000).map(|_| anywhere()).collect();
            let mut index = SpatialHash::new(reach, positions.len());
            positions
                .iter()
                .enumerate()
                .for_each(|(number, &position)| index.add(number % 2, position));
            for (at, limb) in (0..200).map(|number| (anywhere(), number % 2)) {
                let is_near = |number: &u32| positions[*number as usize].distance(at) <= reach;
                let expected: Vec<u32> = (0..positions.len() as u32)
                    .filter(|number| *number as usize % 2 == limb)
                    .filter(is_near)
                    .collect();
                let near: Vec<u32> = index.near(limb, at).collect();
                assert!(near.windows(2).all(|pair| pair[0] < pair[1]));
                assert_eq!(
                    near.into_iter()
                        .filter(|number| *number as usize % 2 == limb)
                        .filter(is_near)
                        .collect::<Vec<_>>(),
                    expected
                );
            }
        }
    }
}
