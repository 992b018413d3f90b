//! The border of a set of rates as far as it is known: a convex polygon inside the set.

use glam::DVec2;
use heapless::Vec as BoundedVec;

use crate::geometry::polygon::inward_normal;
use crate::timing::rate_set::VERTICES_MAX;
use crate::timing::tuning::{BORDER_TOLERANCE, DIRECTIONS_MAX};

/// Most corners.
const CORNERS_MAX: usize = VERTICES_MAX + DIRECTIONS_MAX;
/// Width of the edge of rates at rest, in units of the largest rates.
const REST_WIDTH: f64 = 1e-6;

/// The state of knowledge about an edge.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Edge {
    /// It is a side of the set within which the border was sought.
    Side,
    /// It is part of the border, nearly.
    Final,
    /// The border may lie beyond it.
    Open,
}

/// The border.
#[derive(Debug)]
pub(super) struct Border {
    /// The largest rates, the unit of both axes.
    extent: DVec2,
    /// Corners, counter-clockwise.
    corners: BoundedVec<DVec2, CORNERS_MAX>,
    /// The edge after each corner.
    edges: BoundedVec<Edge, CORNERS_MAX>,
}

impl Border {
    /// Nothing is known.
    pub fn new(extent: DVec2) -> Self {
        Self { extent, corners: BoundedVec::new(), edges: BoundedVec::new() }
    }

    /// The corners of a polygon around the set of which `is_inside` is known to be true; `None`
    /// where these are too few, or a corner at rest is not among them.
    pub fn within(
        extent: DVec2,
        polygon: &[DVec2],
        is_inside: impl Fn(DVec2) -> bool,
    ) -> Option<Self> {
        let inside: BoundedVec<bool, VERTICES_MAX> =
            polygon.iter().map(|&corner| is_inside(corner)).collect();
        let is_at_rest = |corner: &DVec2| corner.x <= REST_WIDTH * extent.x;
        let mut corners = polygon.iter().zip(&inside);
        if corners.any(|(corner, is_inside)| is_at_rest(corner) && !is_inside) {
            return None;
        }
        let mut border = Self::new(extent);
        let count = inside.len();
        for at in (0..count).filter(|&at| inside[at]) {
            let skipped = (1..count).take_while(|&step| !inside[(at + step) % count]).count();
            let next = polygon[(at + skipped + 1) % count];
            let depth = |step: usize| {
                let corner = polygon[(at + step) % count];
                border.depth_beyond([polygon[at], next], corner)
            };
            let beyond = (1..=skipped).map(depth).fold(0.0, f64::max);
            let edge = match skipped {
                0 => Edge::Side,
                _ if beyond <= BORDER_TOLERANCE => Edge::Final,
                _ => Edge::Open,
            };
            let _fits = (border.corners.push(polygon[at]), border.edges.push(edge));
        }
        (border.corners.len() > 1).then_some(border)
    }

    /// The corners.
    pub fn corners(&self) -> &[DVec2] {
        &self.corners
    }

