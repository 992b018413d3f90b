//! The memory that queries work in, allocated once.

use std::collections::BinaryHeap;

use glam::{DVec2, DVec3};

use crate::foot_placement::candidates::Candidate;
use crate::foot_placement::config::FootPlacementConfig;
use crate::foot_placement::planes::{Footprint, Plane};
use crate::geometry::polygon::{CLIP_VERTICES_MAX, ClipBuffer};

/// Memory of one caller's queries; no query allocates beyond it. One per thread, any number of
/// [`crate::foot_placement::surfaces::Surfaces`].
#[derive(Debug)]
pub struct Scratch {
    pub(crate) clip: ClipBuffer,
    pub(crate) contact_points: Bounded<DVec2>,
    pub(crate) hull: Vec<DVec2>,
    /// The point of the last rejected support that stands furthest above the sole plane, in the
    /// world.
    pub(crate) intrusion: Option<DVec3>,
    pub(crate) features: Bounded<(f64, u32)>,
    pub(crate) planes: Bounded<Plane>,
    /// The planes of which the candidates are listed.
    pub(crate) planes_listed: usize,
    pub(crate) footprints: Bounded<Footprint>,
    /// Candidates, best first, as far as requested.
    pub(crate) candidates: Bounded<Candidate>,
    /// Those that are listed and come after.
    pub(crate) waiting: BoundedHeap<Candidate>,
    /// Candidates with less area than required at first, by index.
    pub(crate) deferred: Bounded<u32>,
    pub(crate) intersection_points: Bounded<DVec3>,
    /// The ground under a sole that is set down, in the sole frame.
    pub(crate) ground: Bounded<DVec3>,
}

impl Scratch {
    /// Allocates what queries with this configuration need.
    pub fn new(config: &FootPlacementConfig) -> Self {
        Self {
            clip: ClipBuffer::new(),
            contact_points: Bounded::new(config.contact_points_max),
            hull: Vec::with_capacity(config.contact_points_max + 8),
            intrusion: None,
            features: Bounded::new(GATHERING_FACTOR * config.features_max),
            planes: Bounded::new(config.planes_max),
            planes_listed: 0,
            footprints: Bounded::new(config.features_max),
            candidates: Bounded::new(config.candidates_max),
            waiting: BoundedHeap::new(config.candidates_max),
            deferred: Bounded::new(config.candidates_max),
            intersection_points: Bounded::new(config.intersection_points_max),
            ground: Bounded::new(config.ground_points_max),
        }
    }

    /// Bytes on the heap.
    pub fn heap_bytes(&self) -> usize {
        2 * CLIP_VERTICES_MAX * size_of::<DVec3>()
            + self.contact_points.heap_bytes()
            + self.hull.capacity() * size_of::<DVec2>()
            + self.features.heap_bytes()
            + self.planes.heap_bytes()
            + self.footprints.heap_bytes()
            + self.candidates.heap_bytes()
            + self.waiting.heap_bytes()
            + self.deferred.heap_bytes()
            + self.intersection_points.heap_bytes()
            + self.ground.heap_bytes()
    }

    /// How often anything was left out because its list was full, since this scratch was made.
    pub fn dropped(&self) -> u64 {
        self.contact_points.capacity.dropped
            + self.features.capacity.dropped
            + self.planes.capacity.dropped
            + self.footprints.capacity.dropped
            + self.candidates.capacity.dropped
            + self.waiting.capacity.dropped
            + self.intersection_points.capacity.dropped
            + self.ground.capacity.dropped
    }
}

/// How many times `features_max` are held while the nearest are being picked.
const GATHERING_FACTOR: usize = 4;

/// Capacity of a list, and the number of items dropped beyond it.
#[derive(Debug)]
pub(crate) struct Capacity {
    count_max: usize,
    /// How many items were dropped so far.
    pub dropped: u64,
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

/// A list that never grows beyond its first capacity: what does not fit is counted and dropped.
#[derive(Debug)]
pub(crate) struct Bounded<T> {
    items: Vec<T>,
    /// Its capacity.
    pub capacity: Capacity,
}

impl<T> Bounded<T> {
    fn new(count_max: usize) -> Self {
        Self { items: Vec::with_capacity(count_max), capacity: Capacity::new(count_max) }
    }

    /// Adds an item, or counts it as dropped.
    pub fn push(&mut self, item: T) {
        if self.capacity.accepts(self.items.len()) {
            self.items.push(item);
        }
    }

    /// Whether the next push drops.
    pub fn is_full(&self) -> bool {
        self.items.len() == self.capacity.count_max
    }

    /// Forgets the items from this index on.
    pub fn truncate(&mut self, count: usize) {
        self.items.truncate(count);
    }

    fn heap_bytes(&self) -> usize {
        self.items.capacity() * size_of::<T>()
    }

    /// Forgets the items.
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

/// A heap that never grows beyond its first capacity, like [`Bounded`].
#[derive(Debug)]
pub(crate) struct BoundedHeap<T> {
    items: BinaryHeap<T>,
    capacity: Capacity,
}

impl<T: Ord> BoundedHeap<T> {
    fn new(count_max: usize) -> Self {
        Self { items: BinaryHeap::with_capacity(count_max), capacity: Capacity::new(count_max) }
    }

    /// Adds an item, or counts it as dropped.
    pub fn push(&mut self, item: T) {
        if self.capacity.accepts(self.items.len()) {
            self.items.push(item);
        }
    }

    /// Whether the next push drops.
    pub fn is_full(&self) -> bool {
        self.items.len() == self.capacity.count_max
    }

    /// The greatest item.
    pub fn peek(&self) -> Option<&T> {
        self.items.peek()
    }

    /// Takes the greatest item.
    pub fn pop(&mut self) -> Option<T> {
        self.items.pop()
    }

    /// Forgets the items.
    pub fn clear(&mut self) {
        self.items.clear();
    }

    fn heap_bytes(&self) -> usize {
        self.items.capacity() * size_of::<T>()
    }
}
