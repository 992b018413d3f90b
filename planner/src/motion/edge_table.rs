//! The results of single-mode planning for pairs of transitions within a mode: the number of failed
//! searches and the motion that was found.

use crate::base::arena::{ArenaSlice, filled};
use crate::base::capacity::ArenaFull;
use crate::motion::ids::TransitionId;

/// Result of single-mode planning between two transitions within their common mode.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct EdgeRecord {
    /// Number of failed searches.
    pub failures: u32,
    /// The waypoints of the motion in the waypoint arena, if one was found.
    pub motion: Option<ArenaSlice>,
}

#[derive(Debug, Clone, Copy)]
struct Slot {
    from: TransitionId,
    to: TransitionId,
    record: EdgeRecord,
}

/// A hash table with open addressing from a pair of transitions to its record. Allocated once,
/// never iterated.
#[derive(Debug)]
pub struct EdgeTable {
    slots: Vec<Option<Slot>>,
    used: usize,
}

impl EdgeTable {
    /// A table with capacity for at least `edges_max` pairs. Allocates.
    pub fn new(edges_max: usize) -> Self {
        Self { slots: filled(None, (2 * edges_max).next_power_of_two()), used: 0 }
    }

    /// The record of a pair; the default if there is none.
    pub fn get(&self, from: TransitionId, to: TransitionId) -> EdgeRecord {
        self.slots[self.find(from, to)].map_or(EdgeRecord::default(), |slot| slot.record)
    }

    /// Sets the record of a pair.
    ///
    /// # Errors
    /// The table is full.
    pub fn set(
        &mut self,
        from: TransitionId,
        to: TransitionId,
        record: EdgeRecord,
    ) -> Result<(), ArenaFull> {
        let index = self.find(from, to);
        if self.slots[index].is_none() {
            if 2 * (self.used + 1) > self.slots.len() {
                return Err(ArenaFull::Edges);
            }
            self.used += 1;
        }
        self.slots[index] = Some(Slot { from, to, record });
        Ok(())
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.slots.len() * size_of::<Option<Slot>>()
    }

    /// Index of the slot of a pair, or of the free slot where it is to be stored. There always is
    /// one, because the table is at most half full.
    fn find(&self, from: TransitionId, to: TransitionId) -> usize {
        let mask = self.slots.len() - 1;
        let hash = (u64::from(from) << 32 | u64::from(to)).wrapping_mul(0x9E37_79B9_7F4A_7C15);
        let mut index = (hash >> 32) as usize & mask;
        while self.slots[index].is_some_and(|slot| (slot.from, slot.to) != (from, to)) {
            index = (index + 1) & mask;
        }
        index
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn records_are_kept_until_the_table_is_full() {
        let mut table = EdgeTable::new(8);
        let mut stored = 0;
        for i in 0..100 {
            let record = EdgeRecord { failures: i, motion: None };
            match table.set(i, 7 * i, record) {
                Ok(()) => stored = i + 1,
                Err(full) => assert_eq!(full, ArenaFull::Edges),
            }
        }
        assert!(stored >= 8);
        assert!((0..stored).all(|i| table.get(i, 7 * i).failures == i));
        assert_eq!(table.get(1, 1), EdgeRecord::default());
    }
}
