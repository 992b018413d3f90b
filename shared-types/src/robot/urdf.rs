//! Reads URDF files: `urdf-rs` supplies the types, this module the strictness and the line numbers
//! that it lacks.
//!
//! `urdf-rs` drops what it cannot read as a number, converts a missing `<limit>` into 0..0 and
//! knows no lines. So the raw XML is walked first, and every number of every link and joint is
//! checked where it stands.

use std::path::Path;

use roxmltree::{Document, Node};

use crate::base::input_error::InputError;
use crate::base::text_file::{
    FileLocation, TEXT_BYTES_MAX, TextFile, check_numbers, check_xml_depth,
};

/// Most links of a robot.
const LINKS_MAX: usize = 4096;
/// The joint types of the URDF specification.
const JOINT_TYPES: [&str; 6] =
    ["revolute", "continuous", "prismatic", "fixed", "floating", "planar"];
/// The elements that are shapes.
const SHAPES: [&str; 5] = ["box", "sphere", "cylinder", "capsule", "mesh"];
/// Which attributes hold how many numbers.
const NUMERIC: [(&str, &[(&str, usize)]); 12] = [
    ("origin", &[("xyz", 3), ("rpy", 3)]),
    ("axis", &[("xyz", 3)]),
    ("box", &[("size", 3)]),
    ("sphere", &[("radius", 1)]),
    ("cylinder", &[("radius", 1), ("length", 1)]),
    ("capsule", &[("radius", 1), ("length", 1)]),
    ("mesh", &[("scale", 3)]),
    ("mass", &[("value", 1)]),
    ("inertia", &[("ixx", 1), ("ixy", 1), ("ixz", 1), ("iyy", 1), ("iyz", 1), ("izz", 1)]),
    ("limit", &[("lower", 1), ("upper", 1), ("effort", 1), ("velocity", 1)]),
    ("mimic", &[("multiplier", 1), ("offset", 1)]),
    ("color", &[("rgba", 4)]),
];

/// A parsed URDF, with what `urdf-rs` does not keep.
pub(crate) struct Urdf {
    /// The file.
    pub(crate) source: TextFile,
    /// All links and joints in document order.
    pub(crate) robot: urdf_rs::Robot,
    /// Where each of `robot.links` stands.
    pub(crate) link_locations: Vec<FileLocation>,
    /// Where each of `robot.joints` stands, and what its `<limit>` says.
    pub(crate) joint_facts: Vec<JointFacts>,
}

/// What the raw XML of a joint says.
pub(crate) struct JointFacts {
    pub(crate) location: FileLocation,
    /// Whether it has a `<limit>`.
    pub(crate) has_limit: bool,
}

/// Reads a URDF and checks everything that can be checked element by element.
pub(crate) fn read_urdf(path: &Path) -> Result<Urdf, InputError> {
    let source = TextFile::read(path, TEXT_BYTES_MAX)?;
    check_xml_depth(&source.text)
        .map_err(|(offset, message)| source.location(offset).error("<robot>", message))?;
    let document = Document::parse(&source.text).map_err(|error| {
        InputError::file(path, error.to_string()).at_line(error.pos().row as usize)
    })?;
    let root = document.root_element();
    if root.tag_name().name() != "robot" {
        return Err(element_location(&source, root).error(
            format!("<{}>", root.tag_name().name()),
            "is not a URDF; its root must be <robot>",
        ));
    }
    let link_locations = named_elements(&source, root, "link")?;
    let joint_locations = named_elements(&source, root, "joint")?;
    if link_locations.is_empty() {
        return Err(InputError::file(path, "holds no links"));
    }
    if link_locations.len() > LINKS_MAX {
        return Err(InputError::file(
            path,
            format!("has {} links; at most {LINKS_MAX} are supported", link_locations.len()),
        ));
    }
    let joint_facts: Vec<JointFacts> = children(root, "joint")
        .zip(joint_locations)
        .map(|(joint, location)| joint_facts(joint, location))
        .collect::<Result<_, _>>()?;
    for element in children(root, "link").chain(children(root, "joint")) {
        element
            .descendants()
            .filter(Node::is_element)
            .try_for_each(|node| check_element_numbers(&source, element, node))?;
    }
    let robot = urdf_rs::read_from_string(&essence(&source.text, root))
        .map_err(|error| FileLocation::file(path).error("<robot>", error.to_string()))?;
    if robot.links.len() != link_locations.len() || robot.joints.len() != joint_facts.len() {
        return Err(InputError::file(path, "links and joints must stand directly below <robot>"));
    }
    Ok(Urdf { link_locations, joint_facts, robot, source })
}

