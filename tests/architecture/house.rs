//! The sources of the crates, parsed, and what every module names.

use std::collections::{BTreeMap, BTreeSet};

use syn::visit::Visit;

use crate::floors::Crate;
use crate::source::Source;

/// A module: index of its crate and path from the crate's root.
pub type ModuleKey = (usize, Vec<String>);

/// A parsed file.
pub struct File {
    /// Path from the repository's root.
    pub path: String,
    /// Index of its crate.
    pub krate: usize,
    /// Its module's path.
    pub module: Vec<String>,
    /// Its content.
    pub text: String,
    /// Its content, parsed.
    pub syntax: syn::File,
}

impl File {
    /// Its name without the folder.
    pub fn name(&self) -> &str {
        self.path.rsplit('/').next().unwrap_or_default()
    }

    /// Whether it is the root of a folder or a crate, which declares modules only.
    pub fn is_root_of_modules(&self) -> bool {
        matches!(self.name(), "mod.rs" | "lib.rs")
    }
}

/// What a name in a module stands for.
#[derive(Debug, Clone)]
pub enum Binding {
    /// A module.
    Module,
    /// An item of the module's file.
    Item,
    /// What `use` brings in: a path, relative to the module.
    Import(Vec<String>),
}

/// The names of one module.
#[derive(Default)]
pub struct Scope {
    /// The index of its file; none for a folder without `mod.rs`.
    pub file: Option<usize>,
    /// What each name stands for: a module and a function may share a name.
    pub names: BTreeMap<String, Vec<Binding>>,
    /// The modules that `use ..::*` opens.
    pub globs: Vec<Vec<String>>,
}

/// One name that a `use` brings in.
pub struct UseLeaf {
    /// The path that is imported.
    pub path: Vec<String>,
    /// The name that it gets; none for `*`.
    pub name: Option<String>,
    /// Its line.
    pub line: usize,
}

/// All sources, without unit tests.
pub struct House {
    /// The crates.
    pub crates: Vec<Crate>,
    /// The files.
    pub files: Vec<File>,
    /// The modules.
    pub scopes: BTreeMap<ModuleKey, Scope>,
}

impl House {
    /// Parses the sources of the crates.
    pub fn new(crates: &[Crate], sources: Vec<Source>) -> House {
        let mut house =
            House { crates: crates.to_vec(), files: vec![], scopes: BTreeMap::default() };
        for source in sources {
            let within = |root: &str| source.path.strip_prefix(root)?.strip_prefix('/');
            let Some(krate) = crates.iter().position(|one| within(one.sources).is_some()) else {
                continue;
            };
            let module = module_of(within(crates[krate].sources).unwrap_or_default());
            let syntax = syn::parse_file(&source.text)
                .unwrap_or_else(|error| panic!("{}: {error}", source.path));
            house.files.push(File { path: source.path, krate, module, text: source.text, syntax });
        }
        house.leave_out_test_files();
        for file in 0..house.files.len() {
            let File { krate, module, syntax, .. } = &house.files[file];
            let key = (*krate, module.clone());
            let mut scopes = vec![];
            read_scope(file, key, &syntax.items, &mut scopes);
            for (key, scope) in scopes {
                house.scopes.entry(key).or_default().merge(scope);
            }
        }
        house.declare_folders();
        house
    }

    /// Removes files that are modules of unit tests only.
    fn leave_out_test_files(&mut self) {
        let mut tests = BTreeSet::new();
        for file in &self.files {
            for item in &file.syntax.items {
                if let syn::Item::Mod(syn::ItemMod { attrs, ident, content: None, .. }) = item
                    && is_test(attrs)
                {
                    let mut module = file.module.clone();
                    module.push(ident.to_string());
                    tests.insert((file.krate, module));
                }
            }
        }
        self.files.retain(|file| {
            !(0..=file.module.len())
                .any(|length| tests.contains(&(file.krate, file.module[..length].to_vec())))
        });
    }

    /// Declares every module in its parent, also where a source set has no `mod.rs`.
    fn declare_folders(&mut self) {
        let keys: Vec<ModuleKey> = self.scopes.keys().cloned().collect();
        for (krate, module) in &keys {
            for length in 0..module.len() {
                self.scopes.entry((*krate, module[..length].to_vec())).or_default();
            }
        }
        let keys: Vec<ModuleKey> = self.scopes.keys().cloned().collect();
        for (krate, module) in keys {
            if let Some((name, parent)) = module.split_last()
                && let Some(scope) = self.scopes.get_mut(&(krate, parent.to_vec()))
            {
                let bindings = scope.names.entry(name.clone()).or_default();
                if !bindings.iter().any(|binding| matches!(binding, Binding::Module)) {
                    bindings.push(Binding::Module);
                }
            }
        }
    }

    /// The folder of a file at the root of its crate: none for files at the root itself.
    pub fn folder(&self, file: usize) -> Option<&str> {
        let File { path, krate, .. } = &self.files[file];
        let inner = &path[self.crates[*krate].sources.len() + 1..];
        inner.split_once('/').map(|(folder, _)| folder)
    }
}

impl Scope {
    fn merge(&mut self, other: Scope) {
        self.file = other.file;
        for (name, mut bindings) in other.names {
            self.names.entry(name).or_default().append(&mut bindings);
        }
        self.globs.extend(other.globs);
    }

    fn bind(&mut self, name: String, binding: Binding) {
        self.names.entry(name).or_default().push(binding);
    }
}

