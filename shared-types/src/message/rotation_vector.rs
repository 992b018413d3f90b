//! Rates of a rotation `exp(phi(t))`: the derivatives of the rotation vector `phi`, and angular
//! velocity and acceleration along the rotating body's own axes.
//!
//! `omega = J(phi) phi'` with the right Jacobian of SO(3) [Sola 2018, eq. 143]
//! `J(phi) x = x - a phi * x + b phi * (phi * x)` (`*` is the cross product), where
//! `a = (1 - cos |phi|) / |phi|^2` and `b = (|phi| - sin |phi|) / |phi|^3`.

use glam::DVec3;

/// First and second derivative of a rotation vector, or angular velocity and acceleration.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct RotationRates {
    /// Rotation vector's derivative, or angular velocity, rad/s.
    pub first: DVec3,
    /// The derivative of `first`, rad/s2.
    pub second: DVec3,
}

/// Below this squared angle (rad2) power series replace quotients that lose their digits.
const SERIES_BELOW: f64 = 1e-2;

/// The coefficients of the right Jacobian and their derivatives by the squared angle.
struct Coefficients {
    a: f64,
    b: f64,
    a_slope: f64,
    b_slope: f64,
}

impl Coefficients {
    fn new(vector: DVec3) -> Self {
        let s = vector.length_squared();
        if s < SERIES_BELOW {
            return Self {
                a: 0.5 - s * (1.0 / 24.0 - s * (1.0 / 720.0 - s / 40_320.0)),
                b: 1.0 / 6.0 - s * (1.0 / 120.0 - s * (1.0 / 5040.0 - s / 362_880.0)),
                a_slope: -1.0 / 24.0 + s * (1.0 / 360.0 - s / 13_440.0),
                b_slope: -1.0 / 120.0 + s * (1.0 / 2520.0 - s / 120_960.0),
            };
        }
        let angle = s.sqrt();
        let (sin, cos) = libm::sincos(angle);
        let (a, b) = ((1.0 - cos) / s, (angle - sin) / (s * angle));
        Self { a, b, a_slope: (0.5 * sin / angle - a) / s, b_slope: (0.5 * a - 1.5 * b) / s }
    }

    fn jacobian(&self, vector: DVec3, x: DVec3) -> DVec3 {
        let once = vector.cross(x);
        x - self.a * once + self.b * vector.cross(once)
    }

    /// The derivative of the Jacobian, while the vector changes at `rate`, times `rate`.
    fn jacobian_rate(&self, vector: DVec3, rate: DVec3) -> DVec3 {
        let once = vector.cross(rate);
        let change = 2.0 * vector.dot(rate);
        -change * self.a_slope * once
            + change * self.b_slope * vector.cross(once)
            + self.b * rate.cross(once)
    }
}

/// Angular velocity and acceleration along the body's axes of `exp(vector)`, of which these are the
/// vector's derivatives.
pub(crate) fn angular_from_vector_rates(vector: DVec3, rates: &RotationRates) -> RotationRates {
    let coefficients = Coefficients::new(vector);
    RotationRates {
        first: coefficients.jacobian(vector, rates.first),
        second: coefficients.jacobian(vector, rates.second)
            + coefficients.jacobian_rate(vector, rates.first),
    }
}

/// The derivatives of the rotation vector that give this angular velocity and acceleration along
/// the body's axes.
pub(crate) fn vector_rates_from_angular(vector: DVec3, angular: &RotationRates) -> RotationRates {
    let coefficients = Coefficients::new(vector);
    let first = inverse_jacobian(vector, angular.first);
    let second =
        inverse_jacobian(vector, angular.second - coefficients.jacobian_rate(vector, first));
    RotationRates { first, second }
}

/// The inverse of the right Jacobian [Sola 2018, eq. 144].
fn inverse_jacobian(vector: DVec3, x: DVec3) -> DVec3 {
    let s = vector.length_squared();
    let c = if s < SERIES_BELOW {
        1.0 / 12.0 + s * (1.0 / 720.0 + s * (1.0 / 30_240.0 + s / 1_209_600.0))
    } else {
        let half = 0.5 * s.sqrt();
        let (sin, cos) = libm::sincos(half);
        (1.0 - half * cos / sin) / s
    };
    let once = vector.cross(x);
    x + 0.5 * once + c * vector.cross(once)
}
