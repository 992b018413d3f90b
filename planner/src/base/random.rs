//! Counter-based random streams [Salmon 2011]. A number is a function of the seed, the stream and
//! its index, so that a further number in one place changes none elsewhere, and the order of
//! threads does not matter.

/// The streams in use. A stream is divided further by object and attempt.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
#[repr(u64)]
pub enum Stream {
    /// Foot placement sampling.
    FootPlacement = 1,
    /// Transition configurations.
    Transition = 2,
    /// Single-mode trees.
    SingleMode = 3,
    /// Random configurations at preparation.
    Preparation = 4,
    /// Root poses of stage P.
    Possibility = 5,
    /// Shortcuts.
    Shortcut = 6,
    /// Samples of the methods that the planner is compared with.
    Method = 7,
    /// Footholds anywhere about a route.
    UniformFoothold = 8,
    /// Which of many neighbours a foothold is connected with.
    Connection = 9,
    /// Other walks that are made from a plan.
    Improvement = 10,
}

/// The generator of one object and attempt. It is cheap to make.
#[derive(Debug, Clone)]
pub struct Random {
    key: u64,
    counter: u64,
}

impl Random {
    /// The numbers of `stream` for object `object` at attempt `attempt`.
    pub fn new(seed: u64, stream: Stream, object: u64, attempt: u64) -> Self {
        let key = [stream as u64, object, attempt]
            .into_iter()
            .fold(mix(seed), |key, word| mix(key ^ mix(word)));
        Self { key, counter: 0 }
    }

    /// 64 uniformly distributed bits.
    pub fn bits(&mut self) -> u64 {
        self.counter += 1;
        mix(self.key.wrapping_add(self.counter.wrapping_mul(GOLDEN)))
    }

    /// A number uniformly distributed in `lower..upper`.
    pub fn uniform(&mut self, lower: f64, upper: f64) -> f64 {
        let unit = (self.bits() >> 11) as f64 * (1.0 / (1u64 << 53) as f64);
        lower + unit * (upper - lower)
    }

    /// An integer uniformly distributed in `0..count`; `count` must be positive.
    pub fn below(&mut self, count: usize) -> usize {
        ((u128::from(self.bits()) * count as u128) >> 64) as usize
    }
}

/// 2^64 divided by the golden ratio, the increment of SplitMix64.
const GOLDEN: u64 = 0x9E37_79B9_7F4A_7C15;

/// SplitMix64's finaliser (Steele, Lea, Flood 2014).
fn mix(word: u64) -> u64 {
    let word = word.wrapping_add(GOLDEN);
    let word = (word ^ (word >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let word = (word ^ (word >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    word ^ (word >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_keys_give_equal_numbers() {
        let bits = |object, attempt| Random::new(7, Stream::Transition, object, attempt).bits();
        assert_eq!(bits(3, 4), bits(3, 4));
        assert_ne!(bits(3, 4), bits(4, 3));
        assert_ne!(bits(3, 4), Random::new(8, Stream::Transition, 3, 4).bits());
        assert_ne!(bits(3, 4), Random::new(7, Stream::SingleMode, 3, 4).bits());
    }

    #[test]
    fn uniform_numbers_fill_their_range_evenly() {
        let mut random = Random::new(1, Stream::FootPlacement, 0, 0);
        let mut bins = [0u32; 10];
        for _ in 0..100_000 {
            bins[(random.uniform(0.0, 10.0)) as usize] += 1;
        }
        assert!(bins.iter().all(|&n| (9_500..10_500).contains(&n)), "{bins:?}");
    }

    #[test]
    fn below_reaches_every_value_and_no_other() {
        let mut random = Random::new(1, Stream::FootPlacement, 0, 1);
        let mut seen = [false; 7];
        for _ in 0..1_000 {
            seen[random.below(7)] = true;
        }
        assert_eq!(seen, [true; 7]);
    }
}
