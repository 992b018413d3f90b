//! Lists and heaps of bounded length: an item that does not fit is counted and dropped.

use std::collections::BinaryHeap;

/// Capacity of a list, and the number of items dropped beyond it.
#[derive(Debug)]
struct Capacity {
    count_max: usize,
    /// Items dropped so far.
    dropped: u64,
}

impl Capacity {
    fn new(count_max: usize) -> Self {
        Self { count_max, dropped: 0 }
    }

    /// Whether one more item fits beside `count`; if not, it counts as dropped.
    fn accepts(&mut self, count: usize) -> bool {
        let fits = count < self.count_max;
        self.dropped += u64::from(!fits);
        fits
    }
}

/// A list that never grows beyond its first capacity. An item that does not fit is counted and
/// dropped.
#[derive(Debug)]
pub(crate) struct Bounded<T> {
    items: Vec<T>,
    capacity: Capacity,
}

impl<T> Bounded<T> {
    /// An empty container for at most `count_max` items.
    pub fn new(count_max: usize) -> Self {
        Self { items: Vec::with_capacity(count_max), capacity: Capacity::new(count_max) }
    }

    /// Adds an item, or counts it as dropped.
    pub fn push(&mut self, item: T) {
        if self.capacity.accepts(self.items.len()) {
            self.items.push(item);
        }
    }

    /// Counts an item as dropped without adding it.
    pub fn count_dropped(&mut self) {
        self.capacity.dropped += 1;
    }

    /// Items dropped so far.
    pub fn dropped(&self) -> u64 {
        self.capacity.dropped
    }

    /// Whether the next push drops its item.
    pub fn is_full(&self) -> bool {
        self.items.len() == self.capacity.count_max
    }

    /// Removes the items from index `count` on.
    pub fn truncate(&mut self, count: usize) {
        self.items.truncate(count);
    }

    /// Bytes on the heap.
    pub fn heap_bytes(&self) -> usize {
        self.items.capacity() * size_of::<T>()
    }

    /// Removes all items.
    pub fn clear(&mut self) {
        self.items.clear();
    }
}

impl<T> std::ops::Deref for Bounded<T> {
    type Target = [T];
    fn deref(&self) -> &[T] {
        &self.items
    }
}

impl<T> std::ops::DerefMut for Bounded<T> {
    fn deref_mut(&mut self) -> &mut [T] {
        &mut self.items
    }
}

/// A heap, greatest item first, that never grows beyond its first capacity, as [`Bounded`].
#[derive(Debug)]
pub(crate) struct BoundedHeap<T> {
    items: BinaryHeap<T>,
    capacity: Capacity,
}

impl<T: Ord> BoundedHeap<T> {
    /// An empty container for at most `count_max` items.
    pub fn new(count_max: usize) -> Self {
        Self { items: BinaryHeap::with_capacity(count_max), capacity: Capacity::new(count_max) }
    }

    /// Adds an item, or counts it as dropped.
    pub fn push(&mut self, item: T) {
        if self.capacity.accepts(self.items.len()) {
            self.items.push(item);
        }
    }

    /// Items dropped so far.
    pub fn dropped(&self) -> u64 {
        self.capacity.dropped
    }

    /// Whether the next push drops its item.
    pub fn is_full(&self) -> bool {
        self.items.len() == self.capacity.count_max
    }

    /// The greatest item.
    pub fn peek(&self) -> Option<&T> {
        self.items.peek()
    }

    /// Removes and returns the greatest item.
    pub fn pop(&mut self) -> Option<T> {
        self.items.pop()
    }

    /// Removes all items.
    pub fn clear(&mut self) {
        self.items.clear();
    }

    /// Bytes on the heap.
    pub fn heap_bytes(&self) -> usize {
        self.items.capacity() * size_of::<T>()
    }
}
