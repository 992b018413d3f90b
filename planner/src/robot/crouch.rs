//! Crouch: leg extension, pitch and roll of the trunk under and beside obstacles.

use crate::robot::tuning::LEG_EXTENSION_PER_RADIAN;

/// A crouch, relative to the posture it is applied to.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Crouch {
    /// Used part of the legs' standing reach, 0 to 1.
    pub leg_extension: f64,
    /// Forward lean of the root, rad.
    pub pitch: f64,
    /// Lean of the root to the right, rad.
    pub roll: f64,
    /// Forward bend of the waist, rad.
    pub waist: f64,
}

impl Crouch {
    /// The upright posture.
    pub const UPRIGHT: Self = Self { leg_extension: 1.0, pitch: 0.0, roll: 0.0, waist: 0.0 };

    /// Distance from upright: 1 equals fully bent legs or a lean of 2 rad.
    pub fn depth(&self) -> f64 {
        let angles = self.pitch.abs() + self.roll.abs() + self.waist;
        1.0 - self.leg_extension + LEG_EXTENSION_PER_RADIAN * angles
    }

    /// Distance from another crouch, in the same measure.
    pub fn distance(&self, other: &Self) -> f64 {
        let [pitch, roll] = [self.pitch - other.pitch, self.roll - other.roll];
        let waist = self.waist - other.waist;
        (self.leg_extension - other.leg_extension).abs()
            + LEG_EXTENSION_PER_RADIAN * (pitch.abs() + roll.abs() + waist.abs())
    }

    /// The deeper of two crouches.
    pub fn deeper(self, other: Self) -> Self {
        if other.depth() > self.depth() { other } else { self }
    }
}
