//! Seeded draws: each a function of the seed and of what it is for, so that they come out the same
//! however often a controller is started again.

/// 64 uniform bits for the thing that `keys` name.
pub fn bits(seed: u64, keys: &[u64]) -> u64 {
    keys.iter().fold(mix(seed), |state, &key| mix(state ^ mix(key)))
}

/// Uniform in `0..1`.
pub fn unit(seed: u64, keys: &[u64]) -> f64 {
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
    fn draws_are_even_and_of_one_mind() {
        let mut bins = [0; 10];
        for index in 0..10_000 {
            bins[(10.0 * unit(3, &[index, 1])) as usize] += 1;
        }
        assert!(bins.iter().all(|count| (880..1120).contains(count)), "{bins:?}");
        assert_eq!(bits(3, &[1, 2]), bits(3, &[1, 2]));
        assert_ne!(bits(3, &[1, 2]), bits(3, &[2, 1]));
        assert_ne!(bits(3, &[1, 2]), bits(4, &[1, 2]));
    }
}
