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
