//! Lemma 4, theorem 3 and equation 5.14: the probability that w-RPG fails [Grey 5.6, 5.7.1].

use std::f64::consts::PI;

use crate::theory::erosion::Cylinder;
use crate::theory::mode_sampling::ModeSampling;
use crate::theory::route_sampling::RouteSampling;

/// Equation 5.10: the probability that a process fails, or that one which needs it fails, where the
/// first fails with probability `first`, and the second with `second` after the first succeeded.
pub fn dependent_failure(first: f64, second: f64) -> f64 {
    first + (1.0 - first) * second
}

/// The samples of both stages.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Samples {
    /// N_P: accepted samples of C_N.
    pub route: f64,
    /// N_sigma: placements of each foot.
    pub placements: f64,
}

/// Both stages of w-RPG, for one solution.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Overall {
    /// Stage P.
    pub route: RouteSampling,
    /// Mode sampling.
    pub modes: ModeSampling,
}

impl Overall {
    /// Lemma 4 over equations 5.9 and 5.2: the sum of both bounds.
    pub fn failure_bound(&self, samples: Samples) -> f64 {
        self.route.failure_bound(samples.route) + self.modes.failure_bound(samples.placements)
    }

    /// Equation 5.13: the greater bound with one exponent.
    pub fn exponential_bound(&self, samples: Samples) -> f64 {
        let exponent = (self.route.sample_probability() * samples.route)
            .min(self.modes.sample_probability() * samples.placements);
        (self.route.length / self.route.ball_radius + self.modes.modes) * libm::exp(-exponent)
    }
}

/// Equation 5.14 as printed: mode sampling fails at most with this probability, for discs of radius
/// `disc_radius` (m) along a solution of length `length` (m). It holds where 4 pi L rho is no less
/// than the area of the discs: see [`disc_union`](crate::theory::disc_union).
pub fn mode_failure_bound_printed(
    modes: f64,
    cylinder: Cylinder,
    (length, disc_radius): (f64, f64),
    samples: f64,
) -> f64 {
    let area = 4.0 * length * PI * disc_radius;
    ModeSampling { modes, cylinder, area }.failure_bound(samples)
}
