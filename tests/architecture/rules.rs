//! The rules about files, folders and imports. Each returns the offences against it.

use std::collections::BTreeSet;

use crate::floors::allowed;
use crate::graph;
use crate::house::{House, ModuleKey, name_of};
use crate::imports::{self, Arrows, Mention};
use crate::resolve::{Found, Target};

/// A house with its imports.
pub struct Read<'a> {
    /// The sources.
    pub house: &'a House,
    /// Every path in them.
    pub mentions: &'a [Mention],
    /// What each path names.
    pub resolved: &'a [Vec<Found>],
    /// The imports between files.
    pub arrows: Arrows<'a>,
}

impl Read<'_> {
    fn path(&self, file: usize) -> &str {
        &self.house.files[file].path
    }

    fn is_same_crate(&self, from: usize, to: usize) -> bool {
        self.house.files[from].krate == self.house.files[to].krate
    }
}

/// No two files import each other.
pub fn circles(read: &Read<'_>) -> Vec<String> {
    let circles = graph::circles(&read.arrows);
    circles.iter().map(|circle| graph::shown(read.house, &read.arrows, circle)).collect()
}

/// The root of a crate's sources holds its root files alone.
pub fn loose_files(read: &Read<'_>) -> Vec<String> {
    let mut offences = vec![];
    for (index, file) in read.house.files.iter().enumerate() {
        let krate = &read.house.crates[file.krate];
        if read.house.folder(index).is_none() && !krate.root_files.contains(&file.name()) {
            offences.push(format!("{}: at the root of {}", file.path, krate.sources));
        }
    }
    offences
}

/// Every folder stands in its crate's table.
pub fn undeclared_folders(read: &Read<'_>) -> Vec<String> {
    let mut offences = BTreeSet::new();
    for (index, file) in read.house.files.iter().enumerate() {
        let krate = &read.house.crates[file.krate];
        if let Some(folder) = read.house.folder(index)
            && !krate.floors.iter().any(|floor| floor.folder == folder)
        {
            offences
                .insert(format!("{}/{folder}: not in tests/architecture/floors.rs", krate.sources));
        }
    }
    offences.into_iter().collect()
}

/// Every folder of the table exists.
pub fn absent_folders(read: &Read<'_>) -> Vec<String> {
    let house = read.house;
    let mut offences = vec![];
    for (at, krate) in house.crates.iter().enumerate() {
        for floor in krate.floors {
            let mut files = (0..house.files.len()).filter(|&file| house.files[file].krate == at);
            if !files.any(|file| house.folder(file) == Some(floor.folder)) {
                offences.push(format!("{}/{}: no such folder", krate.sources, floor.folder));
            }
        }
    }
    offences
}

/// A folder imports only what its table allows.
pub fn upward_arrows(read: &Read<'_>) -> Vec<String> {
    let house = read.house;
    let mut offences = vec![];
    for (&(from, to), mention) in &read.arrows {
        let (Some(folder), Some(other)) = (house.folder(from), house.folder(to)) else { continue };
        if folder == other || !read.is_same_crate(from, to) {
            continue;
        }
        let floors = house.crates[house.files[from].krate].floors;
        let at = |folder| floors.iter().position(|floor| floor.folder == folder);
        if let (Some(below), Some(above)) = (at(folder), at(other))
            && !allowed(floors, below).contains(&other)
        {
            let way = if above > below { "upward" } else { "undeclared" };
            offences.push(format!(
                "{}:{}: {way}: {folder} imports {other}: {}",
                read.path(from),
                mention.line,
                mention.shown()
            ));
        }
    }
    offences
}

/// `mod.rs` and `lib.rs` declare and re-export only.
pub fn roots_that_define(read: &Read<'_>) -> Vec<String> {
    let mut offences = vec![];
    for file in read.house.files.iter().filter(|file| file.is_root_of_modules()) {
        for item in &file.syntax.items {
            let what = match item {
                syn::Item::Use(_) => continue,
                syn::Item::Mod(module) if module.content.is_none() => continue,
                item if crate::house::is_test(crate::house::attributes_of(item)) => continue,
                syn::Item::Mod(module) => format!("mod {}", module.ident),
                syn::Item::Impl(_) => "an impl".to_owned(),
                item => name_of(item).unwrap_or_else(|| "an item".to_owned()),
            };
            offences.push(format!("{}: defines {what}", file.path));
        }
    }
    offences
}

