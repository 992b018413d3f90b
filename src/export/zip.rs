//! ZIP archives without compression, as `numpy.savez` writes them. Equal content gives equal bytes:
//! no time stands in them.

/// Version 2.0 of the format, which extracting a plain file needs.
const VERSION: u16 = 20;
/// 1980-01-01, the earliest date.
const DATE: u16 = 0x21;
/// Signatures of a file's header, of its entry in the directory, and of the directory's end.
const LOCAL: u32 = 0x0403_4b50;
const ENTRY: u32 = 0x0201_4b50;
const END: u32 = 0x0605_4b50;

/// An archive in the making.
#[derive(Debug, Default)]
pub struct Archive {
    bytes: Vec<u8>,
    directory: Vec<u8>,
    files: u16,
}

impl Archive {
    /// Adds a file.
    ///
    /// # Errors
    /// The archive has no 4 GiB or 65535 files left: it would need ZIP64.
    pub fn add(&mut self, name: &str, content: &[u8]) -> Result<(), String> {
        let too_large = || "it exceeds 4 GiB or 65535 files; lower the rate".to_owned();
        let at = u32::try_from(self.bytes.len()).map_err(|_| too_large())?;
        let size = u32::try_from(content.len()).map_err(|_| too_large())?;
        let name_size = u16::try_from(name.len()).map_err(|_| too_large())?;
        self.files = self.files.checked_add(1).ok_or_else(too_large)?;
        let mut common = Vec::new();
        for number in [VERSION, 0, 0, 0, DATE] {
            common.extend(number.to_le_bytes());
        }
        for number in [crc32fast::hash(content), size, size] {
            common.extend(number.to_le_bytes());
        }
        // The length of the name, and that of the extra field.
        common.extend(name_size.to_le_bytes());
        common.extend(0_u16.to_le_bytes());
        self.bytes.extend(LOCAL.to_le_bytes());
        self.bytes.extend(&common);
        self.bytes.extend(name.as_bytes());
        self.bytes.extend(content);
        self.directory.extend(ENTRY.to_le_bytes());
        self.directory.extend(VERSION.to_le_bytes());
        self.directory.extend(&common);
        // Comment, disk and attributes: none.
        self.directory.extend([0_u8; 10]);
        self.directory.extend(at.to_le_bytes());
        self.directory.extend(name.as_bytes());
        Ok(())
    }

    /// The archive.
    ///
    /// # Errors
    /// As [`Self::add`].
    pub fn finish(mut self) -> Result<Vec<u8>, String> {
        let too_large = |_| "it exceeds 4 GiB; lower the rate".to_owned();
        let at = u32::try_from(self.bytes.len()).map_err(too_large)?;
        let size = u32::try_from(self.directory.len()).map_err(too_large)?;
        self.bytes.append(&mut self.directory);
        self.bytes.extend(END.to_le_bytes());
        for number in [0, 0, self.files, self.files] {
            self.bytes.extend(number.to_le_bytes());
        }
        for number in [size, at] {
            self.bytes.extend(number.to_le_bytes());
        }
        // No comment.
        self.bytes.extend([0_u8; 2]);
        Ok(self.bytes)
    }
}
