//! Finds and removes segments and service files that a killed process left half made.
//!
//! A process makes a segment in steps: it creates it, sets its size, writes it, and changes its
//! mode from write-only to the final one. iceoryx2 waits without limit for a segment of size 0, and
//! up to 20 s for an unfinished service. The scan of segments does not use the Rust allocator, so
//! it may run beside a process that must not allocate.

use std::ffi::CStr;
use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::Path;
use std::ptr::NonNull;

use crate::base::user::effective_uid;
use crate::instance::tuning::UNFINISHED_MAX;

/// Inode numbers of unfinished segments.
pub(crate) type Unfinished = heapless::Vec<u64, UNFINISHED_MAX>;

/// Mode bits of a segment before it is finished: iceoryx2's `INIT_PERMISSIONS` of segments.
const SEGMENT_MODE_UNFINISHED: u32 = 0o200;
/// Mode bits of a service file before it is finished: iceoryx2's `INIT_PERMISSIONS` of files.
const SERVICE_MODE_UNFINISHED: u32 = 0o600;
/// End of the name of a connection. Running processes make connections without the lock `making`.
const CONNECTION_SUFFIX: &[u8] = b".connection";
/// End of the name of a service file.
const SERVICE_SUFFIX: &str = ".service";
/// The folder of service files in the root.
const SERVICES: &str = "services";

/// Whether a file with this size and mode is an unfinished segment.
pub(crate) fn is_unfinished(size: u64, mode: u32) -> bool {
    size == 0 || mode & 0o777 == SEGMENT_MODE_UNFINISHED
}

/// The unfinished connections whose names begin with `prefix`.
pub(crate) fn connections(prefix: &str) -> Unfinished {
    let mut found = Unfinished::new();
    for_each_unfinished(prefix, |_, name, inode| {
        if name.to_bytes().ends_with(CONNECTION_SUFFIX) {
            // Further ones are found by a later scan.
            let _ = found.push(inode);
        }
    });
    found
}

/// Removes the connections among `known` that are still unfinished.
pub(crate) fn remove_connections(prefix: &str, known: &Unfinished) {
    for_each_unfinished(prefix, |folder, name, inode| {
        if known.contains(&inode) {
            folder.remove(name);
        }
    });
}

/// Removes all unfinished segments except connections, and all unfinished service files. Only the
/// holder of the lock `making` may call it.
pub(crate) fn remove_all_but_connections(prefix: &str, root: &Path) {
    for_each_unfinished(prefix, |folder, name, _| {
        if !name.to_bytes().ends_with(CONNECTION_SUFFIX) {
            folder.remove(name);
        }
    });
    for entry in fs::read_dir(root.join(SERVICES)).into_iter().flatten().flatten() {
        let is_service = entry.file_name().to_string_lossy().ends_with(SERVICE_SUFFIX);
        let is_unfinished = || {
            entry
                .metadata()
                .is_ok_and(|metadata| metadata.mode() & 0o777 == SERVICE_MODE_UNFINISHED)
        };
        if is_service && is_unfinished() {
            // A failure shows when the service is opened.
            let _ = fs::remove_file(entry.path());
        }
    }
}

/// Calls `found` with the folder, the name and the inode of every unfinished segment of this user
/// whose name begins with `prefix`.
fn for_each_unfinished(prefix: &str, mut found: impl FnMut(&Folder, &CStr, u64)) {
    let Some(mut folder) = Folder::open(SHARED_MEMORY) else { return };
    let mut name = [0_u8; NAME_BYTES_MAX];
    while let Some(name) = folder.next_name(&mut name) {
        if !name.to_bytes().starts_with(prefix.as_bytes()) {
            continue;
        }
        if let Some(stat) = folder.stat(name)
            && stat.st_uid == effective_uid()
            && is_unfinished(stat.st_size.unsigned_abs(), stat.st_mode)
        {
            found(&folder, name, stat.st_ino);
        }
    }
}