/// No file takes a name from a `mod.rs` or `lib.rs` above it: it names the sibling instead.
pub fn imports_through_parents(read: &Read<'_>) -> Vec<String> {
    let house = read.house;
    let mut offences = BTreeSet::new();
    for (mention, found) in read.mentions.iter().zip(read.resolved) {
        let file = &house.files[mention.file];
        let is_own = ["crate", "super", "self"].contains(&mention.path[0].as_str());
        if file.is_root_of_modules() || !(mention.is_use || is_own) {
            continue;
        }
        let is_above = |krate: usize, module: &[String]| {
            krate == file.krate
                && module.len() < file.module.len()
                && file.module.starts_with(module)
        };
        for one in found {
            let defined = match &one.target {
                Target::Item(to, _) => Some(&house.files[*to]),
                Target::Module(_) => None,
            };
            let by_root = defined.filter(|to| to.is_root_of_modules()).map(|to| to.module.clone());
            let is_root = |key: &&ModuleKey| {
                let file = house.scopes.get(key).and_then(|scope| scope.file);
                file.is_some_and(|file| house.files[file].is_root_of_modules())
            };
            let roots = one.through.iter().filter(is_root);
            let mut modules = roots
                .map(|key| (key.0, key.1.clone()))
                .chain(by_root.map(|module| (file.krate, module)));
            if let Some((_, module)) = modules.find(|(krate, module)| is_above(*krate, module)) {
                let root = if module.is_empty() { "its lib.rs" } else { "its mod.rs" };
                offences.insert((&file.path, mention.line, root, mention.shown()));
            }
        }
    }
    offences
        .into_iter()
        .map(|(path, line, root, shown)| format!("{path}:{line}: through {root}: {shown}"))
        .collect()
}

/// Only the pipeline imports both possibility and motion.
pub fn both_stages(read: &Read<'_>) -> Vec<String> {
    let mut offences = vec![];
    for (index, file) in read.house.files.iter().enumerate() {
        let krate = &read.house.crates[file.krate];
        let imports = |folder: &str| {
            let mut to = read.arrows.range((index, 0)..=(index, usize::MAX)).map(|(key, _)| key.1);
            to.any(|to| read.is_same_crate(index, to) && read.house.folder(to) == Some(folder))
        };
        let own = read.house.folder(index);
        let knows = |folder: &str| own == Some(folder) || imports(folder);
        let is_free = own == Some("pipeline") || file.module.is_empty();
        if krate.sources == "planner/src" && !is_free && knows("possibility") && knows("motion") {
            offences.push(format!("{}: knows possibility and motion", file.path));
        }
    }
    offences
}

/// No file of the planner but its roots and its builder imports the planner as a whole.
pub fn imports_of_the_planner(read: &Read<'_>) -> Vec<String> {
    let mut offences = vec![];
    for (&(from, to), mention) in &read.arrows {
        let is_planner = read.path(to) == "planner/src/pipeline/planner.rs";
        if is_planner
            && read.is_same_crate(from, to)
            && !read.house.files[from].is_root_of_modules()
            && read.path(from) != "planner/src/pipeline/planner_builder.rs"
        {
            offences.push(format!(
                "{}:{}: imports the planner as a whole: {}",
                read.path(from),
                mention.line,
                mention.shown()
            ));
        }
    }
    offences
}

/// Reads a house and hands it to a function.
pub fn with_read<R>(house: &House, apply: impl FnOnce(&Read<'_>) -> R) -> R {
    let mentions = imports::mentions(house);
    let resolved = imports::resolved(house, &mentions);
    let arrows = imports::arrows(house, &mentions, &resolved);
    apply(&Read { house, mentions: &mentions, resolved: &resolved, arrows })
}
