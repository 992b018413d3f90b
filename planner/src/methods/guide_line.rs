//! A guide route seen from above, by its length from the start.

use glam::DVec2;

use crate::base::arena::reserve;
use crate::methods::exploration::POINTS_MAX;

/// A polyline from start to goal.
#[derive(Debug)]
pub(crate) struct GuideLine {
    points: Vec<DVec2>,
    /// Its length, m.
    pub length: f64,
}

impl GuideLine {
    /// Reserves memory.
    pub fn new() -> Self {
        Self { points: reserve(POINTS_MAX), length: 0.0 }
    }

    /// Takes the points of a route from the goal to the start.
    pub fn set(&mut self, from_goal: impl Iterator<Item = DVec2>) {
        self.points.clear();
        self.points.extend(from_goal);
        self.points.reverse();
        self.length = self.points.windows(2).map(|ends| ends[0].distance(ends[1])).sum();
    }

    /// The point at a length from the start (m), and the direction there (rad).
    pub fn at(&self, length: f64) -> (DVec2, f64) {
        let mut left = length.clamp(0.0, self.length);
        let mut last = (self.points.first().copied().unwrap_or(DVec2::ZERO), 0.0);
        for ends in self.points.windows(2) {
            let offset = ends[1] - ends[0];
            let piece = offset.length();
            if piece > 0.0 {
                let direction = libm::atan2(offset.y, offset.x);
                last = (ends[0] + (left / piece).min(1.0) * offset, direction);
            }
            if left <= piece {
                break;
            }
            left -= piece;
        }
        last
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.points.capacity() * size_of::<DVec2>()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::FRAC_PI_2;

    #[test]
    fn points_follow_the_corners_of_the_line() {
        let mut line = GuideLine::new();
        let corners = [(0.0, 0.0), (2.0, 0.0), (2.0, 0.0), (2.0, 3.0)].map(DVec2::from);
        line.set(corners.into_iter().rev());
        assert_eq!(line.length, 5.0);
        assert_eq!(line.at(1.0), (DVec2::new(1.0, 0.0), 0.0));
        assert_eq!(line.at(3.5), (DVec2::new(2.0, 1.5), FRAC_PI_2));
        assert_eq!(line.at(9.0).0, DVec2::new(2.0, 3.0));
    }
}
