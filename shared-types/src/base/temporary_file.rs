//! Temporary files beside the file that they become.
//!
//! The process that fills one holds a lock on it, which the kernel releases when the process ends,
//! however that comes about. A file without a lock is left over from a process that was killed;
//! the next process that writes in the same folder removes it.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::os::unix::fs::{MetadataExt, OpenOptionsExt, fchown};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};

use crate::base::text_file::folder_of;
use crate::base::user::effective_uid;

const PREFIX: &str = ".surefoot-";
const SUFFIX: &str = ".tmp";
/// Attempts to find a name that no other process uses.
const ATTEMPTS_MAX: usize = 64;

/// Numbers the temporary files of this process.
static NUMBER: AtomicU64 = AtomicU64::new(0);

/// A temporary file; removed when dropped.
#[derive(Debug)]
pub(crate) struct TemporaryFile {
    path: PathBuf,
    file: File,
    is_moved: bool,
}

impl TemporaryFile {
    /// A new file in the folder of `target`, with the permissions and the owner of `before`.
    pub(crate) fn beside(target: &Path, before: Option<&Metadata>) -> io::Result<Self> {
        let folder = folder_of(target);
        remove_dead(&folder);
        let temporary = Self::create(&folder, if before.is_some() { 0o600 } else { 0o666 })?;
        if let Some(before) = before {
            let own = temporary.file.metadata()?;
            if (own.uid(), own.gid()) != (before.uid(), before.gid()) {
                fchown(&temporary.file, Some(before.uid()), Some(before.gid()))?;
            }
            temporary.file.set_permissions(before.permissions())?;
        }
        Ok(temporary)
    }

    fn create(folder: &Path, mode: u32) -> io::Result<Self> {
        for _ in 0..ATTEMPTS_MAX {
            let number = NUMBER.fetch_add(1, Ordering::Relaxed);
            let path = folder.join(format!("{PREFIX}{}-{number}{SUFFIX}", std::process::id()));
            let opened = OpenOptions::new().write(true).create_new(true).mode(mode).open(&path);
            let file = match opened {
                Err(error) if error.kind() == ErrorKind::AlreadyExists => continue,
                opened => opened?,
            };
            // A file system without locks leaves its files to the user.
            let _ = file.try_lock();
            let temporary = Self { path, file, is_moved: false };
            // Another process may have removed it before it was locked.
            if temporary.file.metadata()?.nlink() > 0 {
                return Ok(temporary);
            }
        }
        Err(io::Error::from(ErrorKind::AlreadyExists))
    }

    /// Writes `bytes` and waits until they are stored.
    pub(crate) fn fill(&self, bytes: &[u8]) -> io::Result<()> {
        (&self.file).write_all(bytes)?;
        match self.file.sync_all() {
            // Some file systems do not synchronize.
            Err(error) if error.kind() == ErrorKind::InvalidInput => Ok(()),
            synchronized => synchronized,
        }
    }

    /// Moves it to `target`.
    pub(crate) fn persist(mut self, target: &Path) -> io::Result<()> {
        fs::rename(&self.path, target)?;
        self.is_moved = true;
        Ok(())
    }
}

impl Drop for TemporaryFile {
    fn drop(&mut self) {
        if !self.is_moved {
            // The next process that writes here removes it otherwise.
            let _ = fs::remove_file(&self.path);
        }
    }
}

/// Removes the temporary files of this user in `folder` that no process fills. A failure leaves
/// them there.
fn remove_dead(folder: &Path) {
    let Ok(entries) = fs::read_dir(folder) else { return };
    for entry in entries.flatten() {
        let name = entry.file_name();
        let is_temporary =
            name.to_str().is_some_and(|name| name.starts_with(PREFIX) && name.ends_with(SUFFIX));
        if is_temporary && is_dead(&entry.path()) {
            let _ = fs::remove_file(entry.path());
        }
    }
}

fn is_dead(path: &Path) -> bool {
    let opened =
        OpenOptions::new().read(true).custom_flags(libc::O_NOFOLLOW | libc::O_NONBLOCK).open(path);
    opened.is_ok_and(|file| {
        file.metadata().is_ok_and(|found| found.is_file() && found.uid() == effective_uid())
            && file.try_lock().is_ok()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn dead_files_are_removed_and_files_in_use_stay() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a");
        let dead = folder.path().join(".surefoot-1-1.tmp");
        fs::write(&dead, "half").unwrap();
        let one = TemporaryFile::beside(&target, None).unwrap();
        assert!(!dead.exists());
        let other = TemporaryFile::beside(&target, None).unwrap();
        assert!(one.path.exists() && other.path.exists() && one.path != other.path);
        drop(one);
        other.fill(b"whole").unwrap();
        other.persist(&target).unwrap();
        let left: Vec<_> = fs::read_dir(folder.path()).unwrap().flatten().collect();
        assert_eq!(left.len(), 1);
        assert_eq!(fs::read(&target).unwrap(), b"whole");
    }

    #[test]
    fn a_pipe_of_that_name_stays() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join(".surefoot-1-1.tmp");
        let made = std::process::Command::new("mkfifo").arg(&pipe).status().unwrap();
        assert!(made.success());
        TemporaryFile::beside(&folder.path().join("a"), None).unwrap();
        assert!(pipe.exists());
    }
}
