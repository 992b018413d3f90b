//! Arrays of a preparation: where each stands, and shared access to it.

use std::marker::PhantomData;
use std::sync::Arc;

use bytemuck::{Pod, Zeroable};

use crate::preparation::error::PreparationError;

/// An array of a preparation: the index of its first word from the begin of the file, and its
/// number of words.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Pod, Zeroable)]
#[repr(C)]
pub struct Span {
    /// The first word.
    pub first: u64,
    /// Number of words.
    pub len: u64,
}

/// An array of plain data within the words of a preparation, which it shares.
#[derive(Debug, Clone)]
pub(crate) struct SharedArray<T> {
    words: Arc<[u64]>,
    first: usize,
    len: usize,
    items: PhantomData<T>,
}

impl<T: Pod> SharedArray<T> {
    /// The array at a span of `words`.
    ///
    /// # Errors
    /// The span exceeds the words, or does not hold whole items.
    pub fn new(words: &Arc<[u64]>, span: Span) -> Result<Self, PreparationError> {
        let [first, len] = [span.first, span.len].map(usize::try_from);
        let (Ok(first), Ok(len)) = (first, len) else { return Err(PreparationError::Damaged) };
        let end = first.checked_add(len).ok_or(PreparationError::Damaged)?;
        let part = words.get(first..end).ok_or(PreparationError::Damaged)?;
        bytemuck::try_cast_slice::<u64, T>(part).map_err(|_| PreparationError::Damaged)?;
        Ok(Self { words: words.clone(), first, len, items: PhantomData })
    }

    /// All items.
    pub fn items(&self) -> &[T] {
        bytemuck::cast_slice(&self.words[self.first..self.first + self.len])
    }
}

impl SharedArray<u64> {
    /// Bit `index` of an array of bits, the lowest bit of each word first.
    ///
    /// # Panics
    /// The index exceeds the preparation.
    pub fn bit(&self, index: usize) -> bool {
        self.words[self.first + index / 64] >> (index % 64) & 1 == 1
    }
}