    /// The edges that are not sides of the polygon around the set.
    pub fn inner_edges(&self) -> impl Iterator<Item = [DVec2; 2]> + '_ {
        let next = self.corners.iter().cycle().skip(1);
        let pairs = self.corners.iter().zip(next).zip(&self.edges);
        pairs.filter(|(_, edge)| **edge != Edge::Side).map(|((&a, &b), _)| [a, b])
    }

    /// Appends a corner unless it repeats the last one or the first one.
    pub fn push(&mut self, corner: DVec2) {
        let is_apart = |other: &&DVec2| {
            ((**other - corner) / self.extent).length() > BORDER_TOLERANCE * BORDER_TOLERANCE
        };
        let ends = [self.corners.first(), self.corners.last()];
        if ends.iter().flatten().all(is_apart) {
            let _fits = (self.corners.push(corner), self.edges.push(Edge::Open));
        }
    }

    /// The ends of an edge in units of the largest rates.
    fn ends(&self, index: usize) -> [DVec2; 2] {
        [index, (index + 1) % self.corners.len()].map(|at| self.corners[at] / self.extent)
    }

    /// How far a corner is beyond an edge, in units of the largest rates.
    fn depth_beyond(&self, edge: [DVec2; 2], corner: DVec2) -> f64 {
        let [a, b] = edge.map(|end| end / self.extent);
        (-inward_normal(a, b)).dot(corner / self.extent - a)
    }

    /// The longest edge that may not be part of the border, and its outward normal. Rates below
    /// rest do not exist.
    pub fn widest_gap(&self) -> Option<(usize, DVec2)> {
        let length = |index: &usize| {
            let [a, b] = self.ends(*index);
            let is_of_rest = a.x.max(b.x) <= REST_WIDTH && b.y <= a.y;
            if self.edges[*index] == Edge::Open && !is_of_rest { a.distance(b) } else { 0.0 }
        };
        let longest = (0..self.corners.len())
            .reduce(|best, index| if length(&index) > length(&best) { index } else { best })?;
        let [a, b] = self.ends(longest);
        (length(&longest) > 0.0).then_some((longest, -inward_normal(a, b)))
    }

    /// Takes the farthest corner beyond an edge.
    pub fn refine(&mut self, edge: usize, corner: DVec2) {
        let [a, b] = [edge, (edge + 1) % self.corners.len()].map(|at| self.corners[at]);
        if self.depth_beyond([a, b], corner) > BORDER_TOLERANCE {
            let at = edge + 1;
            let _fits = (self.corners.insert(at, corner), self.edges.insert(at, Edge::Open));
        } else {
            self.edges[edge] = Edge::Final;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_corners_beyond_the_set_are_asked_for() {
        // The set is the unit square less the corner beyond x + y = 1.5.
        let square = [(0.0, 0.0), (1.0, 0.0), (1.0, 1.0), (0.0, 1.0)].map(DVec2::from);
        let is_inside = |corner: DVec2| corner.x + corner.y <= 1.5;
        let mut border = Border::within(DVec2::ONE, &square, is_inside).unwrap();
        assert_eq!(border.corners().len(), 3);
        let mut asked = 0;
        while let Some((edge, normal)) = border.widest_gap() {
            asked += 1;
            let candidates = [(1.0, 0.0), (1.0, 0.5), (0.5, 1.0), (0.0, 1.0)].map(DVec2::from);
            let farthest = |a: DVec2, b: DVec2| if normal.dot(b) > normal.dot(a) { b } else { a };
            border.refine(edge, candidates.into_iter().reduce(farthest).unwrap_or_default());
        }
        assert_eq!(asked, 5, "once for each new corner, once for each of the edges between");
        assert_eq!(border.corners().len(), 5);
        assert_eq!(border.inner_edges().count(), 3);
        let all = Border::within(DVec2::ONE, &square, |_| true).unwrap();
        assert!(all.widest_gap().is_none() && all.inner_edges().next().is_none());
        // A corner that is hardly beyond is left out.
        let nearly = [(0.0, 0.0), (1.0, 0.0), (1.0, 0.998), (0.998, 1.0), (0.0, 1.0)];
        let nearly = nearly.map(DVec2::from);
        let border = Border::within(DVec2::ONE, &nearly, |corner| corner.y != 0.998).unwrap();
        assert!(border.widest_gap().is_none() && border.inner_edges().count() == 1);
        // Beyond rates at rest alone there may be more.
        let border = Border::within(DVec2::ONE, &square, |corner| corner.x == 0.0).unwrap();
        assert_eq!(border.widest_gap().map(|(_, normal)| normal), Some(DVec2::X));
        // All of the border is asked for where the rates at rest are not known.
        assert!(Border::within(DVec2::ONE, &square, |corner| corner.x + corner.y > 0.5).is_none());
    }
}
