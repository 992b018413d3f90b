//! The floors as text: a table for the screen, and the section of `docs/ARCHITECTURE.md`.

use std::collections::BTreeSet;

use crate::floors::{Crate, allowed};
use crate::house::House;
use crate::rules::Read;

/// Where the section of the document begins.
pub const BEGIN: &str = "<!-- floors -->";
/// Where it ends.
pub const END: &str = "<!-- /floors -->";

/// The first sentence of the documentation of a folder's `mod.rs`.
fn duty(house: &House, krate: usize, folder: &str) -> String {
    let path = format!("{}/{folder}/mod.rs", house.crates[krate].sources);
    let Some(file) = house.files.iter().find(|file| file.path == path) else {
        return String::new();
    };
    let lines = file.text.lines().map_while(|line| line.strip_prefix("//!"));
    let paragraph: Vec<&str> = lines.map(str::trim).take_while(|line| !line.is_empty()).collect();
    let text = paragraph.join(" ");
    text.split_once(". ").map_or(text.as_str(), |(first, _)| first).trim_end_matches('.').to_owned()
}

fn files_in(house: &House, krate: usize, folder: &str) -> Vec<usize> {
    let is_there =
        |&file: &usize| house.files[file].krate == krate && house.folder(file) == Some(folder);
    (0..house.files.len()).filter(is_there).collect()
}

/// The folders of its own crate that a folder imports.
fn imports(read: &Read<'_>, krate: usize, folder: &str) -> BTreeSet<String> {
    let from = files_in(read.house, krate, folder);
    let to = read.arrows.keys().filter(|(file, _)| from.contains(file)).map(|(_, to)| *to);
    to.filter(|&to| read.house.files[to].krate == krate)
        .filter_map(|to| read.house.folder(to))
        .filter(|other| *other != folder)
        .map(str::to_owned)
        .collect()
}

/// The floors of all crates, the highest first, as a table for the screen.
pub fn table(read: &Read<'_>) -> String {
    let house = read.house;
    let mut text = String::new();
    for (at, krate) in house.crates.iter().enumerate().rev() {
        let declared: Vec<&str> = krate.floors.iter().map(|floor| floor.folder).collect();
        let found: BTreeSet<&str> = (0..house.files.len())
            .filter(|&file| house.files[file].krate == at)
            .filter_map(|file| house.folder(file))
            .collect();
        let others = found.iter().filter(|folder| !declared.contains(*folder));
        text += &format!("\n{} ({})\n", krate.name, krate.sources);
        for folder in others.chain(declared.iter().rev()) {
            let files = files_in(house, at, folder).len();
            let imports: Vec<String> = imports(read, at, folder).into_iter().collect();
            text += &format!("  {folder:<15} {files:>3} files  {}\n", duty(house, at, folder));
            text += &format!("  {:<15}   imports {}\n", "", imports.join(", "));
        }
    }
    text
}

/// The folders on which a folder stands directly: those that no other allowed one may import.
fn supports(krate: &Crate, index: usize) -> Vec<&'static str> {
    let below = allowed(krate.floors, index);
    let is_indirect = |folder: &str| {
        below.iter().any(|other| {
            let at = krate.floors.iter().position(|floor| floor.folder == *other);
            at.is_some_and(|at| allowed(krate.floors, at).contains(&folder))
        })
    };
    below.iter().copied().filter(|folder| !is_indirect(folder)).collect()
}

/// Lines of the diagram are broken behind this many characters.
const LINE_LENGTH: usize = 80;

/// Draws the arrows of one crate as chains, from the highest folder down.
struct Chains<'c> {
    krate: &'c Crate,
    /// The folders whose names have been given.
    named: BTreeSet<&'static str>,
    /// The folders whose arrows have been drawn.
    drawn: BTreeSet<usize>,
    text: String,
}

impl Chains<'_> {
    /// A folder's node; one of several crates' `base` needs the crate in its name.
    fn node(&mut self, folder: &'static str) -> String {
        let short = self.krate.sources.split('/').next().unwrap_or_default().replace('-', "_");
        let label = if self.named.insert(folder) { format!("[{folder}]") } else { String::new() };
        format!("{short}_{folder}{label}")
    }

    fn draw_from(&mut self, mut at: usize) {
        let mut line = self.node(self.krate.floors[at].folder);
        while self.drawn.insert(at) {
            let below = supports(self.krate, at);
            let nodes: Vec<String> = below.iter().map(|folder| self.node(folder)).collect();
            if !nodes.is_empty() {
                line += &format!(" --> {}", nodes.join(" & "));
            }
            let [only] = below[..] else { break };
            if line.len() > LINE_LENGTH {
                self.text += &format!("    {line}\n");
                line = self.node(only);
            }
            at = self.krate.floors.iter().position(|floor| floor.folder == only).unwrap_or(at);
        }
        if line.contains("-->") || line.contains('[') {
            self.text += &format!("    {line}\n");
        }
    }
}

/// The diagram: each crate with its folders, and arrows to the folders on which each stands.
pub fn diagram(crates: &[Crate]) -> String {
    let mut text = "```mermaid\nflowchart TD\n".to_owned();
    for krate in crates.iter().rev() {
        let short = krate.sources.split('/').next().unwrap_or_default();
        let (named, drawn) = (BTreeSet::new(), BTreeSet::new());
        let mut chains = Chains { krate, named, drawn, text: String::new() };
        for at in (0..krate.floors.len()).rev() {
            if !chains.drawn.contains(&at) {
                chains.draw_from(at);
            }
        }
        text += &format!("  subgraph {short}_sources [{}]\n{}  end\n", krate.sources, chains.text);
    }
    text + "  src_sources --> planner_sources & controller-sim_sources\n  \
        planner_sources & controller-sim_sources --> shared-types_sources\n```\n"
}

/// The section of the document.
pub fn section(house: &House) -> String {
    diagram(&house.crates)
}

/// A document with its section replaced; none where it has no markers.
pub fn with_section(document: &str, section: &str) -> Option<String> {
    let (before, rest) = document.split_once(BEGIN)?;
    let (_, after) = rest.split_once(END)?;
    Some(format!("{before}{BEGIN}\n{section}{END}{after}"))
}
