//! Memory that is reserved once and written through, so that the search never meets a page for the first time.

/// No page of any system in use is smaller.
const PAGE: usize = 4_096;
/// A large page.
const LARGE_PAGE: usize = 2 << 20;

/// An empty list with room for `capacity` items, every page of it backed by memory.
pub fn reserve<T>(capacity: usize) -> Vec<T> {
    let mut arena: Vec<T> = Vec::with_capacity(capacity);
    let spare = arena.spare_capacity_mut();
    let bytes = size_of_val(spare);
    let begin = spare.as_mut_ptr().cast::<u8>();
    wish_for_large_pages(begin, bytes);
    for offset in (0..bytes).step_by(PAGE).chain(bytes.checked_sub(1)) {
        // SAFETY: `offset` lies within the spare room, which is ours alone and holds nothing yet.
        unsafe { begin.add(offset).write_volatile(0) };
    }
    arena
}

/// Tells the system that large pages would do for some room: met a hundred times faster, where it has any.
fn wish_for_large_pages(begin: *mut u8, bytes: usize) {
    let skipped = begin.align_offset(PAGE);
    if bytes >= skipped + LARGE_PAGE {
        // SAFETY: the range lies within one allocation of ours; the advice changes nothing of what it holds.
        unsafe { libc::madvise(begin.add(skipped).cast(), (bytes - skipped) / PAGE * PAGE, libc::MADV_HUGEPAGE) };
    }
}

/// A list of `count` times `item`, every page of it backed by memory.
pub fn filled<T: Clone>(item: T, count: usize) -> Vec<T> {
    let mut arena = reserve(count);
    arena.resize(count, item);
    arena
}
