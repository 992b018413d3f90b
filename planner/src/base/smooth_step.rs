//! A smooth step.

/// The quintic step from 0 at `t <= 0` to 1 at `t >= 1`; its first two derivatives are continuous.
pub(crate) fn smooth_step(t: f64) -> f64 {
    let t = t.clamp(0.0, 1.0);
    t * t * t * (10.0 + t * (6.0 * t - 15.0))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_step_rests_at_both_ends() {
        assert_eq!([smooth_step(-0.1), smooth_step(0.5), smooth_step(1.2)], [0.0, 0.5, 1.0]);
        assert!(smooth_step(1e-3) < 1e-7);
    }
}
