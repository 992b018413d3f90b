//! Runs the `surefoot` binary.

use std::os::unix::fs::MetadataExt;
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Output, Stdio};

/// Exit code and output of a finished run.
pub struct CommandOutput {
    pub code: i32,
    pub out: String,
    pub err: String,
    pub pid: u32,
}

/// The command with these arguments in the repository's folder, before its start.
pub fn surefoot(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_surefoot"));
    command.current_dir(env!("CARGO_MANIFEST_DIR")).args(arguments);
    command.env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"));
    command.stdin(Stdio::null()).stdout(Stdio::piped()).stderr(Stdio::piped());
    command
}

/// Runs the command to its end.
pub fn run(arguments: &[&str]) -> CommandOutput {
    finish(surefoot(arguments).spawn().unwrap())
}

/// Waits for the end of a run.
pub fn finish(child: Child) -> CommandOutput {
    let pid = child.id();
    let Output { status, stdout, stderr } = child.wait_with_output().unwrap();
    let code = status.code().unwrap_or_else(|| panic!("surefoot ended by {status}"));
    CommandOutput {
        code,
        out: String::from_utf8(stdout).unwrap(),
        err: String::from_utf8(stderr).unwrap(),
        pid,
    }
}

/// A scenario that ships with the repository.
pub fn scenario(name: &str) -> String {
    format!("configs/scenarios/{name}.toml")
}

/// The running process of a role of a walk, identified by its subcommand.
pub fn role(walk: u32, subcommand: &str) -> Option<libc::pid_t> {
    let children = std::fs::read_to_string(format!("/proc/{walk}/task/{walk}/children")).ok()?;
    let is_role = |child: &&str| {
        let line = std::fs::read(format!("/proc/{child}/cmdline")).unwrap_or_default();
        line.split(|byte| *byte == 0).nth(1) == Some(subcommand.as_bytes())
    };
    children.split_whitespace().find(is_role)?.parse().ok()
}

/// Fails if shared memory still holds a file or folder of this process's instance that belongs to
/// this user: nobody can remove those of others.
pub fn assert_nothing_left(pid: u32) {
    let name = format!("walk-{pid}");
    let owner = |path: &Path| std::fs::metadata(path).ok().map(|file| file.uid());
    let user = owner(Path::new("/proc/self"));
    let is_ours = |path: &PathBuf| {
        let file = path.file_name().unwrap().to_string_lossy();
        (file == name || file.contains(&format!("-{name}."))) && owner(path) == user
    };
    let mut found = entries(Path::new("/dev/shm"));
    let bases: Vec<PathBuf> = found
        .iter()
        .filter(|path| path.is_dir() && path.to_string_lossy().starts_with("/dev/shm/surefoot-"))
        .cloned()
        .collect();
    found.extend(bases.iter().flat_map(|base| entries(base)));
    found.retain(is_ours);
    assert!(found.is_empty(), "these remain: {found:?}");
}

fn entries(folder: &Path) -> Vec<PathBuf> {
    // Other tests create and remove instances at the same time.
    std::fs::read_dir(folder).into_iter().flatten().flatten().map(|entry| entry.path()).collect()
}
