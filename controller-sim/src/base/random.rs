//! Random numbers as a function of a seed and of keys that name their use, so that a restarted
//! controller gets the same ones.

/// 64 uniform random bits for `keys`.
pub fn bits(seed: u64, keys: &[u64]) -> u64 {
    keys.iter().fold(mix(seed), |state, &key| mix(state ^ mix(key)))
}

/// Uniform in `0..1`.
pub fn uniform(seed: u64, keys: &[u64]) -> f64 {
    (bits(seed, keys) >> 11) as f64 * (1.0 / (1_u64 << 53) as f64)
}

/// The finaliser of `MurmurHash3` (Appleby 2011), after an odd constant so that 0 does not stay 0.
fn mix(word: u64) -> u64 {
    let word = word.wrapping_add(0x2545_f491_4f6c_dd1d);
    let word = (word ^ (word >> 33)).wrapping_mul(0xff51_afd7_ed55_8ccd);
    let word = (word ^ (word >> 33)).wrapping_mul(0xc4ce_b9fe_1a85_ec53);
    word ^ (word >> 33)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn random_numbers_are_uniform_and_reproducible() {
        let mut bins = [0; 10];
        for index in 0..10_000 {
            bins[(10.0 * uniform(3, &[index, 1])) as usize] += 1;
        }
        assert!(bins.iter().all(|count| (880..1120).contains(count)), "{bins:?}");
        assert_eq!(bits(3, &[1, 2]), bits(3, &[1, 2]));
        assert_ne!(bits(3, &[1, 2]), bits(3, &[2, 1]));
        assert_ne!(bits(3, &[1, 2]), bits(4, &[1, 2]));
    }
}
