//! Lemmas 2 and 3 and theorem 2: the probability that the samples of C_N hold no route
//! [Grey 5.5].

use std::f64::consts::PI;

/// Dimensions of the exploration space E.
pub const DIMENSIONS: u32 = 6;

/// The projection of a solution, and the set from which stage P samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RouteSampling {
    /// L: length of the projected solution in the metric of E, m.
    pub length: f64,
    /// Epsilon: radius of the balls along it, one of which needs a sample every epsilon, m.
    pub ball_radius: f64,
    /// |C_N|: volume of the set that is sampled uniformly, m to the power of its dimensions.
    pub volume: f64,
    /// Dimensions of the space.
    pub dimensions: u32,
}

impl RouteSampling {
    /// The probability that one sample lies in one ball.
    pub fn sample_probability(&self) -> f64 {
        ball_volume(self.dimensions, self.ball_radius) / self.volume
    }

    /// Equations 5.4, 5.6, 5.8 and 5.9: the bound on the probability that `samples` samples hold no
    /// route through the balls. The radius decides which equation it is, see [`ball_radius_max`].
    pub fn failure_bound(&self, samples: f64) -> f64 {
        self.length / self.ball_radius
            * libm::exp(samples * libm::log1p(-self.sample_probability()))
    }

    /// Equation 5.12, first line: the greater bound in exponential form.
    pub fn exponential_bound(&self, samples: f64) -> f64 {
        self.length / self.ball_radius * libm::exp(-samples * self.sample_probability())
    }
}

/// Theorem 2: the largest radius (m) of the balls for a path whose distance from the complement of
/// C_N is at least `clearance` (m, R), and for discs of radius `disc_radius` (m, rho): min(R / 2,
/// rho / 4).
pub fn ball_radius_max(clearance: f64, disc_radius: f64) -> f64 {
    (0.5 * clearance).min(0.25 * disc_radius)
}

/// Volume of a ball: pi^(d/2) r^d / Gamma(d/2 + 1). In six dimensions pi^3 r^6 / 6.
pub fn ball_volume(dimensions: u32, radius: f64) -> f64 {
    let half = 0.5 * f64::from(dimensions);
    libm::pow(PI, half) * libm::pow(radius, f64::from(dimensions)) / libm::tgamma(half + 1.0)
}
