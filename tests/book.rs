//! The book in `docs`: every page is in its summary, no link leads nowhere, and the gallery shows
//! what its script draws. `tools/book.py` checks the links of the built book.

#![allow(clippy::unwrap_used, reason = "a page that cannot be read fails the test")]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use regex::Regex;

/// The gallery's pictures are kept in the repository, so they stay small.
const GALLERY_BYTES_MAX: u64 = 3_000_000;

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
    let mut listed = links(&std::fs::read_to_string(docs().join("SUMMARY.md")).unwrap());
    listed.retain(|link| !link.starts_with("../"));
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
            if !link.starts_with("http") && !path.parent().unwrap().join(&link).exists() {
                dead.push(format!("{page}: {link}"));
            }
        }
    }
    assert!(dead.is_empty(), "{dead:#?}");
}

#[test]
fn the_gallery_shows_what_its_script_draws() {
    let script = std::fs::read_to_string(docs().join("../tools/gallery.py")).unwrap();
    let list = Regex::new(r"(?s)(?:NOT_)?FOUND = \[(.*?)\]").unwrap();
    let name = Regex::new(r#""(\w+)""#).unwrap();
    let lists: String = list.captures_iter(&script).map(|found| found[1].to_owned()).collect();
    let drawn: Vec<String> =
        name.captures_iter(&lists).map(|found| format!("gallery/{}.png", &found[1])).collect();
    let page = std::fs::read_to_string(docs().join("GALLERY.md")).unwrap();
    assert_eq!(links(&page), drawn);
    assert!(drawn.len() >= 20);
    let size = |picture: &String| std::fs::metadata(docs().join(picture)).unwrap().len();
    let sizes: u64 = drawn.iter().map(size).sum();
    assert!(sizes <= GALLERY_BYTES_MAX, "{sizes} bytes");
}
