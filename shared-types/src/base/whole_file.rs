//! Output files: written completely or not at all, and checked before the work that fills them.
//!
//! A regular file is written beside its place and renamed. It keeps the permissions and the owner
//! of the file that it replaces, and the links that lead to it. A file in a folder that takes no
//! other file, and a file that is a mount point, is written in place. Pipes, devices and the
//! process's descriptors (`-`, `/dev/stdout`, `/dev/fd/3`) are written to as they are.

use std::fs::{File, Metadata, OpenOptions};
use std::io::{self, ErrorKind, Write};
use std::os::unix::ffi::OsStrExt;
use std::os::unix::fs::{FileTypeExt, OpenOptionsExt, PermissionsExt};
use std::path::{Path, PathBuf};

use crate::base::temporary_file::TemporaryFile;
use crate::base::text_file::folder_of;

/// Most symbolic links that lead to a file.
const LINKS_MAX: usize = 40;

/// What a path names.
#[derive(Debug, PartialEq, Eq)]
enum Destination {
    /// A regular file, or none yet, behind all links.
    File(PathBuf),
    /// A pipe or a character device.
    Stream(PathBuf),
    /// A descriptor of this process.
    Descriptor(u32),
}

/// Checks that `path` can be written to. Leaves nothing behind.
///
/// # Errors
/// The reason, and what to do.
pub fn check(path: &Path) -> Result<(), String> {
    match Destination::of(path)? {
        Destination::Descriptor(1 | 2) => Ok(()),
        Destination::Descriptor(number) => {
            open_descriptor(number).map(drop).map_err(|error| error.to_string())
        }
        Destination::Stream(path) => {
            is_writable(&path).map_err(|error| format!("{error}; choose another name"))
        }
        Destination::File(target) => {
            let before = existing(&target)?;
            match TemporaryFile::beside(&target, before.as_ref()) {
                Ok(_) => Ok(()),
                Err(_) if before.is_some() => Ok(()),
                Err(error) => Err(format!("{error}; choose another folder")),
            }
        }
    }
}

/// Writes `bytes` to `path`: all of them, or the path keeps what it held.
///
/// # Errors
/// The reason.
pub fn write(path: &Path, bytes: &[u8]) -> Result<(), String> {
    match Destination::of(path)? {
        Destination::Descriptor(number) => {
            write_descriptor(number, bytes).map_err(|error| error.to_string())
        }
        Destination::Stream(path) => OpenOptions::new()
            .write(true)
            .open(path)
            .and_then(|mut stream| stream.write_all(bytes))
            .map_err(|error| error.to_string()),
        Destination::File(target) => write_file(&target, bytes),
    }
}

/// Whether `path` names the standard output of this process.
pub fn is_standard_output(path: &Path) -> bool {
    matches!(Destination::of(path), Ok(Destination::Descriptor(1)))
}

/// Whether `path` names a pipe, a device or a descriptor rather than a regular file.
pub fn is_stream(path: &Path) -> bool {
    matches!(Destination::of(path), Ok(Destination::Descriptor(_) | Destination::Stream(_)))
}

/// The file that `path` names behind all links, for comparisons; `None` for a stream.
pub fn target_of(path: &Path) -> Option<PathBuf> {
    let Ok(Destination::File(target)) = Destination::of(path) else { return None };
    Some(folder_of(&target).canonicalize().ok()?.join(target.file_name()?))
}

impl Destination {
    fn of(path: &Path) -> Result<Self, String> {
        let mut target = path.to_owned();
        for _ in 0..LINKS_MAX {
            if let Some(number) = descriptor_number(&target) {
                return Ok(Self::Descriptor(number));
            }
            if has_no_name(&target) {
                return Err("it is a folder; name a file in it".to_owned());
            }
            match target.symlink_metadata() {
                Ok(found) if found.is_symlink() => {
                    let link = target.read_link().map_err(|error| error.to_string())?;
                    target = folder_of(&target).join(link);
                }
                Ok(found) => return Self::of_existing(target, &found),
                Err(error) if error.kind() == ErrorKind::NotFound => return Self::of_new(target),
                Err(error) => return Err(format!("{error}; choose another name")),
            }
        }
        Err("too many symbolic links lead to it; choose another name".to_owned())
    }

