//! Plain CDR, little-endian, as ROS 2 encodes messages: every number is aligned to its size,
//! counted from the end of the four bytes that name the encoding.

/// The encoding's name: CDR, little-endian, no options.
const ENCAPSULATION: [u8; 4] = [0, 1, 0, 0];

/// A message in the making.
#[derive(Debug, Clone)]
pub struct CdrWriter {
    bytes: Vec<u8>,
}

impl Default for CdrWriter {
    fn default() -> Self {
        Self { bytes: ENCAPSULATION.to_vec() }
    }
}

impl CdrWriter {
    /// Appends the bytes of a number after the padding that aligns it.
    pub fn number<const SIZE: usize>(&mut self, little_endian: [u8; SIZE]) {
        let used = self.bytes.len() - ENCAPSULATION.len();
        self.bytes.resize(ENCAPSULATION.len() + used.next_multiple_of(SIZE), 0);
        self.bytes.extend(little_endian);
    }

    /// Appends the length of a sequence.
    ///
    /// # Panics
    /// Where it exceeds 32 bits.
    pub fn length(&mut self, length: usize) {
        let length = u32::try_from(length).expect("a message holds fewer than 2^32 elements");
        self.number(length.to_le_bytes());
    }

    /// Appends a text: its length with the zero byte at its end, then both.
    pub fn text(&mut self, text: &str) {
        self.length(text.len() + 1);
        self.bytes.extend(text.as_bytes());
        self.bytes.push(0);
    }

    /// The encoded message.
    pub fn finish(self) -> Vec<u8> {
        self.bytes
    }
}
