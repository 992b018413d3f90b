//! Gives the program the commit it is built from, in the environment variable `SUREFOOT_COMMIT`,
//! and the files of `configs/`, in `shipped_files.rs` of the output folder.
//!
//! The commit is read from the files of git, or from `.cargo_vcs_info.json` in a package made by
//! `cargo package`; it is `unknown` where neither exists. Git itself is not called. Changes that
//! are not committed do not show.

use std::fs;
use std::path::{Path, PathBuf};

/// The commit where none can be found.
const UNKNOWN: &str = "unknown";
/// Length of a full commit id, hexadecimal digits (SHA-1, and SHA-256).
const ID_LENGTHS: [usize; 2] = [40, 64];
/// Digits of the commit id that are shown.
const SHOWN_LENGTH: usize = 12;

/// A commit and the files that decide it.
#[derive(Debug, PartialEq, Eq)]
pub struct Source {
    /// The beginning of the commit's id, or `unknown`.
    pub commit: String,
    /// Existing files and folders; a change in one of them may change the commit.
    pub watched: Vec<PathBuf>,
}

#[allow(clippy::print_stdout, reason = "cargo reads the directives of a build script there")]
fn main() {
    let source = find(Path::new(env!("CARGO_MANIFEST_DIR")));
    println!("cargo::rerun-if-changed=build.rs");
    for path in &source.watched {
        println!("cargo::rerun-if-changed={}", path.display());
    }
    println!("cargo::rustc-env=SUREFOOT_COMMIT={}", source.commit);
    let configs = Path::new(env!("CARGO_MANIFEST_DIR")).join("configs");
    println!("cargo::rerun-if-changed={}", configs.display());
    let out = std::env::var_os("OUT_DIR").map(PathBuf::from).expect("cargo sets OUT_DIR");
    fs::write(out.join("shipped_files.rs"), shipped_files(&configs))
        .expect("cargo's output folder can be written to");
}

/// A Rust expression: the files below a folder, each with its path from there and its bytes.
fn shipped_files(folder: &Path) -> String {
    let mut files = Vec::new();
    collect(folder, &mut files);
    files.sort();
    let rows = files.iter().map(|file| {
        let name = file.strip_prefix(folder).unwrap_or(file).display().to_string();
        format!("    ({name:?}, include_bytes!({:?})),\n", file.display().to_string())
    });
    format!("&[\n{}]\n", rows.collect::<String>())
}

/// Adds every file below a folder.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in fs::read_dir(folder).into_iter().flatten().flatten() {
        let path = entry.path();
        if path.is_dir() { collect(&path, files) } else { files.push(path) }
    }
}

/// The commit of the package in `folder`. A repository around the folder is not the package's own.
pub fn find(folder: &Path) -> Source {
    let package = folder.join(".cargo_vcs_info.json");
    let (id, mut watched) = match fs::read_to_string(&package) {
        Ok(text) => (after(&text, "\"sha1\"").and_then(quoted).map(str::to_owned), vec![package]),
        Err(_) => checked_out(&folder.join(".git")),
    };
    watched.retain(|path| path.exists());
    let commit = id.filter(|id| is_id(id)).map_or(UNKNOWN.to_owned(), |mut id| {
        id.truncate(SHOWN_LENGTH);
        id
    });
    Source { commit, watched }
}

/// The id that is checked out, read from git's files. `.git` is a file in further worktrees and in
/// submodules.
fn checked_out(dot_git: &Path) -> (Option<String>, Vec<PathBuf>) {
    let git = match fs::read_to_string(dot_git) {
        Ok(text) => match text.trim().strip_prefix("gitdir: ") {
            Some(path) => dot_git.with_file_name("").join(path),
            None => return (None, vec![]),
        },
        Err(_) => dot_git.to_owned(),
    };
    let common = fs::read_to_string(git.join("commondir"));
    let common = common.map_or_else(|_| git.clone(), |path| git.join(path.trim()));
    let head = git.join("HEAD");
    let text = fs::read_to_string(&head).unwrap_or_default();
    let Some(name) = text.trim().strip_prefix("ref: ") else {
        return (Some(text.trim().to_owned()), vec![head]);
    };
    let (loose, packed) = (common.join(name), common.join("packed-refs"));
    match fs::read_to_string(&loose) {
        Ok(id) => (Some(id.trim().to_owned()), vec![head, loose]),
        Err(_) => (packed_id(&packed, name), vec![head, packed, existing_parent(&loose)]),
    }
}

/// The id of a branch in `packed-refs`, whose lines are `ID NAME`.
fn packed_id(packed: &Path, name: &str) -> Option<String> {
    let text = fs::read_to_string(packed).ok()?;
    let mut pairs = text.lines().filter_map(|line| line.split_once(' '));
    pairs.find(|(_, found)| *found == name).map(|(id, _)| id.to_owned())
}

/// The nearest folder above that exists: the branch's file appears in it with the next commit.
fn existing_parent(path: &Path) -> PathBuf {
    path.ancestors().skip(1).find(|folder| folder.exists()).unwrap_or(path).to_owned()
}

fn after<'a>(text: &'a str, key: &str) -> Option<&'a str> {
    text.split_once(key).map(|(_, rest)| rest)
}

/// The first quoted text.
fn quoted(text: &str) -> Option<&str> {
    text.split('"').nth(1)
}

fn is_id(text: &str) -> bool {
    ID_LENGTHS.contains(&text.len()) && text.bytes().all(|byte| byte.is_ascii_hexdigit())
}
