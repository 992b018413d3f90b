//! Reads URDF files, versions 1.0 to 1.2, and notes every complaint with its line.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use roxmltree::{Document, Node};

use crate::base::file_kind::FileKind;
use crate::base::input_error::InputError;
use crate::base::text_file::{TEXT_BYTES_MAX, TextFile};
use crate::base::xml::plain_xml;

use crate::robot::element::{Element, is_xacro_text, own_children};
use crate::robot::urdf_joint::{JointType, UrdfJoint, read_joint};
use crate::robot::urdf_link::{UrdfLink, read_link};

/// Most links of a file.
const LINKS_MAX: usize = 4096;
/// The newest version that is read.
const VERSION_MAX: f64 = 1.2;

/// A parsed URDF.
pub(crate) struct Urdf {
    pub(crate) source: TextFile,
    /// The file as it is, for the digest.
    pub(crate) bytes: Vec<u8>,
    /// The robot's name; the file's where it has none.
    pub(crate) name: String,
    /// All links in document order.
    pub(crate) links: Vec<UrdfLink>,
    /// All joints in document order.
    pub(crate) joints: Vec<UrdfJoint>,
    /// The packages that its meshes are in, also those of looks.
    pub(crate) packages: BTreeSet<String>,
    /// Where the user says that packages are.
    pub(crate) package_folders: BTreeMap<String, String>,
}

/// Reads a URDF. Errors in its elements join `complaints`.
///
/// # Errors
/// When it is no URDF.
pub(crate) fn read_urdf(path: &Path, complaints: &mut Vec<InputError>) -> Result<Urdf, InputError> {
    let source = TextFile::read(path, FileKind::Urdf, TEXT_BYTES_MAX)?;
    let plain = plain_xml(&source.text).map_err(|error| {
        let refused = InputError::file(path, error.message).at_line(error.line);
        FileKind::Urdf.needed_instead(path, source.text.as_bytes(), refused)
    })?;
    let bytes = source.text.into_bytes();
    let source = TextFile { path: source.path, text: plain };
    let document = Document::parse(&source.text).map_err(|error| {
        let is_xml = source.text.trim_start_matches('\u{feff}').trim_start().starts_with('<');
        let not_xml = || "is not XML; a URDF begins with <robot name=\"...\">".to_owned();
        let message = if is_xml { error.to_string() } else { not_xml() };
        let refused = InputError::file(path, message).at_line(error.pos().row as usize);
        FileKind::Urdf.needed_instead(path, &bytes, refused)
    })?;
    let root = document.root_element();
    check_root(&source, root)?;
    let (mut links, mut joints) = (Vec::new(), Vec::new());
    let mut names = BTreeSet::new();
    for node in own_children(root) {
        let tag = node.tag_name().name();
        let mut element = Element { source: &source, node, complaints: &mut *complaints };
        if matches!(tag, "link" | "joint") {
            check_name(&mut element, &mut names);
        }
        match tag {
            "link" => links.push(read_link(&mut element)),
            "joint" => joints.push(read_joint(&mut element)),
            _ => check_tag(&mut element),
        }
    }
    if links.is_empty() {
        return Err(InputError::file(path, "holds no links"));
    }
    if links.len() > LINKS_MAX {
        let message = format!("has {} links; at most {LINKS_MAX} are supported", links.len());
        return Err(InputError::file(path, message));
    }
    let packages = packages(root);
    let stem = path.file_stem().map(|stem| stem.to_string_lossy().into_owned());
    let name = root.attribute("name").filter(|name| !name.trim().is_empty()).map(str::to_owned);
    let name = name.or(stem).unwrap_or_default();
    let package_folders = BTreeMap::new();
    let mut urdf = Urdf { bytes, name, links, joints, packages, package_folders, source };
    urdf.remove_floating_base();
    Ok(urdf)
}

