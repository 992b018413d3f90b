//! The rates at which a path can be walked at one of its points: a convex polygon of `x`, the
//! square of the path's speed, and `u`, its acceleration [Pham, Pham 2018].

use glam::DVec2;
use heapless::Vec as BoundedVec;

use crate::geometry::polygon::inward_normal;
use crate::timing::limit::Limit;

/// Most vertices of a set.
pub const VERTICES_MAX: usize = 32;
/// Smallest distance of two vertices that both stay.
const APART_MIN: f64 = 1e-10;

/// A convex polygon of rates `(x, u)`, counter-clockwise.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct RateSet {
    vertices: BoundedVec<DVec2, VERTICES_MAX>,
    /// The limit on the side from each vertex to the next.
    limits: BoundedVec<Limit, VERTICES_MAX>,
}

impl RateSet {
    /// All rates with `x` up to `x_max` and `u` between `-u_max` and `u_max`.
    pub fn within(x_max: f64, u_max: f64) -> Self {
        let corners = [(0.0, -u_max), (x_max, -u_max), (x_max, u_max), (0.0, u_max)];
        Self {
            vertices: corners.into_iter().map(DVec2::from).collect(),
            limits: corners.map(|_| Limit::PathRate).into_iter().collect(),
        }
    }

    /// Its vertices.
    pub fn vertices(&self) -> &[DVec2] {
        &self.vertices
    }

    /// Whether no rate is left.
    pub fn is_empty(&self) -> bool {
        self.vertices.is_empty()
    }

    /// Keeps the rates with `normal . (x, u) <= offset`, which `limit` demands.
    pub fn clip(&mut self, normal: DVec2, offset: f64, limit: Limit) {
        let depth = |vertex: DVec2| offset - normal.dot(vertex);
        if self.vertices.iter().all(|&vertex| depth(vertex) >= 0.0) {
            return;
        }
        let mut kept = Self::default();
        let (Some(&last), Some(&last_side)) = (self.vertices.last(), self.limits.last()) else {
            return;
        };
        let (mut a, mut a_depth, mut side) = (last, depth(last), last_side);
        for (&b, &next_side) in self.vertices.iter().zip(&self.limits) {
            let b_depth = depth(b);
            if (a_depth >= 0.0) != (b_depth >= 0.0) {
                let crossing = a + (b - a) * (a_depth / (a_depth - b_depth));
                kept.push(crossing, if a_depth >= 0.0 { limit } else { side });
            }
            if b_depth >= 0.0 {
                kept.push(b, next_side);
            }
            (a, a_depth, side) = (b, b_depth, next_side);
        }
        kept.close();
        *self = kept;
    }

    /// Keeps the rates from which a cell of the path of length `step` ends at rates that `end`
    /// allows with the same acceleration. That `x` is not negative there is left to the caller.
    pub fn clip_by_end(&mut self, end: &Self, step: f64) {
        for (normal, offset, limit) in end.sides().filter(|side| !is_at_rest(side.0)) {
            self.clip(DVec2::new(normal.x, normal.y + 2.0 * step * normal.x), offset, limit);
        }
    }

    /// The largest `x`, and the acceleration there; `None` if the set is empty.
    pub fn fastest(&self) -> Option<DVec2> {
        self.vertices.iter().copied().reduce(|a, b| if b.x > a.x { b } else { a })
    }

    /// The least and the largest acceleration at a speed; `None` if the set has no such speed.
    pub fn accelerations_at(&self, x: f64) -> Option<[f64; 2]> {
        let mut range: Option<[f64; 2]> = None;
        let mut include = |u: f64| {
            range = Some(range.map_or([u, u], |[low, high]| [low.min(u), high.max(u)]));
        };
        for (a, b) in self.edges() {
            let (low, high) = (a.x.min(b.x), a.x.max(b.x));
            let x = if (x - low).abs() < X_ROUNDING * (1.0 + high) { low } else { x };
            let x = if (x - high).abs() < X_ROUNDING * (1.0 + high) { high } else { x };
            if (low..=high).contains(&x) {
                if high - low > APART_MIN {
                    include(a.y + (b.y - a.y) * ((x - a.x) / (b.x - a.x)));
                } else {
                    include(a.y);
                    include(b.y);
                }
            }
        }
        range
    }

    /// The share of the set that a rate takes: the least factor by which the set, grown about rest,
    /// holds the rate. Without bound where rest is on a side of the set.
    pub fn share_of(&self, rate: DVec2) -> f64 {
        self.binding_at(rate).1
    }

