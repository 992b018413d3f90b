//! Where the build script finds the commit, and which files it asks cargo to watch.

#![allow(clippy::unwrap_used, reason = "a test ends where its folder cannot be written")]

#[allow(dead_code, reason = "cargo calls its main, these tests call the rest")]
#[path = "../build.rs"]
mod build_script;

use std::fs;
use std::path::Path;

use build_script::find;

const ID: &str = "0123456789abcdef0123456789abcdef01234567";
const OTHER_ID: &str = "fedcba9876543210fedcba9876543210fedcba98";

fn write(folder: &Path, name: &str, text: &str) {
    let path = folder.join(name);
    fs::create_dir_all(path.parent().unwrap()).unwrap();
    fs::write(path, text).unwrap();
}

/// Asserts the commit and the watched paths, relative to the folder.
fn assert_found(folder: &Path, package: &str, commit: &str, watched: &[&str]) {
    let source = find(&folder.join(package));
    assert_eq!(source.commit, commit);
    let canonical = |path: &Path| path.canonicalize().unwrap();
    let found: Vec<_> = source.watched.iter().map(|path| canonical(path)).collect();
    let expected: Vec<_> = watched.iter().map(|name| canonical(&folder.join(name))).collect();
    assert_eq!(found, expected);
}

#[test]
fn a_branch_of_its_own_file() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), ".git/HEAD", "ref: refs/heads/main\n");
    write(folder.path(), ".git/refs/heads/main", &format!("{ID}\n"));
    write(folder.path(), ".git/packed-refs", &format!("{OTHER_ID} refs/heads/main\n"));
    assert_found(folder.path(), "", "0123456789ab", &[".git/HEAD", ".git/refs/heads/main"]);
}

#[test]
fn a_packed_branch() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), ".git/HEAD", "ref: refs/heads/topic/one\n");
    fs::create_dir_all(folder.path().join(".git/refs/heads")).unwrap();
    let packed =
        format!("# pack-refs with: peeled\n{OTHER_ID} refs/heads/a\n{ID} refs/heads/topic/one\n");
    write(folder.path(), ".git/packed-refs", &packed);
    let watched = [".git/HEAD", ".git/packed-refs", ".git/refs/heads"];
    assert_found(folder.path(), "", "0123456789ab", &watched);
}

#[test]
fn a_detached_head() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), ".git/HEAD", &format!("{ID}\n"));
    assert_found(folder.path(), "", "0123456789ab", &[".git/HEAD"]);
}

#[test]
fn a_worktree_whose_git_is_a_file() {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), "tree/.git", "gitdir: ../main/.git/worktrees/tree\n");
    write(folder.path(), "main/.git/worktrees/tree/commondir", "../..\n");
    write(folder.path(), "main/.git/worktrees/tree/HEAD", "ref: refs/heads/tree\n");
    write(folder.path(), "main/.git/refs/heads/tree", &format!("{ID}\n"));
    let watched = ["main/.git/worktrees/tree/HEAD", "main/.git/refs/heads/tree"];
    assert_found(folder.path(), "tree", "0123456789ab", &watched);
}

#[test]
fn a_package_names_the_commit_it_was_made_from() {
    let folder = tempfile::tempdir().unwrap();
    let info = format!("{{\n  \"git\": {{\n    \"sha1\": \"{ID}\"\n  }}\n}}\n");
    write(folder.path(), ".cargo_vcs_info.json", &info);
    assert_found(folder.path(), "", "0123456789ab", &[".cargo_vcs_info.json"]);
}

#[test]
fn no_repository_or_an_unreadable_one_is_unknown() {
    let folder = tempfile::tempdir().unwrap();
    assert_found(folder.path(), "", "unknown", &[]);
    write(folder.path(), ".git/HEAD", "ref: refs/heads/new\n");
    assert_found(folder.path(), "", "unknown", &[".git/HEAD", ".git"]);
    write(folder.path(), ".git/HEAD", "nonsense\n");
    assert_found(folder.path(), "", "unknown", &[".git/HEAD"]);
    write(folder.path(), "inner/Cargo.toml", "");
    assert_found(folder.path(), "inner", "unknown", &[]);
}
