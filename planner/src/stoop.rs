//! How far the robot bends down where something hangs over its way.

/// Metres of height that a radian of lean is worth where stoops are compared, as a share of the standing height.
const SHARES_PER_RADIAN: f64 = 0.5;

/// A crouch and a lean, beside those of whatever posture is wished for.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stoop {
    /// The share of their standing reach that the legs use.
    pub share: f64,
    /// How far the root leans forward, rad.
    pub pitch: f64,
}

impl Stoop {
    /// None.
    pub const UPRIGHT: Self = Self { share: 1.0, pitch: 0.0 };

    /// How far it is from upright: 1 is as deep as a crouch of all the legs, or a lean of 2 rad.
    pub fn depth(&self) -> f64 {
        1.0 - self.share + SHARES_PER_RADIAN * self.pitch
    }

    /// The deeper one of two.
    pub fn deeper(self, other: Self) -> Self {
        if other.depth() > self.depth() { other } else { self }
    }

    /// The one halfway to another.
    pub fn midway(&self, other: &Self) -> Self {
        Self { share: self.share.midpoint(other.share), pitch: self.pitch.midpoint(other.pitch) }
    }
}

impl Default for Stoop {
    fn default() -> Self {
        Self::UPRIGHT
    }
}
