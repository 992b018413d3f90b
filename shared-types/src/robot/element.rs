//! A link or joint of a URDF while it is read: each of its complaints names it and a line.

use roxmltree::Node;

use crate::base::input_error::InputError;
use crate::base::text_file::{TextFile, check_numbers};

/// Names that differ from a known one by this many letters are taken for mistypings of it.
const TYPO_LETTERS_MAX: usize = 2;
/// The parts of a link that no other element may hold, and what each contains.
const PARTS: [(&str, &str); 2] = [("collision", "geometry"), ("inertial", "mass")];
/// The element of a simulator's additions, which may describe bodies of its own.
const SIMULATOR: &str = "gazebo";

/// A link or joint, and the errors in the file so far.
pub(crate) struct Element<'a, 'input> {
    pub(crate) source: &'a TextFile,
    pub(crate) node: Node<'a, 'input>,
    pub(crate) complaints: &'a mut Vec<InputError>,
}

impl<'a, 'input> Element<'a, 'input> {
    /// Records an error at the location of `at`.
    pub(crate) fn input_error(&mut self, at: Node, message: impl Into<String>) {
        let tag = self.node.tag_name().name();
        let owner = match self.node.attribute("name") {
            Some(name) => format!("{tag} '{name}'"),
            None => format!("<{tag}>"),
        };
        self.complaints.push(self.source.location(at.range().start).error(owner, message));
    }

    /// The child with a tag, of which there may be one.
    pub(crate) fn child(&mut self, of: Node<'a, 'input>, tag: &str) -> Option<Node<'a, 'input>> {
        let mut children = own_children(of).filter(|child| child.tag_name().name() == tag);
        let (first, second) = (children.next(), children.next());
        if let Some(second) = second {
            let owner = of.tag_name().name();
            self.input_error(second, format!("has a second <{tag}> in its <{owner}>; keep one"));
        }
        first
    }

    /// Refuses children whose tag looks like a known one, and is none.
    pub(crate) fn check_children(&mut self, of: Node<'a, 'input>, known: &[&str]) {
        own_children(of).for_each(|child| self.check_child(child, known));
    }

    /// Refuses an element whose tag looks like a known one, and is none, and one that is passed
    /// over although it holds a part of a link.
    pub(crate) fn check_child(&mut self, child: Node<'a, 'input>, known: &[&str]) {
        let tag = child.tag_name().name();
        if !known.contains(&tag) && tag != SIMULATOR {
            self.check_holds_no_part(child);
        }
        if let Some(meant) = mistyped(tag, known) {
            self.input_error(child, format!("has a <{tag}>; is <{meant}> meant?"));
        }
    }

    /// Refuses an element of another program, or one in the wrong place, that holds a shape or a
    /// mass.
    fn check_holds_no_part(&mut self, passed_over: Node<'a, 'input>) {
        let is_part = |node: &Node| {
            let name = node.tag_name().name();
            let content = PARTS.iter().find(|(part, _)| *part == name).map(|(_, content)| *content);
            own_children(*node).any(|child| Some(child.tag_name().name()) == content)
        };
        let Some(part) = passed_over.descendants().find(is_part) else { return };
        let tag = |node: Node| node.tag_name().name().to_owned();
        let holder = part.parent_element().map(tag).unwrap_or_default();
        let message =
            format!("has a <{}> in a <{holder}>, where it is part of no link; move it", tag(part));
        self.input_error(part, message);
    }

    /// Refuses attributes whose name looks like a known one, and is none.
    pub(crate) fn check_attributes(&mut self, of: Node<'a, 'input>, known: &[&str]) {
        for attribute in of.attributes().filter(|attribute| attribute.namespace().is_none()) {
            if let Some(meant) = mistyped(attribute.name(), known) {
                let (tag, name) = (of.tag_name().name(), attribute.name());
                self.input_error(of, format!("<{tag} {name}=...> is unknown; is {meant} meant?"));
            }
        }
    }

    /// The `N` numbers of an attribute; `None` where it is not there or wrong.
    pub(crate) fn numbers<const N: usize>(
        &mut self,
        of: Node<'a, 'input>,
        attribute: &str,
    ) -> Option<[f64; N]> {
        let text = of.attribute(attribute)?;
        let numbers = parse::<N>(text).and_then(|numbers| {
            check_numbers("it", &numbers)?;
            Ok(numbers)
        });
        self.noted(of, attribute, text, numbers)
    }

