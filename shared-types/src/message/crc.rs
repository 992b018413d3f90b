//! Messages that carry the CRC of their own bytes.

use crate::message::layout::Layout;

/// A message with a CRC-32 (IEEE) over all its bytes, the field of the CRC counted as zero.
pub trait WithCrc: Layout {
    /// Where the CRC lies, bytes from the message's start.
    const CRC_AT: usize;

    /// The field of the CRC.
    fn crc_mut(&mut self) -> &mut u32;

    /// The CRC that belongs to the message's bytes.
    fn computed_crc(&self) -> u32 {
        let bytes = bytemuck::bytes_of(self);
        let mut hasher = crc32fast::Hasher::new();
        hasher.update(&bytes[..Self::CRC_AT]);
        hasher.update(&[0; 4]);
        hasher.update(&bytes[Self::CRC_AT + 4..]);
        hasher.finalize()
    }

    /// Writes the CRC that belongs to the message's bytes. The last thing done to a message before
    /// it is sent.
    fn write_crc(&mut self) {
        *self.crc_mut() = self.computed_crc();
    }

    /// Whether the message carries the CRC of its bytes. No field is valid before
    /// this is checked.
    fn crc_matches(&self) -> bool {
        let carried = bytemuck::pod_read_unaligned::<u32>(
            &bytemuck::bytes_of(self)[Self::CRC_AT..Self::CRC_AT + 4],
        );
        carried == self.computed_crc()
    }
}
