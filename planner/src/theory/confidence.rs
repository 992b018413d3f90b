//! Confidence limits of a failure rate that was counted (Clopper, Pearson 1934).

/// Halvings of the interval in which a limit lies.
const HALVINGS: u32 = 60;
/// Most terms of the continued fraction; it converges within about the root of its arguments.
const TERMS_MAX: u32 = 4_000;
/// Relative change of the continued fraction at which it has converged.
const CONVERGED: f64 = 1e-13;
/// Smallest magnitude of a partial denominator.
const TINY: f64 = 1e-300;

/// The exact two-sided confidence limits of a probability of which `failures` of `trials` were
/// seen: the true one lies outside with a probability of at most `1 - level`.
///
/// # Panics
/// There are no trials, or more failures than trials.
pub fn clopper_pearson(failures: u64, trials: u64, level: f64) -> [f64; 2] {
    assert!(trials > 0 && failures <= trials, "{failures} of {trials}");
    let tail = 0.5 * (1.0 - level);
    let (count, all) = (failures as f64, trials as f64);
    let lower = match failures {
        0 => 0.0,
        _ => root(|p| regularized_beta(p, count, all - count + 1.0), tail),
    };
    let upper = match failures {
        _ if failures == trials => 1.0,
        _ => root(|p| regularized_beta(p, count + 1.0, all - count), 1.0 - tail),
    };
    [lower, upper]
}

/// The argument in 0..1 at which an increasing function takes a value.
fn root(increasing: impl Fn(f64) -> f64, value: f64) -> f64 {
    let (mut lower, mut upper) = (0.0, 1.0);
    for _ in 0..HALVINGS {
        let middle = 0.5 * (lower + upper);
        if increasing(middle) < value {
            lower = middle;
        } else {
            upper = middle;
        }
    }
    0.5 * (lower + upper)
}

/// The regularized incomplete beta function I_x(a, b): the probability of at least `a` successes
/// in `a + b - 1` trials of probability `x`, for integers.
fn regularized_beta(x: f64, a: f64, b: f64) -> f64 {
    if x <= 0.0 || x >= 1.0 {
        return x.clamp(0.0, 1.0);
    }
    let log_beta = libm::lgamma(a + b) - libm::lgamma(a) - libm::lgamma(b);
    let front = libm::exp(log_beta + a * libm::log(x) + b * libm::log1p(-x));
    if x < (a + 1.0) / (a + b + 2.0) {
        front * fraction(x, a, b) / a
    } else {
        1.0 - front * fraction(1.0 - x, b, a) / b
    }
}

/// The continued fraction of the incomplete beta function (Lentz's algorithm).
fn fraction(x: f64, a: f64, b: f64) -> f64 {
    let guarded = |value: f64| if value.abs() < TINY { TINY } else { value };
    let mut c = 1.0;
    let mut d = 1.0 / guarded(1.0 - (a + b) * x / (a + 1.0));
    let mut value = d;
    for term in 1..=TERMS_MAX {
        let m = f64::from(term);
        let even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
        d = 1.0 / guarded(1.0 + even * d);
        c = guarded(1.0 + even / c);
        value *= d * c;
        let odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
        d = 1.0 / guarded(1.0 + odd * d);
        c = guarded(1.0 + odd / c);
        value *= d * c;
        if (d * c - 1.0).abs() < CONVERGED {
            break;
        }
    }
    value
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn limits_are_those_of_the_published_tables() {
        for (failures, trials, expected) in [
            (0, 10, [0.0, 0.3085]),
            (1, 10, [0.0025, 0.4450]),
            (5, 10, [0.1871, 0.8129]),
            (10, 10, [0.6915, 1.0]),
            (50, 1000, [0.0373, 0.0654]),
        ] {
            let limits = clopper_pearson(failures, trials, 0.95);
            let is_near = limits.iter().zip(expected).all(|(limit, e)| (limit - e).abs() < 1e-4);
            assert!(is_near, "{failures} of {trials}: {limits:?}");
        }
    }

    #[test]
    fn the_tails_beyond_the_limits_are_as_likely_as_stated() {
        let [lower, upper] = clopper_pearson(7, 40, 0.9);
        let at_least = |p: f64, count: u64| -> f64 {
            let choose = |k: u64| (0..k).fold(1.0, |all, i| all * (40 - i) as f64 / (i + 1) as f64);
            let term =
                |k: u64| choose(k) * libm::pow(p, k as f64) * libm::pow(1.0 - p, (40 - k) as f64);
            (count..=40).map(term).sum()
        };
        assert!((at_least(lower, 7) - 0.05).abs() < 1e-9);
        assert!((1.0 - at_least(upper, 8) - 0.05).abs() < 1e-9);
    }
}
