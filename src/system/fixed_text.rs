//! Text of bounded length, made and written without the heap and without locks: for signal handlers
//! and for a process that gets no more memory.

use std::fmt::{self, Write};

/// Text of at most `N` bytes; more is cut off.
#[derive(Debug)]
pub(crate) struct FixedText<const N: usize> {
    bytes: [u8; N],
    len: usize,
}

impl<const N: usize> Default for FixedText<N> {
    fn default() -> Self {
        Self { bytes: [0; N], len: 0 }
    }
}

impl<const N: usize> Write for FixedText<N> {
    fn write_str(&mut self, text: &str) -> fmt::Result {
        let fitting = text.len().min(N - self.len);
        self.bytes[self.len..self.len + fitting].copy_from_slice(&text.as_bytes()[..fitting]);
        self.len += fitting;
        Ok(())
    }
}

impl<const N: usize> FixedText<N> {
    /// Appends text.
    pub(crate) fn push(&mut self, text: fmt::Arguments<'_>) {
        // It cannot fail: text that does not fit is cut off.
        let _ = self.write_fmt(text);
    }

    /// Writes the text to a descriptor of this process.
    pub(crate) fn write_to(&self, descriptor: libc::c_int) {
        // SAFETY: the bytes outlive the call. A failure loses the text, which nothing can help.
        unsafe { libc::write(descriptor, self.bytes.as_ptr().cast(), self.len) };
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_does_not_fit_is_cut_off() {
        let mut text = FixedText::<8>::default();
        text.push(format_args!("{} and {}", 12, "much more"));
        assert_eq!(&text.bytes[..text.len], b"12 and m");
    }
}
