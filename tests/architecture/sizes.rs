//! The size of files, functions and lines.

use syn::visit::{self, Visit};

use crate::house::{House, attributes_of, is_test};
use crate::lexer::{Kind, pieces};
use crate::source::Source;

/// A file has fewer lines than this.
pub const FILE_LINES_END: usize = 600;
/// A function has at most this many lines, from `fn` to its closing brace.
pub const FUNCTION_LINES_MAX: usize = 70;
/// A line has at most this many characters.
pub const COLUMNS_MAX: usize = 100;

/// Files that are too long.
pub fn long_files(house: &House) -> Vec<String> {
    let mut offences = vec![];
    for file in &house.files {
        let lines = file.text.lines().count();
        if lines >= FILE_LINES_END {
            offences.push(format!("{}: {lines} lines", file.path));
        }
    }
    offences
}

/// A function's name, its first line and its number of lines.
#[derive(Debug, PartialEq, Eq)]
pub struct Function {
    /// Its name.
    pub name: String,
    /// The line of its `fn`, from 1.
    pub line: usize,
    /// Its lines, from `fn` to the closing brace.
    pub lines: usize,
}

/// The functions of a file, without unit tests.
pub fn functions(syntax: &syn::File) -> Vec<Function> {
    let mut reader = Functions::default();
    reader.visit_file(syntax);
    reader.0
}

#[derive(Default)]
struct Functions(Vec<Function>);

impl Functions {
    fn add(&mut self, signature: &syn::Signature, block: &syn::Block) {
        let line = signature.fn_token.span.start().line;
        let end = block.brace_token.span.close().end().line;
        self.0.push(Function { name: signature.ident.to_string(), line, lines: end + 1 - line });
    }
}

impl<'a> Visit<'a> for Functions {
    fn visit_item(&mut self, item: &'a syn::Item) {
        if !is_test(attributes_of(item)) {
            visit::visit_item(self, item);
        }
    }

    fn visit_item_fn(&mut self, item: &'a syn::ItemFn) {
        self.add(&item.sig, &item.block);
        visit::visit_item_fn(self, item);
    }

    fn visit_impl_item_fn(&mut self, item: &'a syn::ImplItemFn) {
        self.add(&item.sig, &item.block);
        visit::visit_impl_item_fn(self, item);
    }

    fn visit_trait_item_fn(&mut self, item: &'a syn::TraitItemFn) {
        if let Some(block) = &item.default {
            self.add(&item.sig, block);
        }
        visit::visit_trait_item_fn(self, item);
    }
}

/// Functions that are too long.
pub fn long_functions(house: &House) -> Vec<String> {
    let mut offences = vec![];
    for file in &house.files {
        for Function { name, line, lines } in functions(&file.syntax) {
            if lines > FUNCTION_LINES_MAX {
                offences.push(format!("{}:{line}: fn {name}: {lines} lines", file.path));
            }
        }
    }
    offences
}

/// Lines of code or comment that are too long. A string literal may cross the last column, and so
/// may a comment of one word, such as an address.
pub fn long_lines(source: &Source) -> Vec<String> {
    let lengths: Vec<usize> = source.text.lines().map(|line| line.chars().count()).collect();
    let mut is_long: Vec<bool> = lengths.iter().map(|&length| length > COLUMNS_MAX).collect();
    if is_long.contains(&true) {
        for piece in pieces(&source.text) {
            let end = piece.column + piece.text.chars().count();
            let crosses = piece.column < COLUMNS_MAX && end > COLUMNS_MAX;
            let words = piece.text.trim_start_matches(['/', '!', ' ']).split(' ').count();
            if crosses && (piece.kind == Kind::Literal || piece.kind == Kind::Comment && words == 1)
            {
                is_long[piece.line - 1] = false;
            }
        }
    }
    let long = is_long.iter().zip(&lengths).enumerate().filter(|(_, (is_long, _))| **is_long);
    long.map(|(at, (_, length))| format!("{}:{}: {length} columns", source.path, at + 1)).collect()
}

/// Lines of prose that are too long. Tables, code blocks and lines of one word are free.
pub fn long_prose(source: &Source) -> Vec<String> {
    let mut offences = vec![];
    let mut is_block = false;
    for (at, line) in source.text.lines().enumerate() {
        let trimmed = line.trim_start();
        is_block ^= trimmed.starts_with("```");
        let length = line.chars().count();
        let last_space = line.rfind(' ').map_or(0, |end| line[..end].chars().count());
        let is_free = is_block || trimmed.starts_with('|') || last_space == 0;
        if length > COLUMNS_MAX && !is_free {
            offences.push(format!("{}:{}: {length} columns", source.path, at + 1));
        }
    }
    offences
}
