//! Uniform cubic B-splines: between two keys the curve is a convex combination of the two and their
//! neighbours, with two continuous derivatives.

/// The weights of the keys before, at the beginning, at the end and after an interval, at its
/// fraction `t`.
pub(crate) fn weights(t: f64) -> [f64; 4] {
    let s = 1.0 - t;
    let outer = [s * s * s / 6.0, t * t * t / 6.0];
    [
        outer[0],
        (4.0 - 6.0 * t * t + 3.0 * t * t * t) / 6.0,
        (4.0 - 6.0 * s * s + 3.0 * s * s * s) / 6.0,
        outer[1],
    ]
}

/// The weights where the curve begins with the interval (`starts`) or ends with it (`ends`). It
/// passes the key there: the key beyond is the mirror image of the one on the other side, so the
/// second derivative is zero.
pub(crate) fn end_weights(t: f64, starts: bool, ends: bool) -> [f64; 4] {
    let [before, mut begin, mut end, after] = weights(t);
    let mut outer = [before, after];
    if starts {
        begin += 2.0 * before;
        end -= before;
        outer[0] = 0.0;
    }
    if ends {
        end += 2.0 * after;
        begin -= after;
        outer[1] = 0.0;
    }
    [outer[0], begin, end, outer[1]]
}

/// The keys before, at the beginning, at the end and after an interval; where there is none, the
/// one at that end.
pub(crate) fn around<T>(keys: &[T], interval: usize) -> [&T; 4] {
    let key = |index: usize| &keys[index.min(keys.len() - 1)];
    [key(interval.saturating_sub(1)), key(interval), key(interval + 1), key(interval + 2)]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn weights_are_convex_and_join_with_two_derivatives() {
        for index in 0..=20 {
            let w = weights(f64::from(index) / 20.0);
            assert!((w.iter().sum::<f64>() - 1.0).abs() < 1e-15 && w.iter().all(|w| *w >= 0.0));
        }
        let (h, keys) = (1e-3, [0.3, -1.0, 2.0, 0.7, 5.0]);
        let at = |t: f64| {
            let (first, t) = if t < 0.0 { (0, t + 1.0) } else { (1, t) };
            weights(t).iter().zip(&keys[first..]).map(|(w, key)| w * key).sum::<f64>()
        };
        let slope = |t: f64| (at(t + h) - at(t)) / h;
        let bend = |t: f64| (slope(t + h) - slope(t)) / h;
        assert!((slope(-h) - slope(0.0)).abs() < 0.02);
        assert!((bend(-2.0 * h) - bend(0.0)).abs() < 0.05);
    }

    #[test]
    fn a_curve_passes_the_keys_at_its_ends() {
        assert_eq!(end_weights(0.0, true, false)[1], 1.0);
        assert_eq!(end_weights(1.0, true, true)[2], 1.0);
        let middle = end_weights(0.5, true, true);
        assert!((middle[1] - 0.5).abs() < 1e-15 && (middle[2] - 0.5).abs() < 1e-15);
    }
}
