//! Memory that is reserved once. Its first pages are written when it is reserved, so that a short
//! search causes no page faults.

use std::mem::MaybeUninit;
use std::ops::{Index, IndexMut};

use bytemuck::Zeroable;
use bytemuck::allocation::zeroed_vec;

use crate::base::threads::Threads;
use crate::base::tuning::WRITTEN_BYTES_MAX;

/// Smallest page size of the supported systems, bytes.
const PAGE: usize = 4_096;

/// An empty list of the given capacity whose first pages are backed by memory.
pub fn reserve<T>(capacity: usize) -> Vec<T> {
    reserve_written(capacity, WRITTEN_BYTES_MAX)
}

/// An empty list of the given capacity, of which at most `written_max` bytes are backed by memory
/// at once: for one of many lists that stay short.
pub fn reserve_written<T>(capacity: usize, written_max: usize) -> Vec<T> {
    let mut arena: Vec<T> = Vec::with_capacity(capacity);
    let spare = arena.spare_capacity_mut();
    let bytes = size_of_val(spare).min(written_max);
    let begin = spare.as_mut_ptr().cast::<u8>();
    for offset in (0..bytes).step_by(PAGE).chain(bytes.checked_sub(1)) {
        // SAFETY: `offset` lies within the spare capacity, which this list owns and which holds no
        // items.
        unsafe { begin.add(offset).write_volatile(0) };
    }
    arena
}

/// A list in an arena: the index of its first item, and the number of items.
pub type ArenaSlice = (u32, u32);

/// The items of a list in an arena.
///
/// # Panics
/// The list is not within the arena.
pub fn slice_at<T>(arena: &[T], (first, count): ArenaSlice) -> &[T] {
    &arena[first as usize..(first + count) as usize]
}

/// Appends lists in order and returns their places; `None`, with nothing appended, if the capacity
/// is too small for all. Threads copy in parallel, because most of the memory is touched for the
/// first time.
pub fn append_all<T: Copy + Send + Sync, const N: usize>(
    arena: &mut Vec<T>,
    lists: &heapless::Vec<&[T], N>,
    threads: &Threads,
) -> Option<heapless::Vec<ArenaSlice, N>> {
    let mut end = arena.len();
    let mut spare = arena.spare_capacity_mut();
    let mut slices = heapless::Vec::new();
    let mut copies: heapless::Vec<(&mut [MaybeUninit<T>], &[T]), N> = heapless::Vec::new();
    for list in lists {
        let (space, rest) = spare.split_at_mut_checked(list.len())?;
        let _as_many_as_lists =
            (slices.push((end as u32, list.len() as u32)), copies.push((space, list)));
        end += list.len();
        spare = rest;
    }
    threads.for_each(&mut copies, |(space, list)| {
        for (item, known) in space.iter_mut().zip(list.iter()) {
            item.write(*known);
        }
    });
    drop(copies);
    // SAFETY: the copies cover the spare capacity up to `end`, and each was written completely.
    unsafe { arena.set_len(end) };
    Some(slices)
}

/// A list of `count` items of zero bytes whose first pages are backed by memory.
pub fn zeroed<T: Zeroable>(count: usize) -> Vec<T> {
    let mut arena = zeroed_vec::<T>(count);
    let written = count.min(WRITTEN_BYTES_MAX.div_ceil(size_of::<T>().max(1)));
    arena[..written].fill_with(|| std::hint::black_box(T::zeroed()));
    arena
}

/// A list of `count` copies of `item`, all of it backed by memory.
pub fn filled<T: Clone>(item: T, count: usize) -> Vec<T> {
    let mut arena = reserve(count);
    arena.resize(count, item);
    arena
}

/// A list of `count` copies of an item that is written only up to the last item changed, so that a
/// short search does not write all of it. Memory is reserved once.
#[derive(Debug)]
pub struct LazilyFilled<T> {
    written: Vec<T>,
    item: T,
    count: usize,
}

impl<T: Copy> LazilyFilled<T> {
    /// A list of `count` copies of `item`.
    pub fn new(item: T, count: usize) -> Self {
        Self { written: reserve(count), item, count }
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.count * size_of::<T>()
    }

    #[cold]
    fn write_up_to(&mut self, index: usize) {
        assert!(index < self.count, "{index} in a list of {}", self.count);
        self.written.resize(index + 1, self.item);
    }
}

impl<T: Copy> Index<usize> for LazilyFilled<T> {
    type Output = T;

    #[inline]
    fn index(&self, index: usize) -> &T {
        debug_assert!(index < self.count);
        self.written.get(index).unwrap_or(&self.item)
    }
}

impl<T: Copy> IndexMut<usize> for LazilyFilled<T> {
    #[inline]
    fn index_mut(&mut self, index: usize) -> &mut T {
        if index >= self.written.len() {
            self.write_up_to(index);
        }
        &mut self.written[index]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lists_are_appended_in_order_or_not_at_all() {
        let threads = Threads::new(2.try_into().unwrap()).unwrap();
        let mut arena: Vec<u8> = Vec::with_capacity(6);
        arena.push(9);
        let lists: heapless::Vec<&[u8], 3> = [&[1, 2][..], &[], &[3]].into_iter().collect();
        let append = |arena: &mut Vec<u8>| threads.run(|| append_all(arena, &lists, &threads));
        assert_eq!(append(&mut arena).unwrap(), [(1, 2), (3, 0), (3, 1)]);
        assert_eq!((append(&mut arena), arena), (None, vec![9, 1, 2, 3]));
    }

    #[test]
    fn a_lazily_filled_list_keeps_its_length_and_its_changes() {
        let mut list = LazilyFilled::new(7_u32, 1_000);
        let capacity = list.written.capacity();
        list[500] = 1;
        list[3] += 1;
        list[999] = 2;
        assert_eq!([0, 3, 4, 500, 501, 999].map(|index| list[index]), [7, 8, 7, 1, 7, 2]);
        assert_eq!(
            (list.written.capacity(), list.bytes()),
            (capacity, 4_000),
            "memory is reserved once"
        );
    }

    #[test]
    #[should_panic(expected = "1000 in a list of 1000")]
    fn an_index_beyond_the_end_panics() {
        LazilyFilled::new(0_u8, 1_000)[1_000] = 1;
    }
}