    /// A limit: infinite where the number means that there is none.
    pub(crate) fn limit(&mut self, of: Node<'a, 'input>, attribute: &str) -> Option<f64> {
        let text = of.attribute(attribute)?;
        let number = parse::<1>(text).and_then(|[number]| match number {
            number if number.is_nan() => Err("it holds NaN; state a number".into()),
            number if number.abs() >= UNLIMITED_MIN => Ok(f64::INFINITY.copysign(number)),
            number => Ok(number),
        });
        self.noted(of, attribute, text, number)
    }

    /// The numbers of an attribute that must be there.
    pub(crate) fn required<const N: usize>(
        &mut self,
        of: Node<'a, 'input>,
        attribute: &str,
    ) -> Option<[f64; N]> {
        if !of.has_attribute(attribute) {
            self.input_error(of, format!("<{}> has no {attribute}", of.tag_name().name()));
        }
        self.numbers(of, attribute)
    }

    fn noted<T>(
        &mut self,
        of: Node,
        attribute: &str,
        text: &str,
        read: Result<T, String>,
    ) -> Option<T> {
        let tag = of.tag_name().name();
        read.map_err(|message| {
            let expand = if is_xacro_text(text) { "; expand the xacro file first" } else { "" };
            self.input_error(of, format!("<{tag} {attribute}=\"{text}\"> {message}{expand}"));
        })
        .ok()
    }
}

/// Limits of this size or more mean that there is none.
const UNLIMITED_MIN: f64 = crate::base::text_file::NUMBER_MAX;

/// Whether a text holds a macro that only xacro expands.
pub(crate) fn is_xacro_text(text: &str) -> bool {
    text.contains("${") || text.contains("$(")
}

/// The child elements in the namespace of their parent; others belong to other programs.
pub(crate) fn own_children<'a, 'input>(
    of: Node<'a, 'input>,
) -> impl Iterator<Item = Node<'a, 'input>> {
    let own = of.tag_name().namespace();
    of.children().filter(move |child| child.is_element() && child.tag_name().namespace() == own)
}

fn parse<const N: usize>(text: &str) -> Result<[f64; N], String> {
    let plural = if N == 1 { "" } else { "s" };
    let numbers: Vec<f64> = text
        .split_whitespace()
        .map(str::parse)
        .collect::<Result<_, _>>()
        .map_err(|_| format!("is not {N} number{plural}"))?;
    let count = numbers.len();
    numbers.try_into().map_err(|_| format!("holds {count} numbers instead of {N}"))
}

/// The known name that another one is nearly, if it is not known itself.
fn mistyped<'k>(name: &str, known: &[&'k str]) -> Option<&'k str> {
    if known.contains(&name) {
        return None;
    }
    known.iter().copied().find(|known| {
        let letters = if known.len() < 6 { 1 } else { TYPO_LETTERS_MAX };
        name.eq_ignore_ascii_case(known) || edit_distance(name, known) <= letters
    })
}

/// The fewest letters to insert, remove or replace that turn one name into another.
fn edit_distance(a: &str, b: &str) -> usize {
    let b: Vec<char> = b.chars().collect();
    let mut row: Vec<usize> = (0..=b.len()).collect();
    for (i, letter) in a.chars().enumerate() {
        let mut diagonal = row[0];
        row[0] = i + 1;
        for (j, other) in b.iter().enumerate() {
            let replaced = diagonal + usize::from(letter != *other);
            diagonal = row[j + 1];
            row[j + 1] = replaced.min(diagonal + 1).min(row[j] + 1);
        }
    }
    row[b.len()]
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn misspellings_are_distinguished_from_other_names() {
        let known = ["origin", "collision", "ixx", "iyy"];
        for (name, meant) in [("orgin", "origin"), ("Collision", "collision"), ("yy", "iyy")] {
            assert_eq!(mistyped(name, &known), Some(meant), "{name}");
        }
        for name in ["origin", "sensor", "contact", "stiffness"] {
            assert_eq!(mistyped(name, &known), None, "{name}");
        }
    }
}
