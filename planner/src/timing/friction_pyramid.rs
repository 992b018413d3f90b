//! Friction of a sole as a pyramid of forces, inside a pyramid with eight sides inside the friction
//! cone, as the controller's, whichever way that is turned.

use std::f64::consts::FRAC_1_SQRT_2;

use glam::DVec2;
use heapless::Vec as BoundedVec;

/// cos(pi / 8).
const COS_EIGHTH: f64 = 0.923_879_532_511_286_7;
/// Most edges.
pub(crate) const EDGES_MAX: usize = 8;
/// How far a force may be beyond friction by rounding, relative.
const ROUNDING: f64 = 1e-9;

/// The forces along a sole, in its axes, that friction holds by unit of force across it.
#[derive(Debug, Clone)]
pub struct FrictionPyramid {
    /// Coefficient of friction.
    pub coefficient: f64,
    /// Directions of the edges: corners of a regular polygon, counter-clockwise.
    directions: BoundedVec<DVec2, EDGES_MAX>,
    /// Distance of its sides from its middle.
    side_distance: f64,
    /// Largest force along both axes at once, as a share of that along an edge.
    along_both: f64,
}

impl FrictionPyramid {
    /// With a side across each direction of both axes: contact forces in closed form exist.
    pub fn with_four_sides(coefficient: f64) -> Self {
        let corners = [(1.0, 1.0), (-1.0, 1.0), (-1.0, -1.0), (1.0, -1.0)];
        let directions = corners.into_iter().map(|(x, y)| FRAC_1_SQRT_2 * DVec2::new(x, y));
        Self {
            coefficient,
            directions: directions.collect(),
            side_distance: FRAC_1_SQRT_2,
            along_both: FRAC_1_SQRT_2,
        }
    }

    /// With an edge along a direction, and seven more: holds a robot where the ground rises along
    /// it up to 1.41 times as steeply.
    pub fn with_eight_sides(coefficient: f64, along: DVec2) -> Self {
        let edge = along.normalize_or(DVec2::X);
        let between = FRAC_1_SQRT_2 * (edge + edge.perp());
        let half = [edge, between, edge.perp(), between.perp()];
        Self {
            coefficient,
            directions: half.into_iter().chain(half.map(|edge| -edge)).collect(),
            side_distance: COS_EIGHTH,
            along_both: COS_EIGHTH * FRAC_1_SQRT_2,
        }
    }

    /// Largest force along an edge, by unit of force across the sole: that along a side of the
    /// outer pyramid.
    fn along_edge(&self) -> f64 {
        self.coefficient * COS_EIGHTH
    }

    /// The forces along its edges, by unit of force across the sole.
    pub fn edges(&self) -> impl Iterator<Item = DVec2> + '_ {
        self.directions.iter().map(|direction| self.along_edge() * direction)
    }

    /// Its sides: outward normals, and the largest force along each by unit of force across the
    /// sole.
    pub fn sides(&self) -> impl Iterator<Item = (DVec2, f64)> + '_ {
        let next = self.directions.iter().cycle().skip(1);
        let normals = self.directions.iter().zip(next);
        let normals = normals.map(|(a, b)| (a + b) * (0.5 / self.side_distance));
        normals.map(|normal| (normal, self.side_distance * self.along_edge()))
    }

    /// Largest force along each axis at once, by unit of force across the sole.
    pub fn along_axes(&self) -> f64 {
        self.along_both * self.along_edge()
    }

    /// Largest force along a direction, by unit of force across the sole.
    pub fn along(&self, direction: DVec2) -> f64 {
        self.edges().map(|edge| edge.dot(direction)).fold(0.0, f64::max)
    }

    /// Whether it holds a force along the sole (N) at a force across it (N), which is not negative.
    pub fn holds(&self, force: DVec2, press: f64) -> bool {
        let most = press * (1.0 + ROUNDING);
        let inside = self.side_distance * self.along_edge() * press;
        force.length_squared() <= inside * inside
            || self.sides().all(|(normal, offset)| normal.dot(force) <= offset * most)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Four sides, and eight whose first edge is turned by these angles (rad).
    fn pyramids(angles: [f64; 4]) -> Vec<FrictionPyramid> {
        let eight = angles.map(|angle| FrictionPyramid::with_eight_sides(0.6, unit(angle)));
        eight.into_iter().chain([FrictionPyramid::with_four_sides(0.6)]).collect()
    }

    fn unit(angle: f64) -> DVec2 {
        DVec2::new(libm::cos(angle), libm::sin(angle))
    }

    #[test]
    fn a_pyramid_lies_inside_a_turned_pyramid_with_eight_sides() {
        for pyramid in pyramids([0.0, 0.2, 0.4, 2.0]) {
            assert!(pyramid.sides().all(|(normal, _)| (normal.length() - 1.0).abs() < 1e-12));
            assert_eq!(pyramid.sides().count(), pyramid.edges().count());
            for turn in 0..16 {
                let direction = unit(f64::from(turn) * std::f64::consts::TAU / 16.0);
                let inner = 0.6 * libm::cos(std::f64::consts::PI / 8.0);
                assert!(pyramid.along(direction) <= inner + 1e-12);
            }
            let both = DVec2::new(pyramid.along_axes(), -pyramid.along_axes());
            assert!(pyramid.holds(both, 1.0), "along both axes at once");
        }
    }

    #[test]
    fn without_friction_nothing_is_held_along_the_sole() {
        let pyramids = [
            FrictionPyramid::with_four_sides(0.0),
            FrictionPyramid::with_eight_sides(0.0, DVec2::Y),
        ];
        for pyramid in pyramids {
            assert!(pyramid.holds(DVec2::ZERO, 400.0) && !pyramid.holds(DVec2::X, 400.0));
            assert!(pyramid.sides().all(|(normal, most)| normal.is_finite() && most == 0.0));
        }
    }

    #[test]
    fn a_force_is_held_up_to_the_sides() {
        for pyramid in pyramids([0.1, 0.5, 3.0, 4.0]) {
            for angle in [0.0, 0.3, 1.0, 2.0, 3.5, 5.0] {
                let most = pyramid.sides().map(|(normal, offset)| offset / normal.dot(unit(angle)));
                let most = most.filter(|most| *most > 0.0).fold(f64::INFINITY, f64::min);
                let holds = |part: f64| pyramid.holds(part * most * unit(angle) * 400.0, 400.0);
                assert!(holds(1.0) && !holds(1.0001));
                assert!(pyramid.along(unit(angle)) >= most - 1e-12);
            }
        }
    }

    #[test]
    fn the_steepest_ground_that_an_edge_points_up_is_held() {
        let along = DVec2::new(0.3, -0.4);
        let pyramid = FrictionPyramid::with_eight_sides(0.6, along);
        assert!(pyramid.holds(0.554 * 400.0 * along.normalize(), 400.0));
        assert!(!FrictionPyramid::with_four_sides(0.6).holds(DVec2::X * 0.4 * 400.0, 400.0));
    }
}
