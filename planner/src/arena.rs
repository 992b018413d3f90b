//! Memory that is reserved once, its beginning written, so that short searches meet no page for the first time.

/// No page of any system in use is smaller.
const PAGE: usize = 4_096;
/// Of each arena so many bytes are written: more than short searches use, where all of it would take longer than the search.
/// Whoever locks the process's memory first has all of it.
const WRITTEN_MAX: usize = 512 << 10;

/// An empty list with room for `capacity` items, its beginning backed by memory.
pub fn reserve<T>(capacity: usize) -> Vec<T> {
    let mut arena: Vec<T> = Vec::with_capacity(capacity);
    let spare = arena.spare_capacity_mut();
    let bytes = size_of_val(spare).min(WRITTEN_MAX);
    let begin = spare.as_mut_ptr().cast::<u8>();
    for offset in (0..bytes).step_by(PAGE).chain(bytes.checked_sub(1)) {
        // SAFETY: `offset` lies within the spare room, which is ours alone and holds nothing yet.
        unsafe { begin.add(offset).write_volatile(0) };
    }
    arena
}

/// A list of `count` times `item`, all of it backed by memory.
pub fn filled<T: Clone>(item: T, count: usize) -> Vec<T> {
    let mut arena = reserve(count);
    arena.resize(count, item);
    arena
}