/// The folder in which Linux shows POSIX shared memory.
const SHARED_MEMORY: &CStr = c"/dev/shm";
/// Longest name of a file with its terminating zero, bytes.
const NAME_BYTES_MAX: usize = 256;

/// An open folder.
struct Folder(NonNull<libc::DIR>);

impl Folder {
    fn open(path: &CStr) -> Option<Self> {
        // SAFETY: the path outlives the call.
        NonNull::new(unsafe { libc::opendir(path.as_ptr()) }).map(Self)
    }

    /// The name of the next entry, copied into `buffer`.
    fn next_name<'a>(&mut self, buffer: &'a mut [u8; NAME_BYTES_MAX]) -> Option<&'a CStr> {
        // SAFETY: the folder is open, and no other thread reads it.
        let entry = NonNull::new(unsafe { libc::readdir(self.0.as_ptr()) })?;
        // SAFETY: the entry is valid until the next call; its name ends with a zero.
        let name = unsafe { CStr::from_ptr((*entry.as_ptr()).d_name.as_ptr()) };
        let bytes = name.to_bytes_with_nul();
        let copy = buffer.get_mut(..bytes.len())?;
        copy.copy_from_slice(bytes);
        CStr::from_bytes_with_nul(copy).ok()
    }

    fn stat(&self, name: &CStr) -> Option<libc::stat> {
        // SAFETY: all-zero bytes are a valid stat.
        let mut stat: libc::stat = unsafe { std::mem::zeroed() };
        // SAFETY: the folder is open, and both pointers outlive the call.
        let result = unsafe {
            let folder = libc::dirfd(self.0.as_ptr());
            libc::fstatat(folder, name.as_ptr(), &mut stat, libc::AT_SYMLINK_NOFOLLOW)
        };
        (result == 0).then_some(stat)
    }

    /// Removes a file. A failure shows when the file is opened.
    fn remove(&self, name: &CStr) {
        // SAFETY: the folder is open, and the name outlives the call.
        unsafe { libc::unlinkat(libc::dirfd(self.0.as_ptr()), name.as_ptr(), 0) };
    }
}

impl Drop for Folder {
    fn drop(&mut self) {
        // SAFETY: the folder is open and not used afterwards.
        unsafe { libc::closedir(self.0.as_ptr()) };
    }
}

#[cfg(test)]
mod tests {
    use std::os::unix::fs::PermissionsExt;

    use super::*;
    use crate::instance::error::SHARED_MEMORY;

    fn segment(name: &str, bytes: &[u8], mode: u32) -> std::path::PathBuf {
        let path = Path::new(SHARED_MEMORY).join(name);
        fs::write(&path, bytes).unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
        path
    }

    #[test]
    fn only_unfinished_files_are_removed() {
        let prefix = format!("sf-unfinished-{}.", std::process::id());
        let of = |name: &str| format!("{prefix}{name}");
        let root = tempfile::tempdir_in(SHARED_MEMORY).unwrap();
        fs::create_dir(root.path().join(SERVICES)).unwrap();
        let service = |name: &str, mode: u32| {
            let path = root.path().join(SERVICES).join(name);
            fs::write(&path, "").unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
            path
        };
        let finished = [segment(&of("a.data"), b"x", 0o600), service("a.service", 0o400)];
        let unfinished = [
            segment(&of("b.dynamic"), b"", 0o600),
            segment(&of("c.dynamic"), b"x", 0o200),
            service("b.service", 0o600),
        ];
        let connection = segment(&of("d.connection"), b"", 0o200);
        remove_all_but_connections(&prefix, root.path());
        assert!(finished.iter().all(|path| path.exists()));
        assert!(unfinished.iter().all(|path| !path.exists()));
        let known = connections(&prefix);
        assert_eq!(known.len(), 1);
        assert!(connection.exists());
        remove_connections(&prefix, &known);
        assert!(!connection.exists());
        fs::remove_file(&finished[0]).unwrap();
    }
}
