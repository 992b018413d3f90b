//! Files of the cache folder: read and written without waiting for whatever stands in their place.

use std::io::Read;
use std::os::unix::fs::OpenOptionsExt;
use std::path::Path;

use surefoot_shared_types::base::whole_file;

use crate::system::signals;

/// The content of a regular file; `None` if there is none. A pipe or a device is not waited for.
pub fn read(path: &Path) -> Option<Vec<u8>> {
    let mut options = std::fs::OpenOptions::new();
    let mut file = options.read(true).custom_flags(libc::O_NONBLOCK).open(path).ok()?;
    if !file.metadata().ok()?.is_file() {
        return None;
    }
    let mut bytes = Vec::new();
    file.read_to_end(&mut bytes).ok()?;
    Some(bytes)
}

/// Writes a file completely or not at all; several processes may do so at once. Makes its folder,
/// and removes anything in its place that is no regular file: a pipe would be written to, and
/// nobody reads it.
///
/// # Errors
/// The reason, without the path.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let failed = |error: std::io::Error| error.to_string();
    std::fs::create_dir_all(folder).map_err(failed)?;
    let _deferral = signals::defer();
    if path.symlink_metadata().is_ok_and(|there| !there.is_file()) {
        std::fs::remove_file(path).map_err(failed)?;
    }
    whole_file::write(path, bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_pipe_is_neither_read_nor_written_to() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("inner/file");
        assert_eq!(read(&path), None);
        write(&path, b"one").unwrap();
        assert_eq!(read(&path).as_deref(), Some(&b"one"[..]));
        std::fs::remove_file(&path).unwrap();
        assert!(std::process::Command::new("mkfifo").arg(&path).status().unwrap().success());
        assert_eq!(read(&path), None);
        write(&path, b"two").unwrap();
        assert_eq!(read(&path).as_deref(), Some(&b"two"[..]));
    }

    #[test]
    fn a_link_is_replaced_and_its_target_stays() {
        let folder = tempfile::tempdir().unwrap();
        let [path, target] = ["link", "target"].map(|name| folder.path().join(name));
        std::fs::write(&target, "mine").unwrap();
        std::os::unix::fs::symlink(&target, &path).unwrap();
        write(&path, b"new").unwrap();
        assert_eq!(std::fs::read(&target).unwrap(), b"mine");
        assert_eq!(read(&path).as_deref(), Some(&b"new"[..]));
    }
}
