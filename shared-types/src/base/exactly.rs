//! Arrays of text files of exactly as many values as belong there.

use serde::de::Error;
use serde::{Deserialize, Deserializer};

/// An array of exactly `N` values. The reader of TOML takes a longer one for `[T; N]`, and leaves
/// the rest out.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Exactly<T, const N: usize>(pub(crate) [T; N]);

impl<T: Default + Copy, const N: usize> Default for Exactly<T, N> {
    fn default() -> Self {
        Self([T::default(); N])
    }
}

impl<'de, T: Deserialize<'de>, const N: usize> Deserialize<'de> for Exactly<T, N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let values = Vec::<T>::deserialize(deserializer)?;
        let count = values.len();
        let wrong = |_| D::Error::custom(format!("has {count} values where {N} belong"));
        values.try_into().map(Self).map_err(wrong)
    }
}
