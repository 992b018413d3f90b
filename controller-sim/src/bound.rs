//! The comparison behind every verdict: what is not a number is never within a limit.

/// Whether `value` is at most `limit`; false if either is not a number.
pub(crate) fn within(value: f64, limit: f64) -> bool {
    value <= limit
}
