//! Follows a path, through re-exports, down to the file that defines what it names.

use crate::house::{Binding, House, ModuleKey};

/// Re-exports longer than this are taken for a circle of `use` items.
const DEPTH_MAX: usize = 24;

/// What a path names.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Target {
    /// A module.
    Module(ModuleKey),
    /// An item: index of its file, and its name there.
    Item(usize, String),
}

/// A target, and the modules whose `use` items lead to it.
#[derive(Debug, Clone)]
pub struct Found {
    /// What the path names.
    pub target: Target,
    /// The modules whose `use` items were followed, in order.
    pub through: Vec<ModuleKey>,
}

impl House {
    /// What a path names in a module: nothing where it leads out of the crates, several things
    /// where a module and an item share a name.
    pub fn resolve(&self, from: &ModuleKey, path: &[String]) -> Vec<Found> {
        self.resolve_at(from, path, 0)
    }

    fn resolve_at(&self, from: &ModuleKey, path: &[String], depth: usize) -> Vec<Found> {
        let Some((first, rest)) = path.split_first() else { return vec![] };
        if depth > DEPTH_MAX {
            return vec![];
        }
        let module = |key: ModuleKey| vec![Found { target: Target::Module(key), through: vec![] }];
        let begin = match first.as_str() {
            "crate" => module((from.0, vec![])),
            "self" => module(from.clone()),
            "super" => match from.1.split_last() {
                Some((_, parent)) => module((from.0, parent.to_vec())),
                None => vec![],
            },
            "Self" => vec![],
            name => match self.lookup(from, name, depth) {
                found if !found.is_empty() => found,
                _ => match self.crates.iter().position(|one| one.name == name) {
                    Some(krate) if !rest.is_empty() => module((krate, vec![])),
                    _ => vec![],
                },
            },
        };
        rest.iter().fold(begin, |found, name| self.descend(found, name, depth))
    }

    /// One step along a path. An item stays what it is: what follows is associated with it.
    fn descend(&self, found: Vec<Found>, name: &str, depth: usize) -> Vec<Found> {
        let has_module = found.iter().any(|one| matches!(one.target, Target::Module(_)));
        let mut next = vec![];
        for Found { target, through } in found {
            let Target::Module(key) = target else {
                if !has_module {
                    next.push(Found { target, through });
                }
                continue;
            };
            let inner = if name == "super" {
                self.resolve_at(&key, &["super".to_owned()], depth + 1)
            } else {
                self.lookup(&key, name, depth)
            };
            next.extend(inner.into_iter().map(|one| Found {
                target: one.target,
                through: [&through[..], &one.through].concat(),
            }));
        }
        next
    }

    /// What a name stands for in a module.
    fn lookup(&self, key: &ModuleKey, name: &str, depth: usize) -> Vec<Found> {
        let Some(scope) = self.scopes.get(key) else { return vec![] };
        let followed = |mut found: Vec<Found>| {
            for one in &mut found {
                one.through.insert(0, key.clone());
            }
            found
        };
        let mut found = vec![];
        for binding in scope.names.get(name).into_iter().flatten() {
            match binding {
                Binding::Module => {
                    let mut path = key.1.clone();
                    path.push(name.to_owned());
                    let target = Target::Module((key.0, path));
                    found.push(Found { target, through: vec![] });
                }
                Binding::Item => {
                    let item = scope.file.map(|file| Target::Item(file, name.to_owned()));
                    found.extend(item.map(|target| Found { target, through: vec![] }));
                }
                // `use name::..` would otherwise follow itself.
                Binding::Import(path) if depth < DEPTH_MAX && path[0] != name => {
                    found.extend(followed(self.resolve_at(key, path, depth + 1)));
                }
                Binding::Import(path) => {
                    let is_child =
                        scope.names[name].iter().any(|one| matches!(one, Binding::Module));
                    found.extend(followed(self.resolve_namesake(key, path, is_child)));
                }
            }
        }
        if found.is_empty() && !scope.names.contains_key(name) && depth < DEPTH_MAX {
            for glob in &scope.globs {
                let opened = self.resolve_at(key, glob, depth + 1);
                let modules =
                    opened.into_iter().filter(|one| matches!(one.target, Target::Module(_)));
                found.extend(followed(self.descend(modules.collect(), name, depth + 1)));
            }
        }
        found
    }

    /// A path whose first name is also the name that it is imported as: a child module, else
    /// another crate.
    fn resolve_namesake(&self, key: &ModuleKey, path: &[String], is_child: bool) -> Vec<Found> {
        let module = if is_child {
            (key.0, [&key.1[..], &path[..1]].concat())
        } else if let Some(krate) = self.crates.iter().position(|one| one.name == path[0]) {
            (krate, vec![])
        } else {
            return vec![];
        };
        let root = Found { target: Target::Module(module), through: vec![] };
        path[1..].iter().fold(vec![root], |found, name| self.descend(found, name, 1))
    }
}
