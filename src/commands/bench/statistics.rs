//! The statistics of measured values.

/// Summary statistics of some values; `None` if there are none.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Summary {
    /// Arithmetic mean.
    pub mean: f64,
    /// Standard deviation of the sample (divided by n - 1); 0 for a single value.
    pub std: f64,
    /// The median.
    pub p50: f64,
    /// The value that 95 % do not exceed.
    pub p95: f64,
    /// The value that 99 % do not exceed.
    pub p99: f64,
    /// The greatest value.
    pub max: f64,
}

impl Summary {
    /// Summarises some values.
    pub fn of(values: &[f64]) -> Option<Self> {
        let mut sorted = values.to_vec();
        sorted.sort_by(f64::total_cmp);
        let mean = mean(&sorted)?;
        let squares: f64 = sorted.iter().map(|value| (value - mean) * (value - mean)).sum();
        let std = libm::sqrt(squares / sorted.len().saturating_sub(1).max(1) as f64);
        let at = |share| quantile(&sorted, share);
        Some(Self { mean, std, p50: at(0.5)?, p95: at(0.95)?, p99: at(0.99)?, max: at(1.0)? })
    }
}

/// The arithmetic mean.
pub fn mean(values: &[f64]) -> Option<f64> {
    (!values.is_empty()).then(|| values.iter().sum::<f64>() / values.len() as f64)
}

/// The least of the ascending values that a share of them does not exceed (nearest rank).
pub fn quantile(sorted: &[f64], share: f64) -> Option<f64> {
    let rank = libm::ceil(share * sorted.len() as f64) as usize;
    sorted.get(rank.clamp(1, sorted.len().max(1)) - 1).copied()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_summary_is_that_of_the_textbook() {
        let summary = Summary::of(&[4.0, 2.0, 4.0, 5.0, 5.0, 9.0, 7.0, 4.0]).unwrap();
        assert_eq!((summary.mean, summary.p50, summary.p95, summary.max), (5.0, 4.0, 9.0, 9.0));
        assert!((summary.std - libm::sqrt(32.0 / 7.0)).abs() < 1e-12);
    }

    #[test]
    fn quantiles_are_nearest_ranks() {
        let hundred: Vec<f64> = (1..=100).map(f64::from).collect();
        assert_eq!(quantile(&hundred, 0.5), Some(50.0));
        assert_eq!(quantile(&hundred, 0.95), Some(95.0));
        assert_eq!(quantile(&hundred, 0.99), Some(99.0));
        assert_eq!(quantile(&hundred, 1.0), Some(100.0));
        assert_eq!(quantile(&hundred, 0.0), Some(1.0));
    }

    #[test]
    fn one_value_is_enough_and_none_is_not() {
        let one = Summary::of(&[3.0]).unwrap();
        assert_eq!((one.mean, one.std, one.p50, one.p99, one.max), (3.0, 0.0, 3.0, 3.0, 3.0));
        assert_eq!(Summary::of(&[]), None);
    }
}
