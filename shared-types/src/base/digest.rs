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
        self.chain_pieces(&[bytes])
    }

    /// As [`Self::chain`], of the concatenation of `pieces`.
    pub fn chain_pieces(&self, pieces: &[&[u8]]) -> Self {
        let mut hasher = Sha256::new();
        hasher.update((self.0.len() as u64).to_le_bytes());
        hasher.update(self.0);
        let length: usize = pieces.iter().map(|piece| piece.len()).sum();
        hasher.update((length as u64).to_le_bytes());
        pieces.iter().for_each(|piece| hasher.update(piece));
        Self(hasher.finalize().into())
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
