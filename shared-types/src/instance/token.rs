//! Random tokens in names that other users can neither guess nor create beforehand.

use std::fmt;

use crate::instance::sender::random_id;

/// Hexadecimal digits of a token.
const DIGITS: usize = 16;

/// A random token.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Token(u64);

impl Token {
    /// A new token.
    pub(crate) fn random() -> Self {
        Self(random_id())
    }

    /// The token in `text`, if `text` is one and nothing else.
    pub(crate) fn parse(text: &str) -> Option<Self> {
        let is_digit = |byte: u8| matches!(byte, b'0'..=b'9' | b'a'..=b'f');
        let is_token = text.len() == DIGITS && text.bytes().all(is_digit);
        is_token.then(|| u64::from_str_radix(text, 16).map(Self).ok()).flatten()
    }

    /// Whether `text` is a token.
    pub(crate) fn is_token(text: &str) -> bool {
        Self::parse(text).is_some()
    }
}

impl fmt::Display for Token {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(formatter, "{:0DIGITS$x}", self.0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tokens_differ_and_are_read_back() {
        let token = Token::random();
        assert_eq!(Token::parse(&token.to_string()), Some(token));
        assert_ne!(token, Token::random());
        for wrong in ["", "0", "0123456789ABCDEF", "0123456789abcdef0", "+123456789abcdef"] {
            assert!(!Token::is_token(wrong), "{wrong}");
        }
    }
}
