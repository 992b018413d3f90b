//! Content digests: SHA-256 of byte strings, and the hash chain of a chunk stream.

use sha2::{Digest as _, Sha256};

/// A SHA-256 digest, which identifies a content.
#[derive(
    Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Default, bytemuck::Pod, bytemuck::Zeroable,
)]
#[repr(transparent)]
pub struct Digest(pub [u8; 32]);

impl Digest {
    /// The digest of byte strings, each preceded by its length, so that boundaries count.
    pub fn of(parts: &[&[u8]]) -> Self {
        let mut hasher = Sha256::new();
        for part in parts {
            hasher.update((part.len() as u64).to_le_bytes());
            hasher.update(part);
        }
        Self(hasher.finalize().into())
    }

    /// The next link of a hash chain: the digest of `self` followed by `bytes`.
    pub fn chain(&self, bytes: &[u8]) -> Self {
        Self::of(&[&self.0, bytes])
    }

    /// The next link of a hash chain: the digest of `self` followed by what `write` adds, from
    /// which the ends of its parts must follow.
    pub fn chain_parts(&self, write: impl FnOnce(&mut Link)) -> Self {
        let mut link = Link(Sha256::new());
        link.add(&self.0);
        write(&mut link);
        Self(link.0.finalize().into())
    }
}

/// A link of a hash chain, to which bytes are added.
pub struct Link(Sha256);

impl Link {
    /// Adds the bytes of a value.
    pub fn add<T: bytemuck::NoUninit>(&mut self, values: &[T]) {
        self.0.update(bytemuck::cast_slice::<T, u8>(values));
    }
}

impl std::fmt::Display for Digest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        self.0.iter().try_for_each(|byte| write!(f, "{byte:02x}"))
    }
}

impl std::fmt::Debug for Digest {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{self}")
    }
}
