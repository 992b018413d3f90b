//! Folders for the instances of one test.

use std::fs::Permissions;
use std::os::unix::fs::PermissionsExt;

/// A new folder in shared memory, closed to other users; removed when dropped.
pub fn private_folder(prefix: &str) -> tempfile::TempDir {
    tempfile::Builder::new()
        .prefix(prefix)
        .permissions(Permissions::from_mode(0o700))
        .tempdir_in("/dev/shm")
        .unwrap()
}
