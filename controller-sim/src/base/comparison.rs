//! Comparisons with limits. A comparison with NaN is false, so that NaN never passes a check.

/// Whether `value` is at most `limit`; false if either is not a number.
pub(crate) fn is_at_most(value: f64, limit: f64) -> bool {
    value <= limit
}

/// Whether `value` is less than `limit`; false if either is not a number.
pub(crate) fn is_below(value: f64, limit: f64) -> bool {
    value < limit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn nan_is_never_within_a_limit() {
        assert!(
            is_at_most(1.0, 1.0)
                && !is_below(1.0, 1.0)
                && is_below(0.0, 1.0)
                && !is_at_most(2.0, 1.0)
        );
        assert!(is_at_most(f64::NEG_INFINITY, 1.0) && !is_at_most(f64::INFINITY, 1.0));
        for (value, limit) in [(f64::NAN, 1.0), (1.0, f64::NAN), (f64::NAN, f64::NAN)] {
            assert!(!is_at_most(value, limit) && !is_below(value, limit), "{value} {limit}");
        }
    }
}