    /// The limit of which a rate takes the largest share, and that share.
    pub fn binding_at(&self, rate: DVec2) -> (Limit, f64) {
        let mut most = (Limit::PathRate, 0.0);
        if self.vertices.len() < 3 {
            return (Limit::PathRate, f64::INFINITY);
        }
        for ((a, b), &limit) in self.edges().zip(&self.limits) {
            // Outward. Its length counts in no ratio.
            let normal = (a - b).perp();
            let used = normal.dot(rate);
            if used > 0.0 && used * used > USED_MIN * USED_MIN * normal.length_squared() {
                let share = used / normal.dot(a).max(f64::MIN_POSITIVE);
                most = if share > most.1 { (limit, share) } else { most };
            }
        }
        most
    }

    /// The set shrunk about rest.
    pub fn scaled(&self, factor: f64) -> Self {
        let vertices = self.vertices.iter().map(|&vertex| vertex * factor).collect();
        Self { vertices, limits: self.limits.clone() }
    }

    /// The outward normals of all sides, of length 1, with their offsets and limits.
    pub fn sides(&self) -> impl Iterator<Item = (DVec2, f64, Limit)> + '_ {
        let sides = self.edges().zip(&self.limits);
        sides.filter(|((a, b), _)| a.distance_squared(*b) > 0.0).map(|((a, b), &limit)| {
            let normal = -inward_normal(a, b);
            (normal, normal.dot(a), limit)
        })
    }

    fn edges(&self) -> impl Iterator<Item = (DVec2, DVec2)> + '_ {
        let next = self.vertices.iter().cycle().skip(1);
        self.vertices.iter().zip(next).map(|(&a, &b)| (a, b))
    }

    /// Appends a vertex with the limit on the side after it. One that repeats the last one
    /// replaces only that limit.
    fn push(&mut self, vertex: DVec2, limit: Limit) {
        match self.vertices.last() {
            Some(last) if last.distance(vertex) <= APART_MIN => {
                self.limits.pop();
                let _as_many = self.limits.push(limit);
            }
            _ => {
                let _only_shrinks = (self.vertices.push(vertex), self.limits.push(limit));
            }
        }
    }

    /// Drops a last vertex that repeats the first one.
    fn close(&mut self) {
        while let [first, .., last] = *self.vertices
            && first.distance(last) <= APART_MIN
        {
            self.vertices.pop();
            self.limits.pop();
        }
    }
}

/// Whether a side is that of the rates with `x = 0`.
fn is_at_rest(normal: DVec2) -> bool {
    normal.x < -1.0 + 1e-9
}

/// Rounding of a speed at the end of its range, relative.
const X_ROUNDING: f64 = 1e-9;
/// Smallest distance of a rate from rest towards a side that counts.
const USED_MIN: f64 = 1e-9;

#[cfg(test)]
mod tests {
    use super::*;

    fn square() -> RateSet {
        RateSet::within(4.0, 2.0)
    }

    #[test]
    fn clipping_keeps_the_near_side() {
        let mut set = square();
        set.clip(DVec2::new(1.0, 1.0), 3.0, Limit::Friction);
        assert_eq!(set.binding_at(DVec2::new(2.5, 0.5)), (Limit::Friction, 1.0));
        assert_eq!(set.binding_at(DVec2::new(1.0, -1.9)), (Limit::PathRate, 0.95));
        assert_eq!(set.vertices().len(), 5);
        assert_eq!(set.accelerations_at(4.0), Some([-2.0, -1.0]));
        assert_eq!(set.accelerations_at(1.0), Some([-2.0, 2.0]));
        assert_eq!(set.accelerations_at(4.1), None);
        set.clip(DVec2::new(-1.0, 0.0), -9.0, Limit::Friction);
        assert!(set.is_empty() && set.fastest().is_none());
    }

    #[test]
    fn the_share_of_a_rate_grows_in_proportion() {
        let set = square();
        assert!((set.share_of(DVec2::new(1.0, 1.5)) - 0.75).abs() < 1e-12);
        assert!((set.share_of(DVec2::new(2.0, 3.0)) - 1.5).abs() < 1e-12);
        assert!((set.scaled(0.5).share_of(DVec2::new(1.0, 0.1)) - 0.5).abs() < 1e-12);
    }

    #[test]
    fn a_cell_ends_within_the_set_of_its_end() {
        let (mut set, end) = (square(), RateSet::within(1.0, 2.0));
        set.clip_by_end(&end, 0.5);
        let fastest = set.fastest().unwrap();
        assert!((fastest.x + fastest.y - 1.0).abs() < 1e-12 || fastest.x + fastest.y <= 1.0);
        assert!((fastest.x - 3.0).abs() < 1e-12, "{fastest}");
    }
}
