//! Shared memory, cores and limits of the machine.

use std::ffi::CString;
use std::path::Path;

use crate::commands::doctor::finding::Finding;
use crate::system::cores;
use crate::system::limits::{FILE_KIB_MIN, OPEN_FILES_MIN, soft_limit};

const SHARED_MEMORY: &str = "/dev/shm";
/// Free shared memory that a walk needs, with room to spare, MiB.
const FREE_MIB_MIN: u64 = 64;
/// Memory that may be locked where nothing can be paged out by surprise, KiB.
const LOCKED_KIB_MIN: u64 = 65_536;

/// Whether shared memory can be written to, and its free size.
pub(crate) fn shared_memory() -> Vec<Finding> {
    let writable = match tempfile::tempfile_in(SHARED_MEMORY) {
        Ok(_) => Finding::good(format!("shared memory: {SHARED_MEMORY} can be written to")),
        Err(error) => {
            Finding::missing(format!("shared memory: {error}; mount a tmpfs there with mode 1777"))
        }
    };
    let size = match sizes_mib(Path::new(SHARED_MEMORY)) {
        Some((free, total)) if free < FREE_MIB_MIN => Finding::missing(format!(
            "shared memory: {free} MiB of {total} MiB free, {FREE_MIB_MIN} are needed; remount it larger (in a container: --shm-size=256m)"
        )),
        Some((free, total)) => {
            Finding::good(format!("shared memory: {free} MiB of {total} MiB free"))
        }
        None => Finding::missing(format!(
            "shared memory: {SHARED_MEMORY} is no file system; mount a tmpfs there"
        )),
    };
    vec![writable, size]
}

/// Whether planner and controller can have a core each.
pub(crate) fn cores() -> Finding {
    match cores::cores() {
        1 => Finding::advice("cores: 1; planner and controller share it; two cores are faster"),
        cores => Finding::good(format!("cores: {cores}; planner and controller have one each")),
    }
}

/// The system's limits of this process.
pub(crate) fn limits() -> Vec<Finding> {
    let open_files = match soft_limit(libc::RLIMIT_NOFILE) {
        Some(files) if files < OPEN_FILES_MIN => Finding::missing(format!(
            "open files: {files}, {OPEN_FILES_MIN} are needed; run 'ulimit -n 1024'"
        )),
        files => Finding::good(format!("open files: {}", describe_limit(files, ""))),
    };
    let locked = match soft_limit(libc::RLIMIT_MEMLOCK) {
        Some(bytes) if bytes / 1024 < LOCKED_KIB_MIN => Finding::advice(format!(
            "locked memory: {} KiB; run 'ulimit -l {LOCKED_KIB_MIN}' to keep timing steady",
            bytes / 1024
        )),
        bytes => Finding::good(format!(
            "locked memory: {}",
            describe_limit(bytes.map(|bytes| bytes / 1024), " KiB")
        )),
    };
    let file_size = match soft_limit(libc::RLIMIT_FSIZE).map(|bytes| bytes / 1024) {
        Some(kib) if kib < FILE_KIB_MIN => Finding::missing(format!(
            "file size: {kib} KiB, {FILE_KIB_MIN} are needed; run 'ulimit -f unlimited'"
        )),
        kib => Finding::good(format!("file size: {}", describe_limit(kib, " KiB"))),
    };
    vec![open_files, file_size, locked]
}

fn describe_limit(limit: Option<u64>, unit: &str) -> String {
    limit.map_or("unlimited".to_owned(), |limit| format!("{limit}{unit}"))
}

/// Free and total size of the file system at `path`, MiB.
fn sizes_mib(path: &Path) -> Option<(u64, u64)> {
    let path = CString::new(path.to_str()?).ok()?;
    // SAFETY: an all-zero statvfs is a valid one.
    let mut stat: libc::statvfs = unsafe { std::mem::zeroed() };
    // SAFETY: both pointers outlive the call.
    let result = unsafe { libc::statvfs(path.as_ptr(), &mut stat) };
    let mib = |blocks: u64| ((u128::from(blocks) * u128::from(stat.f_frsize)) >> 20) as u64;
    (result == 0).then(|| (mib(stat.f_bavail), mib(stat.f_blocks)))
}
