//! Elements of a COLLADA file: ids, children, numbers and errors.

use std::collections::BTreeMap;
use std::str::FromStr;

use roxmltree::Node;

use crate::mesh::file_name::percent_decoded;

/// Characters of the file that an error message repeats at most.
const QUOTED_MAX: usize = 24;

/// The elements below one that others refer to, by tag and id. Of several with the same id the
/// first counts.
pub(crate) struct Ids<'a, 'input>(BTreeMap<(&'a str, &'a str), Node<'a, 'input>>);

impl<'a, 'input> Ids<'a, 'input> {
    pub(crate) fn below(scope: Node<'a, 'input>) -> Self {
        let mut ids = BTreeMap::new();
        for node in scope.descendants() {
            if let Some(id) = node.attribute("id") {
                ids.entry((node.tag_name().name(), id)).or_insert(node);
            }
        }
        Self(ids)
    }

    /// The `<tag>` that an attribute of `from` refers to.
    pub(crate) fn find(
        &self,
        from: Node,
        attribute: &str,
        tag: &str,
    ) -> Result<Node<'a, 'input>, String> {
        let url = from.attribute(attribute).unwrap_or_default();
        let id = url.strip_prefix('#').unwrap_or_default();
        let decoded = percent_decoded(id);
        let found = self.0.get(&(tag, id)).or_else(|| self.0.get(&(tag, decoded.as_str())));
        found.copied().ok_or_else(|| {
            damaged(from, format!("refers to the <{tag}> '{}', which is not there", quoted(url)))
        })
    }
}

pub(crate) fn children<'a, 'input>(
    node: Node<'a, 'input>,
    tag: &str,
) -> impl Iterator<Item = Node<'a, 'input>> {
    node.children().filter(move |child| child.has_tag_name(tag))
}

pub(crate) fn child<'a, 'input>(node: Node<'a, 'input>, tag: &str) -> Option<Node<'a, 'input>> {
    children(node, tag).next()
}

/// The numbers that stand in an element.
pub(crate) fn numbers<T: FromStr>(element: Node) -> Result<Vec<T>, String> {
    let texts = element.children().filter(Node::is_text).filter_map(|text| text.text());
    let input_error =
        |word: &str| damaged(element, format!("holds '{}' for a number", quoted(word)));
    texts
        .flat_map(str::split_ascii_whitespace)
        .map(|word| word.parse().map_err(|_| input_error(word)))
        .collect()
}

pub(crate) fn exactly<const N: usize>(element: Node) -> Result<[f64; N], String> {
    numbers(element)?.try_into().map_err(|numbers: Vec<f64>| {
        damaged(element, format!("holds {} numbers instead of {N}", numbers.len()))
    })
}

pub(crate) fn damaged(element: Node, problem: String) -> String {
    format!("is damaged: a <{}> {problem}; export it again", element.tag_name().name())
}

pub(crate) fn quoted(text: &str) -> String {
    text.chars().take(QUOTED_MAX).collect()
}

pub(crate) fn input<'a, 'input>(
    node: Node<'a, 'input>,
    semantic: &str,
) -> Result<Node<'a, 'input>, String> {
    let mut inputs = children(node, "input");
    let found = inputs.find(|input| input.attribute("semantic") == Some(semantic));
    found.ok_or_else(|| damaged(node, format!("has no <input semantic=\"{semantic}\">")))
}

pub(crate) fn whole_number(
    element: Node,
    attribute: &str,
    default: usize,
) -> Result<usize, String> {
    let Some(text) = element.attribute(attribute) else { return Ok(default) };
    text.trim()
        .parse()
        .map_err(|_| damaged(element, format!("has {attribute}=\"{}\"", quoted(text))))
}

/// An error unless as much was found in an element as its `count` says.
pub(crate) fn check_count(element: Node, found: usize) -> Result<(), String> {
    match whole_number(element, "count", found)? {
        stated if stated != found => {
            Err(damaged(element, format!("says count=\"{stated}\" but holds {found}")))
        }
        _ => Ok(()),
    }
}
