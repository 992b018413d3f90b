//! NumPy's array files, version 1.0: a header that describes the array, then its numbers.

/// The header's length is a multiple of this, bytes.
const ALIGNMENT: usize = 64;
/// Magic number, version and length of the header, bytes.
const PREAMBLE: usize = 10;

/// An array file of 64-bit floats.
pub fn floats(shape: &[usize], numbers: &[f64]) -> Vec<u8> {
    file("<f8", shape, numbers.iter().flat_map(|number| number.to_le_bytes()))
}

/// An array file of Boolean values.
pub fn booleans(shape: &[usize], values: &[bool]) -> Vec<u8> {
    file("|b1", shape, values.iter().map(|&value| u8::from(value)))
}

/// An array file of texts. `shape` is empty for a single one.
pub fn texts(shape: &[usize], texts: &[&str]) -> Vec<u8> {
    let longest = texts.iter().map(|text| text.chars().count()).max().unwrap_or(0).max(1);
    let padded = texts
        .iter()
        .flat_map(|text| text.chars().map(u32::from).chain(std::iter::repeat(0)).take(longest));
    file(&format!("<U{longest}"), shape, padded.flat_map(u32::to_le_bytes))
}

fn file(kind: &str, shape: &[usize], data: impl Iterator<Item = u8>) -> Vec<u8> {
    let sizes: String = shape.iter().map(|size| format!("{size},")).collect();
    let text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': ({sizes}), }}");
    let length = (PREAMBLE + text.len() + 1).next_multiple_of(ALIGNMENT) - PREAMBLE;
    let mut bytes = b"\x93NUMPY\x01\x00".to_vec();
    bytes.extend((length as u16).to_le_bytes());
    bytes.extend(format!("{text:<width$}\n", width = length - 1).into_bytes());
    bytes.extend(data);
    bytes
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_header_describes_the_array() {
        let bytes = floats(&[2, 3], &[1.0, 2.0, 3.0, 4.0, 5.0, 6.5]);
        assert_eq!(&bytes[..8], b"\x93NUMPY\x01\x00");
        let length = usize::from(u16::from_le_bytes([bytes[8], bytes[9]]));
        assert_eq!((length + 10) % 64, 0);
        let header = std::str::from_utf8(&bytes[10..10 + length]).unwrap();
        assert!(header.ends_with('\n') && header.contains("'shape': (2,3,)"), "{header}");
        assert_eq!(&bytes[10 + length + 40..], &6.5_f64.to_le_bytes());
    }

    #[test]
    fn texts_are_padded_to_the_longest() {
        let bytes = texts(&[2], &["ab", "c"]);
        let data = &bytes[bytes.len() - 16..];
        assert_eq!(data, b"a\0\0\0b\0\0\0c\0\0\0\0\0\0\0");
        assert!(String::from_utf8_lossy(&bytes[..64]).contains("'<U2'"));
    }
}
