//! Traces of processes: their children, memory and descriptors, and their files in shared memory.

use std::fs;
use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};

use surefoot_shared_types::base::user::effective_uid;

/// The folder of shared memory.
const SHARED_MEMORY: &str = "/dev/shm";

/// The child of a process that runs this subcommand of `surefoot`.
pub(crate) fn child_of(process: u32, subcommand: &str) -> Option<libc::pid_t> {
    children_of(process).into_iter().find(|child| subcommand_of(*child) == subcommand)
}

/// A process and its children: number, subcommand and state (`S` sleeps, `R` runs, `Z` has ended).
pub(crate) fn family_of(process: u32) -> String {
    let process = libc::pid_t::try_from(process).unwrap_or(libc::pid_t::MAX);
    let family = std::iter::once(process).chain(children_of(process.unsigned_abs()));
    let member = |process| {
        let stat = fs::read_to_string(format!("/proc/{process}/stat")).unwrap_or_default();
        let state = stat.rsplit(')').next().and_then(|rest| rest.split_whitespace().next());
        format!("{process} {} {}", subcommand_of(process), state.unwrap_or("gone"))
    };
    family.map(member).collect::<Vec<_>>().join(", ")
}

fn children_of(process: u32) -> Vec<libc::pid_t> {
    let children = fs::read_to_string(format!("/proc/{process}/task/{process}/children"));
    let parsed = |children: String| {
        children.split_whitespace().filter_map(|child| child.parse().ok()).collect()
    };
    children.map(parsed).unwrap_or_default()
}

fn subcommand_of(process: libc::pid_t) -> String {
    let line = fs::read(format!("/proc/{process}/cmdline")).unwrap_or_default();
    let argument = line.split(|byte| *byte == 0).nth(1).unwrap_or_default();
    String::from_utf8_lossy(argument).into_owned()
}

/// Sends a signal; `false` if the process does not exist.
pub(crate) fn signal(process: libc::pid_t, signal: libc::c_int) -> bool {
    // SAFETY: kill touches no memory.
    unsafe { libc::kill(process, signal) == 0 }
}

/// Memory in use (KiB) and open descriptors of a process; 0 where the system does not say.
pub(crate) fn resources(process: u32) -> (u64, u64) {
    let status = fs::read_to_string(format!("/proc/{process}/status")).unwrap_or_default();
    let resident = status.lines().find_map(|line| {
        line.strip_prefix("VmRSS:")?.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()
    });
    let descriptors = fs::read_dir(format!("/proc/{process}/fd")).map_or(0, Iterator::count);
    (resident.unwrap_or(0), descriptors as u64)
}

/// The files and folders of an instance that are left in shared memory; those that another user
/// put there are not ours to remove.
pub(crate) fn left_over(instance: &str) -> Vec<PathBuf> {
    let segment = format!("-{instance}.");
    let mut found = entries(Path::new(SHARED_MEMORY));
    let bases: Vec<PathBuf> = found
        .iter()
        .filter(|path| path.is_dir() && name_of(path).starts_with("surefoot-"))
        .cloned()
        .collect();
    found.extend(bases.iter().flat_map(|base| entries(base)));
    found.retain(|path| name_of(path) == instance || name_of(path).contains(&segment));
    found.retain(is_ours);
    found
}

/// Whether this user owns a file that still exists.
fn is_ours(path: &PathBuf) -> bool {
    fs::symlink_metadata(path).is_ok_and(|metadata| metadata.uid() == effective_uid())
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect()
}

fn name_of(path: &Path) -> String {
    path.file_name().unwrap_or_default().to_string_lossy().into_owned()
}
