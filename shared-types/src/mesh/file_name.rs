//! File names as programs on other systems write them: backslashes, and characters as `%20`.

use std::path::{Path, PathBuf};

/// The file that a name means below `folder`: as it stands, else without percent codes, else with
/// its backslashes turned, whichever exists first. The name as it stands where none exists.
pub(crate) fn find_file(folder: &Path, name: &str) -> PathBuf {
    let readings = readings(name).into_iter().map(|name| folder.join(name));
    readings.into_iter().find(|path| path.is_file()).unwrap_or_else(|| folder.join(name))
}

/// What a name may mean, the literal reading first.
pub(crate) fn readings(name: &str) -> Vec<String> {
    let mut readings = vec![name.to_owned()];
    let decoded = percent_decoded(name);
    for reading in [decoded.clone(), name.replace('\\', "/"), decoded.replace('\\', "/")] {
        if !readings.contains(&reading) {
            readings.push(reading);
        }
    }
    readings
}

/// A name with its percent codes replaced; as it is where they spell no UTF-8.
pub(crate) fn percent_decoded(name: &str) -> String {
    let bytes = name.as_bytes();
    let mut decoded = Vec::with_capacity(bytes.len());
    let mut at = 0;
    while at < bytes.len() {
        let code = name.get(at + 1..at + 3).filter(|_| bytes[at] == b'%');
        match code.and_then(|code| u8::from_str_radix(code, 16).ok()) {
            Some(byte) => {
                decoded.push(byte);
                at += 3;
            }
            None => {
                decoded.push(bytes[at]);
                at += 1;
            }
        }
    }
    String::from_utf8(decoded).unwrap_or_else(|_| name.to_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_name_has_its_readings() {
        assert_eq!(readings("a.stl"), ["a.stl"]);
        assert_eq!(
            readings("a%20b\\c.stl"),
            ["a%20b\\c.stl", "a b\\c.stl", "a%20b/c.stl", "a b/c.stl"]
        );
        assert_eq!(percent_decoded("50%.stl"), "50%.stl");
        assert_eq!(percent_decoded("%C3%A9%ff%2"), "%C3%A9%ff%2");
        assert_eq!(percent_decoded("%C3%A9"), "é");
    }
}
