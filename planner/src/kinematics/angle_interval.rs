//! Rotations about one axis as sine and cosine, and intervals of them. They test joint limits
//! without computing the angle.

use glam::DVec3;

/// Difference of cosines by which a rotation outside of an interval may still be accepted.
const COSINE_TOLERANCE: f64 = 1e-9;

/// The sine and cosine of an angle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct UnitRotation {
    /// Its sine.
    pub sin: f64,
    /// Its cosine.
    pub cos: f64,
}

impl UnitRotation {
    /// The rotation by 0 to pi with this cosine (-1 to 1).
    pub fn of_cosine(cos: f64) -> Self {
        Self { sin: ((1.0 - cos) * (1.0 + cos)).sqrt(), cos }
    }

    /// Its angle, -pi to pi (rad).
    pub fn angle(self) -> f64 {
        libm::atan2(self.sin, self.cos)
    }

    /// The rotation whose sine and cosine are proportional to these values, not both 0.
    pub fn in_proportion(sin: f64, cos: f64) -> Self {
        let scale = 1.0 / (sin * sin + cos * cos).sqrt();
        Self { sin: sin * scale, cos: cos * scale }
    }

    /// The composition of both rotations.
    pub fn then(self, other: Self) -> Self {
        Self {
            sin: self.sin * other.cos + self.cos * other.sin,
            cos: self.cos * other.cos - self.sin * other.sin,
        }
    }

    /// The inverse rotation.
    pub fn inverse(self) -> Self {
        Self { sin: -self.sin, ..self }
    }

    /// The rotation plus pi.
    pub fn opposite(self) -> Self {
        Self { sin: -self.sin, cos: -self.cos }
    }

    /// Pi minus the rotation.
    pub fn mirrored(self) -> Self {
        Self { cos: -self.cos, ..self }
    }

    /// A vector rotated about x.
    pub fn about_x(self, v: DVec3) -> DVec3 {
        DVec3::new(v.x, self.cos * v.y - self.sin * v.z, self.sin * v.y + self.cos * v.z)
    }

    /// A vector rotated about y.
    pub fn about_y(self, v: DVec3) -> DVec3 {
        DVec3::new(self.cos * v.x + self.sin * v.z, v.y, self.cos * v.z - self.sin * v.x)
    }
}

/// The angles between two limits.
#[derive(Debug, Clone, Copy)]
pub struct AngleInterval {
    middle: UnitRotation,
    /// Cosine of half the interval's length; less than any cosine for a full rotation.
    cos_half: f64,
}

impl AngleInterval {
    /// The interval between two limits (rad), in either order.
    pub fn of_limits(a: f64, b: f64) -> Self {
        let (sin, cos) = libm::sincos(0.5 * (a + b));
        let half = 0.5 * (a - b).abs();
        let cos_half = if half < std::f64::consts::PI { libm::cos(half) } else { -2.0 };
        Self { middle: UnitRotation { sin, cos }, cos_half }
    }

    /// Whether a rotation may lie within the interval; `false` is certain up to rounding errors far
    /// below any joint margin. `false` for NaN.
    pub fn may_contain(&self, rotation: UnitRotation) -> bool {
        rotation.cos * self.middle.cos + rotation.sin * self.middle.sin
            >= self.cos_half - COSINE_TOLERANCE
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_interval_contains_the_angles_between_its_limits() {
        for (lower, upper) in [(-0.4, 1.2), (2.5, 3.1), (-3.0, 3.0), (-4.0, 4.0)] {
            for step in -31..=31 {
                let angle = 0.1 * f64::from(step) + 0.003;
                let (sin, cos) = libm::sincos(angle);
                let rotation = UnitRotation::in_proportion(0.3 * sin, 0.3 * cos);
                assert_eq!(
                    AngleInterval::of_limits(upper, lower).may_contain(rotation),
                    (lower..=upper).contains(&angle),
                    "{angle}"
                );
            }
        }
        assert!(
            !AngleInterval::of_limits(-4.0, 4.0)
                .may_contain(UnitRotation { sin: f64::NAN, cos: 0.0 })
        );
    }

    #[test]
    fn compositions_add_angles() {
        let rotation = |angle: f64| UnitRotation { sin: libm::sin(angle), cos: libm::cos(angle) };
        for (a, b) in [(0.3, 1.1), (-2.0, 0.7), (1.4, -0.2)] {
            assert!((rotation(a).then(rotation(b)).angle() - (a + b)).abs() < 1e-12);
            assert!((rotation(a).then(rotation(b).inverse()).angle() - (a - b)).abs() < 1e-12);
            assert!((UnitRotation::of_cosine(libm::cos(a)).angle() - a.abs()).abs() < 1e-12);
            assert!((rotation(a).opposite().then(rotation(-a)).cos + 1.0).abs() < 1e-12);
        }
    }
}
