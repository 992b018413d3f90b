//! What the pages show is true of the program: every block of commands for newcomers ends as its
//! page says, and every command and option that any page names exists. Blocks marked `sh notest`
//! install other software.

#![allow(clippy::print_stdout, reason = "a test prints what it runs")]
#![allow(clippy::unwrap_used, reason = "a page that cannot be read fails the test")]

#[path = "common/absent.rs"]
mod absent;

use std::collections::{BTreeMap, BTreeSet};
use std::fs;
use std::os::unix::fs::{PermissionsExt, symlink};
use std::path::{Path, PathBuf};
use std::process::Command;

use regex::Regex;

/// In place of cargo, whose build these tests are.
const CARGO: &str = "#!/bin/sh\ncase $1 in run) shift 3; exec surefoot \"$@\" ;; esac\n";
/// Commands whose first argument is a command of its own.
const GROUPS: [&str; 3] = ["bench", "config", "robot"];

fn root() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR"))
}

fn text_of(page: &str) -> String {
    fs::read_to_string(root().join(page)).unwrap()
}

/// The blocks of shell commands in a page that run without other software.
fn blocks(page: &str) -> Vec<String> {
    let block = Regex::new(r"(?ms)^```sh\n(.*?)^```$").unwrap();
    block.captures_iter(&text_of(page)).map(|found| found[1].to_owned()).collect()
}

/// Runs the blocks of a page in a folder, one after the other, each until its first failure.
fn run_page(page: &str, folder: &Path) {
    let program = Path::new(env!("CARGO_BIN_EXE_surefoot")).parent().unwrap().to_owned();
    let path = std::env::var("PATH").unwrap();
    let path = format!("{}:{}:{path}", folder.display(), program.display());
    // Instances are shared by all processes of a user.
    let instance = format!("test-documented-{}", std::process::id());
    for block in blocks(page) {
        println!("{block}");
        let run = Command::new("sh")
            .args(["-e", "-c", &block.replace("mine", &instance)])
            .current_dir(folder)
            .env("PATH", &path)
            .env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"))
            // Cargo's may lead to the library of an older build.
            .env_remove("LD_LIBRARY_PATH")
            .output()
            .unwrap();
        let [out, err] =
            [run.stdout, run.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
        assert!(run.status.success(), "{page}: {block}{out}{err}");
    }
}

#[test]
fn a_start_and_a_failure_run_as_shown() {
    for page in ["docs/START.md", "docs/FAILURES.md"] {
        assert!(blocks(page).len() >= 2, "{page}");
        run_page(page, tempfile::tempdir().unwrap().path());
    }
}

#[test]
fn a_robot_of_ones_own_walks_as_shown() {
    let folder = tempfile::tempdir().unwrap();
    let urdf = root().join("configs/robots/hubo/hubo.urdf");
    fs::copy(urdf, folder.path().join("my_robot.urdf")).unwrap();
    run_page("docs/OWN_ROBOT.md", folder.path());
    for file in ["my_robot/robot.toml", "robot.png", "my_walk/scenario.toml", "walk.png"] {
        assert!(folder.path().join(file).is_file(), "{file}");
    }
}

#[test]
fn programs_attach_as_shown() {
    if Command::new("c++").arg("--version").output().is_err() {
        return absent::skip("no C++ compiler");
    }
    // Used, so that cargo builds the library.
    let _ = surefoot_c::surefoot_reader_close;
    let libraries = std::env::current_exe().unwrap().parent().unwrap().to_owned();
    let folder = tempfile::tempdir().unwrap();
    for name in ["c", "tools", "examples"] {
        symlink(root().join(name), folder.path().join(name)).unwrap();
    }
    fs::create_dir(folder.path().join("target")).unwrap();
    symlink(libraries, folder.path().join("target/release")).unwrap();
    let cargo = folder.path().join("cargo");
    fs::write(&cargo, CARGO).unwrap();
    fs::set_permissions(&cargo, fs::Permissions::from_mode(0o755)).unwrap();
    assert_eq!(blocks("docs/ATTACH.md").len(), 2);
    run_page("docs/ATTACH.md", folder.path());
}

/// The pages that a reader may take a command from.
fn pages() -> Vec<String> {
    let mut pages: Vec<String> =
        ["README.md", "CONTRIBUTING.md", "configs/robots/README.md"].map(str::to_owned).into();
    for entry in fs::read_dir(root().join("docs")).unwrap() {
        let name = entry.unwrap().file_name().into_string().unwrap();
        if name.ends_with(".md") {
            pages.push(format!("docs/{name}"));
        }
    }
    pages
}

/// The commands `surefoot ...` in a page, in lines of shell blocks and in the text.
fn commands(text: &str) -> BTreeSet<String> {
    let joined = text.replace("\\\n", " ");
    let shown = Regex::new(r"(?m)(?:`|^|; |& )surefoot ([a-z][^`;#&\n]*)").unwrap();
    shown.captures_iter(&joined).map(|found| found[1].trim().to_owned()).collect()
}

/// What the program says about a command; empty if there is no such command.
fn help(command: &[&str]) -> String {
    let mut program = Command::new(env!("CARGO_BIN_EXE_surefoot"));
    let run = program.args(command).arg("--help").output().unwrap();
    if run.status.success() { String::from_utf8(run.stdout).unwrap() } else { String::new() }
}

#[test]
fn every_command_and_option_that_a_page_names_exists() {
    let option = Regex::new(r"--[a-z][a-z-]*").unwrap();
    let mut helps: BTreeMap<String, String> = BTreeMap::new();
    let mut count = 0;
    let mut absent = Vec::new();
    for page in pages() {
        for command in commands(&text_of(&page)) {
            let words: Vec<&str> = command.split_whitespace().collect();
            let depth = if GROUPS.contains(&words[0]) { 2 } else { 1 };
            let named: Vec<&str> =
                words.iter().take(depth).copied().filter(|word| !is_placeholder(word)).collect();
            let said = helps.entry(named.join(" ")).or_insert_with(|| help(&named));
            count += 1;
            let lacks = option
                .find_iter(&command)
                .any(|option| !said.contains(&format!("{} ", option.as_str())));
            if said.is_empty() || lacks {
                absent.push(format!("{page}: surefoot {command}"));
            }
        }
    }
    assert!(absent.is_empty(), "{absent:#?}");
    assert!(count > 60, "{count} commands found");
}

/// A word that stands for another one, such as `BENCH`.
fn is_placeholder(word: &str) -> bool {
    word.chars().all(|letter| letter.is_ascii_uppercase())
}
