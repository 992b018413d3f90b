//! Which file names what of which other file.

use std::collections::BTreeMap;

use proc_macro2::{TokenStream, TokenTree};
use syn::visit::{self, Visit};

use crate::house::{House, ModuleKey, attributes_of, is_test, leaves};
use crate::resolve::{Found, Target};

/// A path as it stands in a file.
pub struct Mention {
    /// Index of the file.
    pub file: usize,
    /// Its line.
    pub line: usize,
    /// The path.
    pub path: Vec<String>,
    /// The module in which it stands.
    pub module: ModuleKey,
    /// Whether `use` names it.
    pub is_use: bool,
}

impl Mention {
    /// The path as it is written.
    pub fn shown(&self) -> String {
        self.path.join("::")
    }
}

/// The first mention by which a file imports another one.
pub type Arrows<'a> = BTreeMap<(usize, usize), &'a Mention>;

/// Every path in every file.
pub fn mentions(house: &House) -> Vec<Mention> {
    let mut found = vec![];
    for (index, file) in house.files.iter().enumerate() {
        let module = (file.krate, file.module.clone());
        let mut reader = Reader { file: index, module, line: 1, found: &mut found };
        for item in &file.syntax.items {
            reader.visit_item(item);
        }
    }
    found
}

/// What the mentions name, in their order.
pub fn resolved(house: &House, mentions: &[Mention]) -> Vec<Vec<Found>> {
    mentions.iter().map(|one| house.resolve(&one.module, &one.path)).collect()
}

/// The file of a target.
pub fn file_of(house: &House, target: &Target) -> Option<usize> {
    match target {
        Target::Item(file, _) => Some(*file),
        Target::Module(key) => house.scopes.get(key).and_then(|scope| scope.file),
    }
}

/// The arrows between files, down to the file that defines the imported item.
pub fn arrows<'a>(house: &House, mentions: &'a [Mention], resolved: &[Vec<Found>]) -> Arrows<'a> {
    let mut arrows = Arrows::default();
    for (mention, found) in mentions.iter().zip(resolved) {
        for to in found.iter().filter_map(|one| file_of(house, &one.target)) {
            // The path to a crate's root alone names nothing.
            let is_root = house.files[to].module.is_empty();
            if to != mention.file && !(is_root && is_path_to_root(mention)) {
                arrows.entry((mention.file, to)).or_insert(mention);
            }
        }
    }
    arrows
}

fn is_path_to_root(mention: &Mention) -> bool {
    mention.path.iter().all(|part| part == "crate" || part == "super")
}

/// Collects the paths of a file.
struct Reader<'f> {
    file: usize,
    module: ModuleKey,
    line: usize,
    found: &'f mut Vec<Mention>,
}

impl Reader<'_> {
    fn add(&mut self, path: Vec<String>, line: usize, is_use: bool) {
        let module = self.module.clone();
        self.found.push(Mention { file: self.file, line, path, module, is_use });
    }

    /// The paths in a macro's tokens: names joined by `::`.
    fn read_tokens(&mut self, tokens: TokenStream) {
        let mut path: Vec<String> = vec![];
        let (mut colons, mut line) = (0, 1);
        let mut ended = vec![];
        for token in tokens {
            match token {
                TokenTree::Ident(ident) => {
                    if colons != 2 {
                        ended.push((std::mem::take(&mut path), line));
                        line = ident.span().start().line;
                    }
                    path.push(ident.to_string());
                    colons = 0;
                }
                TokenTree::Punct(punct) if punct.as_char() == ':' && !path.is_empty() => {
                    colons += 1
                }
                TokenTree::Group(group) => {
                    ended.push((std::mem::take(&mut path), line));
                    colons = 0;
                    self.read_tokens(group.stream());
                }
                TokenTree::Literal(literal) => self.read_literal(&literal),
                TokenTree::Punct(_) => {
                    ended.push((std::mem::take(&mut path), line));
                    colons = 0;
                }
            }
        }
        ended.push((path, line));
        for (path, line) in ended {
            if !path.is_empty() {
                self.add(path, line, false);
            }
        }
    }

    /// A path in a string, as in `#[serde(with = "crate::a::b")]`.
    fn read_literal(&mut self, literal: &proc_macro2::Literal) {
        let text = literal.to_string();
        let inner = text.trim_matches('"');
        let parts: Vec<String> = inner.split("::").map(str::to_owned).collect();
        let is_name = |part: &String| {
            !part.is_empty() && part.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
        };
        if parts.len() > 1 && parts.iter().all(is_name) {
            self.add(parts, literal.span().start().line, false);
        }
    }
}

impl<'a> Visit<'a> for Reader<'_> {
    fn visit_item(&mut self, item: &'a syn::Item) {
        if !is_test(attributes_of(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_mod(&mut self, item: &'a syn::ItemMod) {
        let Some((_, items)) = &item.content else { return };
        self.module.1.push(item.ident.to_string());
        for item in items {
            self.visit_item(item);
        }
        self.module.1.pop();
    }

    fn visit_item_use(&mut self, item: &'a syn::ItemUse) {
        for leaf in leaves(item) {
            self.add(leaf.path, leaf.line, true);
        }
    }

    fn visit_path(&mut self, path: &'a syn::Path) {
        let parts: Vec<String> = path.segments.iter().map(|one| one.ident.to_string()).collect();
        let line = path.segments.first().map_or(self.line, |one| one.ident.span().start().line);
        if parts != ["self"] && parts != ["Self"] {
            self.add(parts, line, false);
        }
        visit::visit_path(self, path);
    }

    fn visit_vis_restricted(&mut self, _: &'a syn::VisRestricted) {}

    fn visit_macro(&mut self, item: &'a syn::Macro) {
        self.visit_path(&item.path);
        self.read_tokens(item.tokens.clone());
    }

    fn visit_attribute(&mut self, attribute: &'a syn::Attribute) {
        if let syn::Meta::List(list) = &attribute.meta
            && !list.path.is_ident("cfg")
        {
            self.read_tokens(list.tokens.clone());
        }
    }
}
