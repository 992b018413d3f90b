//! The book in `docs`: every page is in its summary, no link leads nowhere, and every command that
//! the pages for newcomers show ends as they say. Blocks marked `sh notest` need other software.

#![allow(clippy::print_stdout, reason = "a test prints what it runs")]
#![allow(clippy::unwrap_used, reason = "a page that cannot be read fails the test")]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};
use std::process::Command;

use regex::Regex;

/// The pages whose commands are run, each in a folder of its own.
const RUN: [&str; 2] = ["START.md", "FAILURES.md"];

fn docs() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("docs")
}

/// The pages below a folder, relative to it.
fn pages(folder: &Path) -> BTreeSet<String> {
    let mut found = BTreeSet::new();
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap().to_str().unwrap().to_owned();
        if path.is_dir() {
            found.extend(pages(&path).iter().map(|page| format!("{name}/{page}")));
        } else if name.ends_with(".md") && name != "SUMMARY.md" {
            found.insert(name);
        }
    }
    found
}

/// The targets of the links in a page, without anchors.
fn links(text: &str) -> Vec<String> {
    let link = Regex::new(r"\]\(([^)#\s]+)(?:#[^)]*)?\)").unwrap();
    link.captures_iter(text).map(|found| found[1].to_owned()).collect()
}

#[test]
fn the_summary_lists_every_page_once() {
    let listed = links(&std::fs::read_to_string(docs().join("SUMMARY.md")).unwrap());
    let once: BTreeSet<String> = listed.iter().cloned().collect();
    assert_eq!(once.len(), listed.len(), "a page is listed twice");
    assert_eq!(once, pages(&docs()));
}

#[test]
fn no_link_leads_nowhere() {
    let mut dead = Vec::new();
    for page in pages(&docs()) {
        let path = docs().join(&page);
        for link in links(&std::fs::read_to_string(&path).unwrap()) {
            // The gallery is drawn by tools/gallery.sh.
            let is_elsewhere = link.starts_with("http") || link.starts_with("gallery/");
            if !is_elsewhere && !path.parent().unwrap().join(&link).exists() {
                dead.push(format!("{page}: {link}"));
            }
        }
    }
    assert!(dead.is_empty(), "{dead:#?}");
}

/// The blocks of shell commands in a page that can be run anywhere.
fn commands(page: &str) -> Vec<String> {
    let block = Regex::new(r"(?ms)^```sh\n(.*?)^```$").unwrap();
    let text = std::fs::read_to_string(docs().join(page)).unwrap();
    block.captures_iter(&text).map(|found| found[1].to_owned()).collect()
}

#[test]
fn every_command_for_newcomers_runs() {
    let program = Path::new(env!("CARGO_BIN_EXE_surefoot")).parent().unwrap();
    let path = format!("{}:{}", program.display(), std::env::var("PATH").unwrap());
    for page in RUN {
        let folder = tempfile::tempdir().unwrap();
        let blocks = commands(page);
        assert!(blocks.len() >= 2, "{page}");
        for block in blocks {
            println!("{block}");
            let run = Command::new("sh")
                .args(["-e", "-c", &block])
                .current_dir(folder.path())
                .env("PATH", &path)
                .env("XDG_CACHE_HOME", env!("CARGO_TARGET_TMPDIR"))
                .output()
                .unwrap();
            let [out, err] =
                [run.stdout, run.stderr].map(|text| String::from_utf8_lossy(&text).into_owned());
            assert!(run.status.success(), "{page}: {block}{out}{err}");
        }
    }
}

#[test]
fn the_gallery_shows_what_its_script_draws() {
    let script = std::fs::read_to_string(docs().join("../tools/gallery.sh")).unwrap();
    let names = script.split_once("found=(").unwrap().1.split_once(')').unwrap().0;
    let mut drawn: Vec<String> = names.split_whitespace().map(str::to_owned).collect();
    drawn.push("no_way_wall".to_owned());
    let page = std::fs::read_to_string(docs().join("GALLERY.md")).unwrap();
    let shown: Vec<String> =
        links(&page).iter().map(|link| link.replace("gallery/", "").replace(".png", "")).collect();
    assert_eq!(shown, drawn);
    assert!(shown.len() >= 20);
}
