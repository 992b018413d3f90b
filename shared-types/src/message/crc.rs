//! Messages that hold the CRC of their bytes.

use crate::message::layout::Layout;

/// A message that holds the CRC-32 (IEEE) of its bytes, in which the CRC field counts as zero.
pub trait WithCrc: Layout {
    /// Offset of the CRC field, bytes.
    const CRC_AT: usize;

    /// The CRC field.
    fn crc_mut(&mut self) -> &mut u32;

    /// The CRC of the message's bytes.
    fn computed_crc(&self) -> u32 {
        let bytes = bytemuck::bytes_of(self);
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(&bytes[..Self::CRC_AT]);
        hasher.update(&[0; 4]);
        hasher.update(&bytes[Self::CRC_AT + 4..]);
        hasher.finalize()
    }

    /// Writes the CRC of the message's bytes: the last change before the message is sent.
    fn write_crc(&mut self) {
        *self.crc_mut() = self.computed_crc();
    }

    /// Whether the CRC field holds the CRC of the message's bytes. No field is valid before this is
    /// checked.
    fn crc_matches(&self) -> bool {
        let stored = bytemuck::pod_read_unaligned::<u32>(
            &bytemuck::bytes_of(self)[Self::CRC_AT..Self::CRC_AT + 4],
        );
        stored == self.computed_crc()
    }
}