    fn of_existing(target: PathBuf, found: &Metadata) -> Result<Self, String> {
        let kind = found.file_type();
        if kind.is_dir() {
            Err("it is a folder; name a file in it".to_owned())
        } else if kind.is_file() {
            Ok(Self::File(target))
        } else if kind.is_fifo() || kind.is_char_device() {
            Ok(Self::Stream(target))
        } else {
            Err("it exists and is not a file, a pipe or a device for text; choose another name"
                .to_owned())
        }
    }

    fn of_new(target: PathBuf) -> Result<Self, String> {
        match folder_of(&target).metadata() {
            Ok(folder) if folder.is_dir() => Ok(Self::File(target)),
            Ok(_) => Err("its folder is not a folder; choose another name".to_owned()),
            Err(error) if error.kind() == ErrorKind::NotFound => {
                Err("its folder does not exist; create it first".to_owned())
            }
            Err(error) => Err(format!("its folder: {error}")),
        }
    }
}

/// The number of the descriptor of this process that a path names.
fn descriptor_number(path: &Path) -> Option<u32> {
    match path.to_str()? {
        "-" | "/dev/stdout" => Some(1),
        "/dev/stderr" => Some(2),
        name => {
            let number = ["/dev/fd/", "/proc/self/fd/"];
            number.iter().find_map(|folder| name.strip_prefix(folder))?.parse().ok()
        }
    }
}

/// Whether a path ends in a slash or a dot, so that only a folder can be there.
fn has_no_name(path: &Path) -> bool {
    let bytes = path.as_os_str().as_bytes();
    path.file_name().is_none() || bytes.ends_with(b"/") || bytes.ends_with(b"/.")
}

fn open_descriptor(number: u32) -> io::Result<File> {
    OpenOptions::new().append(true).open(format!("/proc/self/fd/{number}"))
}

fn write_descriptor(number: u32, bytes: &[u8]) -> io::Result<()> {
    match number {
        1 => {
            let mut out = io::stdout().lock();
            out.write_all(bytes).and_then(|()| out.flush())
        }
        2 => io::stderr().write_all(bytes),
        _ => open_descriptor(number)?.write_all(bytes),
    }
}

/// Whether the system permits this process to write to `path`.
fn is_writable(path: &Path) -> io::Result<()> {
    let path = std::ffi::CString::new(path.as_os_str().as_bytes())?;
    // SAFETY: the string outlives the call.
    let answer =
        unsafe { libc::faccessat(libc::AT_FDCWD, path.as_ptr(), libc::W_OK, libc::AT_EACCESS) };
    if answer == 0 { Ok(()) } else { Err(io::Error::last_os_error()) }
}

/// The file at `target`, if there is one, which must be open to writing.
fn existing(target: &Path) -> Result<Option<Metadata>, String> {
    let Ok(found) = target.metadata() else { return Ok(None) };
    if found.permissions().mode() & 0o222 == 0 {
        return Err(
            "it is write-protected; permit writing (chmod u+w) or choose another name".to_owned()
        );
    }
    let opened = OpenOptions::new().write(true).custom_flags(libc::O_NONBLOCK).open(target);
    opened.map_err(|error| format!("{error}; choose another name"))?;
    Ok(Some(found))
}

fn write_file(target: &Path, bytes: &[u8]) -> Result<(), String> {
    let before = existing(target)?;
    let temporary = match TemporaryFile::beside(target, before.as_ref()) {
        Ok(temporary) => temporary,
        Err(_) if before.is_some() => return write_in_place(target, bytes),
        Err(error) => return Err(error.to_string()),
    };
    temporary.fill(bytes).map_err(|error| error.to_string())?;
    match temporary.persist(target) {
        Err(error) if error.kind() == ErrorKind::ResourceBusy => write_in_place(target, bytes),
        moved => moved.map_err(|error| error.to_string()),
    }
}

