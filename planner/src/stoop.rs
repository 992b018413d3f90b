//! How far the robot bends down where something hangs over its way.

/// The share of the standing reach that a radian of lean counts as where stoops are compared.
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
}
