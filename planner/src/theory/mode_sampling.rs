//! Theorem 1: the probability that the placements that were sampled hold no sequence of modes,
//! where one exists [Grey 5.4].

use crate::theory::erosion::Cylinder;

/// A sequence of modes, and the area in which placements are sampled.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct ModeSampling {
    /// M: single-support modes of the solution.
    pub modes: f64,
    /// The least of the cylinders in which these modes may be replaced: r_m and its yaw extent.
    pub cylinder: Cylinder,
    /// |F|: the area in which placements are sampled uniformly, m^2. The yaw is uniform in a full
    /// turn.
    pub area: f64,
}

impl ModeSampling {
    /// Equation 5.3: the probability that one sample lies in the least cylinder.
    pub fn sample_probability(&self) -> f64 {
        let Cylinder { radius, yaw_extent } = self.cylinder;
        radius * radius * yaw_extent / (2.0 * self.area)
    }

    /// Equation 5.2: the bound on the probability that `samples` placements of each foot do not
    /// suffice. It presumes that every choice within the cylinders admits transitions and motions
    /// of the body: reachable footholds alone do not imply it.
    pub fn failure_bound(&self, samples: f64) -> f64 {
        self.modes * libm::exp(samples * libm::log1p(-self.sample_probability()))
    }

    /// Equation 5.12, second line: the greater bound in exponential form.
    pub fn exponential_bound(&self, samples: f64) -> f64 {
        self.modes * libm::exp(-samples * self.sample_probability())
    }
}