/// The module of a file, from its path within the crate's sources.
fn module_of(inner: &str) -> Vec<String> {
    let mut parts: Vec<String> =
        inner.trim_end_matches(".rs").split('/').map(str::to_owned).collect();
    let is_root = parts.len() == 1 && parts[0] == "lib";
    if is_root || parts.last().is_some_and(|last| last == "mod") {
        parts.pop();
    }
    parts
}

/// Whether attributes leave an item to unit tests.
pub fn is_test(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| match &attribute.meta {
        syn::Meta::Path(path) => path.is_ident("test"),
        syn::Meta::List(list) => list.path.is_ident("cfg") && list.tokens.to_string() == "test",
        syn::Meta::NameValue(_) => false,
    })
}

/// Reads the names of a module and of the modules written within it.
fn read_scope(
    file: usize,
    key: ModuleKey,
    items: &[syn::Item],
    scopes: &mut Vec<(ModuleKey, Scope)>,
) {
    let mut scope = Scope { file: Some(file), ..Scope::default() };
    for item in items {
        if is_test(attributes_of(item)) {
            continue;
        }
        match item {
            syn::Item::Mod(module) => {
                scope.bind(module.ident.to_string(), Binding::Module);
                if let Some((_, inner)) = &module.content {
                    let mut path = key.1.clone();
                    path.push(module.ident.to_string());
                    read_scope(file, (key.0, path), inner, scopes);
                }
            }
            syn::Item::Use(item) => {
                for leaf in leaves(item) {
                    match leaf.name {
                        Some(name) => scope.bind(name, Binding::Import(leaf.path)),
                        None => scope.globs.push(leaf.path),
                    }
                }
            }
            other => {
                if let Some(name) = name_of(other) {
                    scope.bind(name, Binding::Item);
                }
            }
        }
    }
    let mut inner = InnerUses::default();
    inner.visit_items(items);
    for leaf in inner.leaves {
        match leaf.name {
            Some(name) if !scope.names.contains_key(&name) => {
                scope.bind(name, Binding::Import(leaf.path));
            }
            Some(_) => {}
            None => scope.globs.push(leaf.path),
        }
    }
    scopes.push((key, scope));
}

/// The `use` items within the functions of a module; they are taken as the module's.
#[derive(Default)]
struct InnerUses {
    leaves: Vec<UseLeaf>,
}

impl InnerUses {
    fn visit_items(&mut self, items: &[syn::Item]) {
        let is_other = |item: &&syn::Item| {
            !matches!(item, syn::Item::Use(_) | syn::Item::Mod(_)) && !is_test(attributes_of(item))
        };
        for item in items.iter().filter(is_other) {
            self.visit_item(item);
        }
    }
}

impl<'a> Visit<'a> for InnerUses {
    fn visit_item_use(&mut self, item: &'a syn::ItemUse) {
        self.leaves.extend(leaves(item));
    }
}

/// The attributes of an item.
pub fn attributes_of(item: &syn::Item) -> &[syn::Attribute] {
    match item {
        syn::Item::Const(item) => &item.attrs,
        syn::Item::Enum(item) => &item.attrs,
        syn::Item::Fn(item) => &item.attrs,
        syn::Item::Impl(item) => &item.attrs,
        syn::Item::Macro(item) => &item.attrs,
        syn::Item::Mod(item) => &item.attrs,
        syn::Item::Static(item) => &item.attrs,
        syn::Item::Struct(item) => &item.attrs,
        syn::Item::Trait(item) => &item.attrs,
        syn::Item::Type(item) => &item.attrs,
        syn::Item::Union(item) => &item.attrs,
        syn::Item::Use(item) => &item.attrs,
        _ => &[],
    }
}

/// The name that an item defines.
pub fn name_of(item: &syn::Item) -> Option<String> {
    let ident = match item {
        syn::Item::Const(item) => &item.ident,
        syn::Item::Enum(item) => &item.ident,
        syn::Item::Fn(item) => &item.sig.ident,
        syn::Item::Macro(item) => item.ident.as_ref()?,
        syn::Item::Static(item) => &item.ident,
        syn::Item::Struct(item) => &item.ident,
        syn::Item::Trait(item) => &item.ident,
        syn::Item::Type(item) => &item.ident,
        syn::Item::Union(item) => &item.ident,
        _ => return None,
    };
    Some(ident.to_string())
}

/// The names that a `use` brings in.
pub fn leaves(item: &syn::ItemUse) -> Vec<UseLeaf> {
    let mut found = vec![];
    flatten(&item.tree, &mut vec![], &mut found);
    found
}

fn flatten(tree: &syn::UseTree, path: &mut Vec<String>, found: &mut Vec<UseLeaf>) {
    let mut leaf =
        |line: proc_macro2::Span, last: Option<&syn::Ident>, name: Option<&syn::Ident>| {
            let mut path = path.clone();
            path.extend(last.filter(|last| *last != "self").map(ToString::to_string));
            let name = name.map(|name| match name.to_string() {
                own if own == "self" => path.last().cloned().unwrap_or_default(),
                other => other,
            });
            found.push(UseLeaf { path, name, line: line.start().line });
        };
    match tree {
        syn::UseTree::Path(inner) => {
            path.push(inner.ident.to_string());
            flatten(&inner.tree, path, found);
            path.pop();
        }
        syn::UseTree::Name(name) => leaf(name.ident.span(), Some(&name.ident), Some(&name.ident)),
        syn::UseTree::Rename(rename) => {
            leaf(rename.ident.span(), Some(&rename.ident), Some(&rename.rename));
        }
        syn::UseTree::Glob(glob) => leaf(glob.star_token.spans[0], None, None),
        syn::UseTree::Group(group) => {
            for tree in &group.items {
                flatten(tree, path, found);
            }
        }
    }
}
