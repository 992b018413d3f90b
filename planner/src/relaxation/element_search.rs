//! Which elements of the ground steps reach, by the distances between soles that touch them. It is
//! exact where voxels are coarse, and tried where the world has few elements.

use glam::DVec3;

use crate::foot_placement::{Bearing, Surfaces};
use crate::relaxation::tuning::{PAIRS_PER_UNIT, SEARCHED_ELEMENTS_MAX, TOLERANCE};

/// The longest steps.
#[derive(Debug, Clone, Copy)]
pub(crate) struct StepBounds {
    /// Greatest distance between two soles of a stance, m.
    pub reach: f64,
    /// Greatest distance of a point of a sole from its origin, m.
    pub radius: f64,
}

/// The elements of ground that steps reach from one end.
#[derive(Debug)]
pub(crate) struct ElementSearch {
    /// Whether an element is reached, by its number; empty where all are taken to be.
    reached: Vec<bool>,
    /// The reached ones, in their order.
    queue: Vec<u32>,
    /// Index in the queue of the one from which steps are tried, and the element that is next.
    next: (usize, u32),
}

impl ElementSearch {
    /// A search with reserved memory. Allocates.
    pub fn new() -> Self {
        Self {
            reached: Vec::with_capacity(SEARCHED_ELEMENTS_MAX),
            queue: Vec::with_capacity(SEARCHED_ELEMENTS_MAX),
            next: (0, 0),
        }
    }

    /// Takes all elements to be reached.
    pub fn skip(&mut self) {
        self.reached.clear();
        self.queue.clear();
        self.next = (0, 0);
    }

    /// Begins with the elements one step from the soles of one end.
    pub fn begin(&mut self, surfaces: &Surfaces, soles: &[DVec3], bounds: StepBounds) {
        self.skip();
        if surfaces.element_count() as usize > SEARCHED_ELEMENTS_MAX {
            return;
        }
        self.reached.resize(surfaces.element_count() as usize, false);
        for id in 0..surfaces.element_count() {
            if surfaces.may_bear(id) && is_near(surfaces, id, soles, bounds) {
                self.add(id);
            }
        }
    }

    fn add(&mut self, id: u32) {
        self.reached[id as usize] = true;
        self.queue.push(id);
    }

    /// Does one unit of work. Returns whether all elements are known that steps reach.
    pub fn advance(&mut self, surfaces: &Surfaces, bounds: StepBounds) -> bool {
        for _ in 0..PAIRS_PER_UNIT {
            let Some(&from) = self.queue.get(self.next.0) else { return true };
            let id = self.next.1;
            if id == surfaces.element_count() {
                self.next = (self.next.0 + 1, 0);
                continue;
            }
            self.next.1 += 1;
            let may_step = || {
                let distance = Bearing::of(surfaces).sole_distance([from, id], bounds.radius);
                distance <= bounds.reach + TOLERANCE
            };
            if !self.reached[id as usize] && surfaces.may_bear(id) && may_step() {
                self.add(id);
            }
        }
        false
    }

    /// Whether an element is reached, as far as is known.
    pub fn contains(&self, id: u32) -> bool {
        self.reached.get(id as usize).copied().unwrap_or(true)
    }

    /// Whether steps lead from the reached elements, or from the soles of this end, to those of the
    /// other.
    pub fn reaches(
        &self,
        surfaces: &Surfaces,
        [soles, others]: [&[DVec3]; 2],
        bounds: StepBounds,
    ) -> bool {
        let is_one_step = |sole: &DVec3| {
            others.iter().any(|other| sole.distance(*other) <= bounds.reach + TOLERANCE)
        };
        self.reached.is_empty()
            || soles.iter().any(is_one_step)
            || self.queue.iter().any(|&id| is_near(surfaces, id, others, bounds))
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.reached.capacity() + self.queue.capacity() * size_of::<u32>()
    }
}

/// Whether a sole on an element may be one step from some of these soles.
fn is_near(surfaces: &Surfaces, id: u32, soles: &[DVec3], bounds: StepBounds) -> bool {
    let near = |sole: &DVec3| Bearing::of(surfaces).distance_from_sole(id, *sole, bounds.radius);
    soles.iter().any(|sole| near(sole) <= bounds.reach + TOLERANCE)
}