/// The text without what planning does not read, in which real files hold much that `urdf-rs` does
/// not expect: looks, sensors, transmissions, what other programs add in namespaces of their own or
/// inside a shape.
fn essence(text: &str, root: Node) -> String {
    let is_passed_over = |node: &Node| {
        let parent = node.parent_element().map_or("", |parent| parent.tag_name().name());
        let tag = node.tag_name().name();
        let is_wanted = match parent {
            "robot" => matches!(tag, "link" | "joint"),
            "link" => matches!(tag, "inertial" | "collision"),
            _ => !SHAPES.contains(&parent),
        };
        node.is_element() && (is_foreign(root, *node) || !is_wanted)
    };
    let mut kept = String::with_capacity(text.len());
    let mut end = 0;
    for passed_over in root.descendants().filter(is_passed_over).map(|node| node.range()) {
        if passed_over.start >= end {
            kept.push_str(&text[end..passed_over.start]);
            end = passed_over.end;
        }
    }
    kept + &text[end..]
}

fn is_foreign(root: Node, node: Node) -> bool {
    node.tag_name().namespace() != root.tag_name().namespace()
}

fn children<'a, 'input>(
    root: Node<'a, 'input>,
    tag: &'static str,
) -> impl Iterator<Item = Node<'a, 'input>> {
    root.children().filter(move |node| node.has_tag_name(tag) && !is_foreign(root, *node))
}

fn element_location(source: &TextFile, node: Node) -> FileLocation {
    source.location(node.range().start)
}

/// The places of all elements with this tag, whose names must be there and unique.
fn named_elements(
    source: &TextFile,
    root: Node,
    tag: &'static str,
) -> Result<Vec<FileLocation>, InputError> {
    let mut names = std::collections::BTreeSet::new();
    children(root, tag)
        .map(|node| {
            let location = element_location(source, node);
            match node.attribute("name") {
                None | Some("") => Err(location.error(format!("<{tag}>"), "has no name")),
                Some(name) if !names.insert(name) => Err(location
                    .error(format!("{tag} '{name}'"), format!("another {tag} has the same name"))),
                Some(_) => Ok(location),
            }
        })
        .collect()
}

fn joint_facts(joint: Node, location: FileLocation) -> Result<JointFacts, InputError> {
    let name = joint.attribute("name").unwrap_or_default();
    let input_error = |message: String| Err(location.error(format!("joint '{name}'"), message));
    match joint.attribute("type") {
        None => return input_error("has no type".into()),
        Some(kind) if !JOINT_TYPES.contains(&kind) => {
            return input_error(format!(
                "has the unknown type '{kind}'; use one of {JOINT_TYPES:?}"
            ));
        }
        Some(_) => {}
    }
    for end in ["parent", "child"] {
        if !joint.children().any(|node| node.has_tag_name(end) && node.has_attribute("link")) {
            return input_error(format!("has no <{end} link=\"...\">"));
        }
    }
    let limit = joint.children().find(|node| node.has_tag_name("limit"));
    if limit.is_some_and(|limit| !limit.has_attribute("velocity")) {
        return input_error("its <limit> has no velocity; state it".into());
    }
    Ok(JointFacts { has_limit: limit.is_some(), location })
}

fn check_element_numbers(source: &TextFile, owner: Node, node: Node) -> Result<(), InputError> {
    let tag = node.tag_name().name();
    let attributes = NUMERIC
        .iter()
        .filter(|(name, _)| *name == tag)
        .flat_map(|(_, attributes)| attributes.iter());
    for (attribute, count) in attributes {
        let Some(text) = node.attribute(*attribute) else { continue };
        if let Err(message) = check_attribute(text, *count) {
            let owner_name = format!(
                "{} '{}'",
                owner.tag_name().name(),
                owner.attribute("name").unwrap_or_default()
            );
            return Err(element_location(source, node)
                .error(owner_name, format!("<{tag} {attribute}=\"{text}\"> {message}")));
        }
    }
    Ok(())
}

fn check_attribute(text: &str, count: usize) -> Result<(), String> {
    let numbers: Vec<f64> = text
        .split_whitespace()
        .map(str::parse)
        .collect::<Result<_, _>>()
        .map_err(|_| format!("is not {count} number{}", if count == 1 { "" } else { "s" }))?;
    if numbers.len() != count {
        return Err(format!("holds {} numbers instead of {count}", numbers.len()));
    }
    check_numbers("it", &numbers)
}
