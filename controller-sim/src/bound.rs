//! The comparisons behind every verdict: what is not a number is never within a limit.

/// Whether `value` is at most `limit`; false if either is not a number.
pub(crate) fn within(value: f64, limit: f64) -> bool {
    value <= limit
}

/// Whether `value` is less than `limit`; false if either is not a number.
pub(crate) fn below(value: f64, limit: f64) -> bool {
    value < limit
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_a_number_is_never_within_a_limit() {
        assert!(within(1.0, 1.0) && !below(1.0, 1.0) && below(0.0, 1.0) && !within(2.0, 1.0));
        assert!(within(f64::NEG_INFINITY, 1.0) && !within(f64::INFINITY, 1.0));
        for (value, limit) in [(f64::NAN, 1.0), (1.0, f64::NAN), (f64::NAN, f64::NAN)] {
            assert!(!within(value, limit) && !below(value, limit), "{value} {limit}");
        }
    }
}
