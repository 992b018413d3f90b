//! Axis-aligned boxes, a lower bound on the distance of their contents.

use glam::{DMat3, DVec3};
use surefoot_shared_types::Pose;

/// An axis-aligned box.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Bounds {
    /// Smallest coordinates, m.
    pub low: DVec3,
    /// Largest coordinates, m.
    pub high: DVec3,
}

impl Bounds {
    /// The box around some points; without points its low corner is above its high one.
    pub fn of_points(points: impl IntoIterator<Item = DVec3>) -> Self {
        let empty = Self { low: DVec3::INFINITY, high: DVec3::NEG_INFINITY };
        points.into_iter().fold(empty, |bounds, point| Self {
            low: bounds.low.min(point),
            high: bounds.high.max(point),
        })
    }

    /// The middle.
    pub fn centre(&self) -> DVec3 {
        0.5 * (self.low + self.high)
    }

    /// The largest component of its points along a direction.
    pub fn reach(&self, direction: DVec3) -> f64 {
        DVec3::select(direction.cmpge(DVec3::ZERO), self.high, self.low).dot(direction)
    }

    /// The axis-aligned box around this one, moved.
    pub fn transformed(&self, world_from_local: &Pose) -> Self {
        let rotation = DMat3::from_quat(world_from_local.rotation);
        let half = 0.5 * (self.high - self.low);
        let reach = rotation.x_axis.abs() * half.x
            + rotation.y_axis.abs() * half.y
            + rotation.z_axis.abs() * half.z;
        let centre = *world_from_local * self.centre();
        Self { low: centre - reach, high: centre + reach }
    }

    /// The box grown by `margin` (m) on all sides.
    pub fn expanded(&self, margin: f64) -> Self {
        Self { low: self.low - margin, high: self.high + margin }
    }

    /// Penetration depth of two overlapping boxes, m: the shortest translation along an axis that
    /// separates them; negative where they are apart along an axis.
    pub fn penetration(&self, other: &Self) -> f64 {
        (self.high - other.low).min(other.high - self.low).min_element()
    }

    /// Whether another box lies in this one.
    pub fn holds(&self, other: &Self) -> bool {
        self.low.cmple(other.low).all() && self.high.cmpge(other.high).all()
    }

    /// The distance between two boxes, m; 0 where they overlap.
    pub fn distance(&self, other: &Self) -> f64 {
        (self.low - other.high).max(other.low - self.high).max(DVec3::ZERO).length()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cuboid(low: [f64; 3], high: [f64; 3]) -> Bounds {
        Bounds { low: low.into(), high: high.into() }
    }

    #[test]
    fn distance_and_penetration_are_those_of_boxes_by_hand() {
        let a = cuboid([0.0; 3], [2.0, 3.0, 4.0]);
        let corner = cuboid([5.0, 7.0, 16.0], [6.0, 8.0, 17.0]);
        assert_eq!([a.distance(&corner), corner.distance(&a)], [13.0; 2]);
        let beside = cuboid([2.5, 1.0, 1.0], [3.0, 2.0, 2.0]);
        assert_eq!([a.distance(&beside), a.penetration(&beside)], [0.5, -0.5]);
        let across = cuboid([1.75, -9.0, -9.0], [9.0, 9.0, 9.0]);
        assert_eq!([a.distance(&across), a.penetration(&across)], [0.0, 0.25]);
        // The way out of a box that holds another is longer than the other is thick.
        let inside = cuboid([0.5, 1.0, 1.0], [0.75, 2.0, 3.0]);
        assert_eq!([a.penetration(&inside), inside.penetration(&a)], [0.75; 2]);
    }

    #[test]
    fn a_box_holds_what_lies_within_all_its_sides() {
        let a = cuboid([0.0; 3], [2.0, 3.0, 4.0]);
        assert!(a.holds(&cuboid([0.0; 3], [2.0, 3.0, 4.0])));
        assert!(a.holds(&cuboid([0.1; 3], [1.9; 3])));
        for axis in 0..3 {
            let (mut low, mut high) = ([0.1; 3], [1.9; 3]);
            low[axis] = -0.1;
            assert!(!a.holds(&cuboid(low, high)));
            (low[axis], high[axis]) = (0.1, 4.1);
            assert!(!a.holds(&cuboid(low, high)));
        }
    }

    #[test]
    fn reach_and_rotation_are_those_of_the_corners() {
        let a = cuboid([-1.0, 0.5, 2.0], [3.0, 0.75, 5.0]);
        let corners: Vec<DVec3> = (0..8)
            .map(|bits: usize| {
                let end = |axis: usize| if bits >> axis & 1 == 0 { a.low } else { a.high }[axis];
                DVec3::new(end(0), end(1), end(2))
            })
            .collect();
        let pose = Pose::from_parts(
            DVec3::new(1.0, -2.0, 0.5),
            glam::DQuat::from_euler(glam::EulerRot::XYZ, 0.4, -1.1, 2.3),
        );
        for direction in [DVec3::new(1.0, -2.0, 0.5), DVec3::new(-0.3, 0.2, -0.9)] {
            let furthest = corners.iter().map(|at| at.dot(direction)).fold(f64::MIN, f64::max);
            assert!((a.reach(direction) - furthest).abs() < 1e-12);
        }
        let around = Bounds::of_points(corners.iter().map(|corner| pose * *corner));
        let found = a.transformed(&pose);
        assert!(found.low.distance(around.low) < 1e-12 && found.high.distance(around.high) < 1e-12);
    }
}
