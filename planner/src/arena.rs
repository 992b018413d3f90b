//! Memory that is reserved once, its beginning written, so that short searches meet no page for the first time.

use std::ops::{Index, IndexMut};

use bytemuck::Zeroable;
use bytemuck::allocation::zeroed_vec;

/// No page of any system in use is smaller.
const PAGE: usize = 4_096;
/// Of each arena so many bytes are written: more than short searches use, where all of it would take longer than the search.
/// Whoever locks the process's memory first has all of it.
const WRITTEN_MAX: usize = 512 << 10;

/// An empty list with room for `capacity` items, its beginning backed by memory.
pub fn reserve<T>(capacity: usize) -> Vec<T> {
    reserve_written(capacity, WRITTEN_MAX)
}

/// The same with at most so many bytes written: for one of many lists, most of which stay short.
pub fn reserve_written<T>(capacity: usize, written_max: usize) -> Vec<T> {
    let mut arena: Vec<T> = Vec::with_capacity(capacity);
    let spare = arena.spare_capacity_mut();
    let bytes = size_of_val(spare).min(written_max);
    let begin = spare.as_mut_ptr().cast::<u8>();
    for offset in (0..bytes).step_by(PAGE).chain(bytes.checked_sub(1)) {
        // SAFETY: `offset` lies within the spare room, which is ours alone and holds nothing yet.
        unsafe { begin.add(offset).write_volatile(0) };
    }
    arena
}

/// A list of `count` items of nothing but zeros, its beginning backed by memory.
pub fn zeroed<T: Zeroable>(count: usize) -> Vec<T> {
    let mut arena = zeroed_vec::<T>(count);
    let written = count.min(WRITTEN_MAX.div_ceil(size_of::<T>().max(1)));
    arena[..written].fill_with(|| std::hint::black_box(T::zeroed()));
    arena
}

/// A list of `count` times `item`, all of it backed by memory.
pub fn filled<T: Clone>(item: T, count: usize) -> Vec<T> {
    let mut arena = reserve(count);
    arena.resize(count, item);
    arena
}

/// A list of `count` times an item, of which only the beginning is written: up to the last item that was ever changed. So a short
/// search pays for no more of it than it uses. Never reserves again.
#[derive(Debug)]
pub struct Uniform<T> {
    written: Vec<T>,
    item: T,
    count: usize,
}

impl<T: Copy> Uniform<T> {
    /// `count` times `item`.
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

impl<T: Copy> Index<usize> for Uniform<T> {
    type Output = T;

    #[inline]
    fn index(&self, index: usize) -> &T {
        debug_assert!(index < self.count);
        self.written.get(index).unwrap_or(&self.item)
    }
}

impl<T: Copy> IndexMut<usize> for Uniform<T> {
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
    fn a_uniform_list_is_as_long_as_it_was_made_and_keeps_what_is_changed() {
        let mut list = Uniform::new(7_u32, 1_000);
        let capacity = list.written.capacity();
        list[500] = 1;
        list[3] += 1;
        list[999] = 2;
        assert_eq!([0, 3, 4, 500, 501, 999].map(|index| list[index]), [7, 8, 7, 1, 7, 2]);
        assert_eq!((list.written.capacity(), list.bytes()), (capacity, 4_000), "no memory but that of the beginning");
    }

    #[test]
    #[should_panic(expected = "1000 in a list of 1000")]
    fn beyond_its_end_nothing_can_be_changed() {
        Uniform::new(0_u8, 1_000)[1_000] = 1;
    }
}