impl Urdf {
    /// Removes a bare root link that carries the robot by a floating joint: every robot floats.
    fn remove_floating_base(&mut self) {
        let is_child = |name: &str| self.joints.iter().any(|joint| joint.child == name);
        let Some(link) = self.links.iter().position(|link| !is_child(&link.name)) else { return };
        let root = &self.links[link];
        let is_bare = root.mass == 0.0 && root.collisions.is_empty();
        let mut below = (0..self.joints.len()).filter(|at| self.joints[*at].parent == root.name);
        let (Some(joint), None) = (below.next(), below.next()) else { return };
        if is_bare && self.joints[joint].joint_type == JointType::Floating {
            self.links.remove(link);
            self.joints.remove(joint);
        }
    }
}

/// Refuses a file that is no URDF, and says what it is.
fn check_root(source: &TextFile, root: Node) -> Result<(), InputError> {
    let tag = root.tag_name().name();
    let refuse = |node: Node, message: &str| {
        let location = source.location(node.range().start);
        Err(location.error(format!("<{}>", node.tag_name().name()), message))
    };
    let is_macro = |node: &Node| {
        let is_xacro = |namespace: &str| namespace.ends_with("xacro");
        node.tag_name().namespace().is_some_and(is_xacro)
    };
    let ending = source.path.extension().unwrap_or_default();
    let expand = "is a xacro file; expand it first: xacro FILE > robot.urdf";
    if let Some(node) = root.descendants().find(is_macro) {
        return refuse(node, expand);
    }
    if ending.eq_ignore_ascii_case("xacro")
        && root.descendants().any(|node| node.attributes().any(|it| is_xacro_text(it.value())))
    {
        return refuse(root, expand);
    }
    let includes = |node: &Node| node.is_element() && node.tag_name().name() == "include";
    if let Some(node) = root.children().find(includes) {
        return refuse(node, "includes another file, which is not read; write its content here");
    }
    let is_robot = |node: &Node| node.is_element() && node.tag_name().name() == "robot";
    if let Some(node) = root.children().find(is_robot) {
        return refuse(node, "stands in another <robot>; write the links and joints of one robot");
    }
    match tag {
        "robot" => {}
        "sdf" | "gazebo" => return refuse(root, "is an SDF file, not a URDF; export a URDF"),
        "mujoco" => return refuse(root, "is an MJCF file, not a URDF; export a URDF"),
        _ => return refuse(root, "is not a URDF; its root must be <robot>"),
    }
    match root.attribute("version").map(|text| (text, text.trim().parse::<f64>())) {
        Some((text, version)) if !matches!(version, Ok(version) if version <= VERSION_MAX) => {
            refuse(root, &format!("is URDF {text}; versions up to {VERSION_MAX} are read"))
        }
        _ => Ok(()),
    }
}

/// Refuses a link or joint without a name or with that of another one.
fn check_name(element: &mut Element, names: &mut BTreeSet<(String, String)>) {
    let node = element.node;
    let tag = node.tag_name().name();
    match node.attribute("name").map(str::trim) {
        None | Some("") => element.input_error(node, "has no name"),
        Some(name) if !names.insert((tag.to_owned(), name.to_owned())) => {
            element.input_error(node, format!("another {tag} has the same name"));
        }
        Some(_) => {}
    }
}

/// Refuses an element that looks like a link or joint, and is none.
fn check_tag(element: &mut Element) {
    element.check_child(element.node, &["link", "joint", "material", "transmission", "sensor"]);
}

/// The packages that files of the robot are in.
fn packages(root: Node) -> BTreeSet<String> {
    let files = root.descendants().filter_map(|node| node.attribute("filename"));
    files.filter_map(package_of).map(|(package, _)| package.to_owned()).collect()
}

/// The package that a file name states, and the path in it.
pub(crate) fn package_of(name: &str) -> Option<(&str, &str)> {
    let name = name.trim();
    let path = name.strip_prefix("package://").or_else(|| name.strip_prefix("model://"))?;
    path.trim_start_matches('/').split_once(['/', '\\'])
}