/// Writes a file that nothing can be renamed to.
fn write_in_place(target: &Path, bytes: &[u8]) -> Result<(), String> {
    let written =
        OpenOptions::new().write(true).truncate(true).open(target).and_then(|mut file| {
            file.write_all(bytes)?;
            file.sync_all()
        });
    written.map_err(|error| error.to_string())
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::fs;
    use std::os::unix::fs::symlink;

    fn folder() -> tempfile::TempDir {
        tempfile::tempdir().unwrap()
    }

    fn names(folder: &Path) -> Vec<String> {
        let entries = fs::read_dir(folder).unwrap();
        let mut names: Vec<String> =
            entries.map(|entry| entry.unwrap().file_name().to_string_lossy().into()).collect();
        names.sort();
        names
    }

    #[test]
    fn a_check_leaves_nothing_and_a_write_leaves_the_file() {
        let folder = folder();
        let path = folder.path().join("a.json");
        check(&path).unwrap();
        assert!(names(folder.path()).is_empty());
        write(&path, b"one").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"one");
        assert_eq!(names(folder.path()), ["a.json"]);
    }

    #[test]
    fn permissions_stay() {
        let folder = folder();
        let path = folder.path().join("a.json");
        for mode in [0o600, 0o640, 0o755] {
            fs::write(&path, "mine").unwrap();
            fs::set_permissions(&path, fs::Permissions::from_mode(mode)).unwrap();
            write(&path, b"new").unwrap();
            assert_eq!(fs::metadata(&path).unwrap().permissions().mode() & 0o7777, mode);
            assert_eq!(fs::read(&path).unwrap(), b"new");
        }
    }

    #[test]
    fn a_write_protected_file_stays() {
        let folder = folder();
        let path = folder.path().join("a.json");
        fs::write(&path, "mine").unwrap();
        fs::set_permissions(&path, fs::Permissions::from_mode(0o444)).unwrap();
        for refused in [check(&path), write(&path, b"new")] {
            assert!(refused.unwrap_err().contains("write-protected"));
        }
        assert_eq!(fs::read(&path).unwrap(), b"mine");
    }

    #[test]
    fn links_stay_and_lead_to_the_file() {
        let folder = folder();
        let inner = folder.path().join("inner");
        fs::create_dir(&inner).unwrap();
        symlink("inner/a.json", folder.path().join("link")).unwrap();
        symlink("link", folder.path().join("link-to-link")).unwrap();
        let path = folder.path().join("link-to-link");
        check(&path).unwrap();
        write(&path, b"new").unwrap();
        assert!(path.symlink_metadata().unwrap().is_symlink());
        assert_eq!(fs::read(inner.join("a.json")).unwrap(), b"new");
        assert_eq!(target_of(&path), Some(inner.canonicalize().unwrap().join("a.json")));
    }

    #[test]
    fn the_check_refuses_paths_that_cannot_be_written() {
        let folder = folder();
        let at = |name: &str| folder.path().join(name);
        symlink("loop", at("loop")).unwrap();
        symlink("missing/a.json", at("nowhere")).unwrap();
        fs::write(at("file"), "").unwrap();
        let long = "x".repeat(300);
        for (name, expected) in [
            ("", "folder"),
            ("plan.json/", "folder"),
            ("file/", "folder"),
            (".", "folder"),
            ("missing/a.json", "does not exist"),
            ("nowhere", "does not exist"),
            ("file/a.json", "ot a directory"),
            ("loop", "too many symbolic links"),
            (long.as_str(), "name too long"),
        ] {
            let reason = check(&at(name)).unwrap_err();
            assert!(reason.contains(expected), "{name}: {reason}");
            assert!(write(&at(name), b"new").is_err(), "{name}");
        }
        assert_eq!(names(folder.path()), ["file", "loop", "nowhere"]);
    }

    #[test]
    fn devices_pipes_and_descriptors_are_streams() {
        for path in ["-", "/dev/stdout", "/dev/fd/1", "/dev/stderr", "/dev/null"] {
            check(Path::new(path)).unwrap();
            assert!(is_stream(Path::new(path)), "{path}");
        }
        assert!(is_standard_output(Path::new("-")) && !is_standard_output(Path::new("/dev/null")));
        write(Path::new("/dev/null"), b"new").unwrap();
        assert!(write(Path::new("/dev/full"), b"new").unwrap_err().contains("No space"));
        assert!(check(Path::new("/dev/fd/987")).is_err());
    }
}
