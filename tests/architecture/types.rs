//! Types: how many fields they have, and in how many files their methods stand.

use std::collections::{BTreeMap, BTreeSet};

use crate::house::{House, ModuleKey, attributes_of, is_test};
use crate::resolve::Target;

/// A type with behaviour has at most this many fields.
pub const FIELDS_MAX: usize = 12;
/// The `impl` blocks of a type stand in at most this many files.
pub const IMPL_FILES_MAX: usize = 2;

/// The properties of a type.
#[derive(Default)]
struct Type {
    line: usize,
    fields: usize,
    has_methods: bool,
    is_record: bool,
    impl_files: BTreeSet<usize>,
}

/// The types by the file that defines them and their name.
#[derive(Default)]
struct Types(BTreeMap<(usize, String), Type>);

impl Types {
    fn read(house: &House) -> Types {
        let mut types = Types::default();
        for (index, file) in house.files.iter().enumerate() {
            types.read_items(house, index, &(file.krate, file.module.clone()), &file.syntax.items);
        }
        types
    }

    fn read_items(&mut self, house: &House, file: usize, module: &ModuleKey, items: &[syn::Item]) {
        for item in items.iter().filter(|item| !is_test(attributes_of(item))) {
            match item {
                syn::Item::Mod(inner) => {
                    if let Some((_, items)) = &inner.content {
                        let path = [&module.1[..], &[inner.ident.to_string()]].concat();
                        self.read_items(house, file, &(module.0, path), items);
                    }
                }
                syn::Item::Struct(item) => {
                    let entry = self.0.entry((file, item.ident.to_string())).or_default();
                    entry.fields = item.fields.len();
                    entry.is_record = is_record(item);
                    entry.line = item.ident.span().start().line;
                }
                syn::Item::Impl(item) => self.read_impl(house, file, module, item),
                _ => {}
            }
        }
    }

    fn read_impl(&mut self, house: &House, file: usize, module: &ModuleKey, item: &syn::ItemImpl) {
        let mut own = &*item.self_ty;
        while let syn::Type::Reference(inner) = own {
            own = &inner.elem;
        }
        let syn::Type::Path(path) = own else { return };
        let parts: Vec<String> =
            path.path.segments.iter().map(|one| one.ident.to_string()).collect();
        let takes_self = item.items.iter().any(|inner| match inner {
            syn::ImplItem::Fn(function) => function.sig.receiver().is_some(),
            _ => false,
        });
        for found in house.resolve(module, &parts) {
            if let Target::Item(defined, name) = found.target {
                let entry = self.0.entry((defined, name)).or_default();
                entry.impl_files.insert(file);
                entry.has_methods |= item.trait_.is_none() && takes_self;
            }
        }
    }
}

/// Whether a type is a plain record: a message, a row of a report, a configuration.
fn is_record(item: &syn::ItemStruct) -> bool {
    let mut is_written = item.ident.to_string().ends_with("Config");
    for attribute in item.attrs.iter().filter(|one| one.path().is_ident("derive")) {
        // Unknown forms of an attribute derive nothing here.
        let _ = attribute.parse_nested_meta(|inner| {
            let last = inner.path.segments.last().map(|one| one.ident.to_string());
            let records = ["Pod", "Serialize", "Deserialize"];
            is_written |= last.is_some_and(|last| records.contains(&last.as_str()));
            Ok(())
        });
    }
    is_written
}

/// Types with behaviour that have too many fields.
pub fn wide_types(house: &House) -> Vec<String> {
    let mut offences = vec![];
    for ((file, name), one) in Types::read(house).0 {
        if one.has_methods && !one.is_record && one.fields > FIELDS_MAX {
            let path = &house.files[file].path;
            offences.push(format!("{path}:{}: {name} has {} fields", one.line, one.fields));
        }
    }
    offences
}

/// Types whose `impl` blocks stand in too many files.
pub fn scattered_types(house: &House) -> Vec<String> {
    let mut offences = vec![];
    for ((file, name), one) in Types::read(house).0 {
        if one.impl_files.len() > IMPL_FILES_MAX {
            let path = |file: &usize| house.files[*file].path.as_str();
            let files: Vec<&str> = one.impl_files.iter().map(path).collect();
            offences.push(format!("{}: impl of {name} in {}", path(&file), files.join(", ")));
        }
    }
    offences
}
