//! Comparisons with limits. A comparison with NaN is false, so that NaN never passes a check.

/// Whether `value` is at most `limit`; false if either is not a number.
pub(crate) fn is_at_most(value: f64, limit: f64) -> bool {
    value <= limit
}

/// Whether `value` is less than `limit`; false if either is not a number.
pub(crate) fn is_below(value: f64, limit: f64) -> bool {
    value < limit
}

/// The largest of some numbers that are not negative, 0 for none; NaN if one of them is NaN, unlike
/// `f64::max`, which ignores it.
pub(crate) fn largest(values: impl IntoIterator<Item = f64>) -> f64 {
    let larger = |largest: f64, value: f64| {
        if largest.is_nan() || value <= largest { largest } else { value }
    };
    values.into_iter().fold(0.0, larger)
}

/// The smallest of some numbers, infinity for none; NaN if one of them is NaN.
pub(crate) fn smallest(values: impl IntoIterator<Item = f64>) -> f64 {
    let smaller = |smallest: f64, value: f64| {
        if smallest.is_nan() || value >= smallest { smallest } else { value }
    };
    values.into_iter().fold(f64::INFINITY, smaller)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_largest_of_numbers_with_nan_is_nan() {
        assert_eq!(largest([]), 0.0);
        assert_eq!(largest([1.0, 3.0, 2.0]), 3.0);
        for numbers in [[f64::NAN, 3.0, 2.0], [1.0, f64::NAN, 2.0], [1.0, 3.0, f64::NAN]] {
            assert!(largest(numbers).is_nan(), "{numbers:?}");
        }
    }

    #[test]
    fn the_smallest_of_numbers_with_nan_is_nan() {
        assert_eq!(smallest([]), f64::INFINITY);
        assert_eq!(smallest([2.0, -1.0, 3.0]), -1.0);
        for numbers in [[f64::NAN, 3.0, 2.0], [1.0, f64::NAN, 2.0], [1.0, 3.0, f64::NAN]] {
            assert!(smallest(numbers).is_nan(), "{numbers:?}");
        }
    }

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
