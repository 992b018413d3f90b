//! The joints of a URDF.

use glam::DVec3;
use roxmltree::Node;

use crate::base::spatial::Pose;
use crate::base::text_file::FileLocation;

use crate::robot::element::Element;
use crate::robot::urdf_link::read_origin;

/// The joint types of the URDF specification.
const JOINT_TYPES: [(&str, JointType); 6] = [
    ("revolute", JointType::Revolute),
    ("continuous", JointType::Continuous),
    ("prismatic", JointType::Prismatic),
    ("fixed", JointType::Fixed),
    ("floating", JointType::Floating),
    ("planar", JointType::Planar),
];
/// The elements of a joint that say nothing to a quasi-static planner, and those that do.
const CHILDREN: [&str; 9] = [
    "origin",
    "parent",
    "child",
    "axis",
    "limit",
    "mimic",
    "dynamics",
    "calibration",
    "safety_controller",
];
const LIMITS: [&str; 7] =
    ["lower", "upper", "effort", "velocity", "acceleration", "deceleration", "jerk"];

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum JointType {
    Revolute,
    Continuous,
    Prismatic,
    Fixed,
    Floating,
    Planar,
}

/// A joint as it is written.
pub(crate) struct UrdfJoint {
    pub(crate) name: String,
    pub(crate) location: FileLocation,
    pub(crate) joint_type: JointType,
    pub(crate) parent: String,
    pub(crate) child: String,
    pub(crate) parent_from_joint: Pose,
    pub(crate) axis: DVec3,
    pub(crate) limit: Option<Limit>,
    pub(crate) mimic: Option<Mimic>,
    /// Whether complaints about it are known already.
    pub(crate) is_broken: bool,
}

impl UrdfJoint {
    /// Whether the file states what it connects.
    pub(crate) fn has_ends(&self) -> bool {
        !self.parent.is_empty() && !self.child.is_empty()
    }
}

/// A `<limit>`. Limits that are not stated are `None`; numbers that mean "none" are infinite.
pub(crate) struct Limit {
    pub(crate) location: FileLocation,
    /// From the lower to the upper position, where one of them is stated.
    pub(crate) range: Option<(f64, f64)>,
    pub(crate) effort: Option<f64>,
    pub(crate) velocity: Option<f64>,
    pub(crate) acceleration: Option<f64>,
}

pub(crate) struct Mimic {
    pub(crate) joint: String,
    pub(crate) multiplier: f64,
    pub(crate) offset: f64,
}

/// Reads the joint that `element` stands for.
pub(crate) fn read_joint(element: &mut Element) -> UrdfJoint {
    let node = element.node;
    let known = element.complaints.len();
    element.check_children(node, &CHILDREN);
    let joint_type = read_type(element, node);
    let parent_from_joint = read_origin(element, node);
    let [parent, child] = ["parent", "child"].map(|end| read_end(element, node, end));
    let mut joint = UrdfJoint {
        name: node.attribute("name").unwrap_or_default().to_owned(),
        location: element.source.location(node.range().start),
        joint_type,
        parent,
        child,
        parent_from_joint,
        axis: DVec3::X,
        limit: None,
        mimic: None,
        is_broken: false,
    };
    // What does not move needs no axis and no limits.
    let moves = JointType::Fixed != joint_type && JointType::Floating != joint_type;
    if moves {
        joint.axis = read_axis(element, node);
        joint.limit =
            element.child(node, "limit").map(|limit| read_limit(element, limit, joint_type));
        joint.mimic = element.child(node, "mimic").and_then(|mimic| read_mimic(element, mimic));
    }
    joint.is_broken = element.complaints.len() > known;
    joint
}

fn read_type(element: &mut Element, node: Node) -> JointType {
    let names = JOINT_TYPES.map(|(name, _)| name);
    let Some(text) = node.attribute("type") else {
        element.input_error(node, format!("has no type; use one of {names:?}"));
        return JointType::Revolute;
    };
    match JOINT_TYPES.iter().find(|(name, _)| *name == text) {
        Some((_, joint_type)) => *joint_type,
        None => {
            element
                .input_error(node, format!("has the unknown type '{text}'; use one of {names:?}"));
            JointType::Revolute
        }
    }
}

fn read_end<'a, 'input>(
    element: &mut Element<'a, 'input>,
    node: Node<'a, 'input>,
    end: &str,
) -> String {
    match element.child(node, end).and_then(|end| end.attribute("link")) {
        Some(link) => link.to_owned(),
        None => {
            element.input_error(node, format!("has no <{end} link=\"...\">"));
            String::new()
        }
    }
}

fn read_axis<'a, 'input>(element: &mut Element<'a, 'input>, node: Node<'a, 'input>) -> DVec3 {
    let Some(axis) = element.child(node, "axis") else { return DVec3::X };
    element.check_attributes(axis, &["xyz"]);
    let Some(xyz) = element.required(axis, "xyz") else { return DVec3::X };
    match DVec3::from_array(xyz).try_normalize() {
        Some(unit) => unit,
        None => {
            element.input_error(axis, format!("its axis {xyz:?} has no direction"));
            DVec3::X
        }
    }
}

fn read_limit<'a, 'input>(
    element: &mut Element<'a, 'input>,
    limit: Node<'a, 'input>,
    joint_type: JointType,
) -> Limit {
    element.check_attributes(limit, &LIMITS);
    let mut number = |attribute: &str| element.limit(limit, attribute);
    let range = match joint_type {
        JointType::Continuous => None,
        _ => match (number("lower"), number("upper")) {
            (None, None) => None,
            (lower, upper) => Some((lower.unwrap_or(0.0), upper.unwrap_or(0.0))),
        },
    };
    let (effort, velocity) = (number("effort"), number("velocity"));
    let [acceleration, deceleration, jerk] =
        ["acceleration", "deceleration", "jerk"].map(&mut number);
    let stated = [("acceleration", acceleration), ("deceleration", deceleration), ("jerk", jerk)];
    for (name, number) in stated {
        if number.is_some_and(|number| number <= 0.0) {
            element.input_error(limit, format!("<limit {name}> must be positive"));
        }
    }
    if jerk.is_some_and(f64::is_finite) {
        element.input_error(limit, "<limit jerk> is not kept by the planner; remove it");
    }
    // A slower braking bounds the motion as a whole: every motion ends.
    let acceleration = acceleration.into_iter().chain(deceleration).reduce(f64::min);
    let location = element.source.location(limit.range().start);
    Limit { location, range, effort, velocity, acceleration }
}

/// A mimic without a leader's name mimics nothing.
fn read_mimic<'a, 'input>(
    element: &mut Element<'a, 'input>,
    mimic: Node<'a, 'input>,
) -> Option<Mimic> {
    element.check_attributes(mimic, &["joint", "multiplier", "offset"]);
    let joint = mimic.attribute("joint").filter(|name| !name.trim().is_empty())?.to_owned();
    let mut number = |attribute: &str| element.numbers(mimic, attribute).map(|[number]| number);
    let (multiplier, offset) = (number("multiplier"), number("offset"));
    Some(Mimic { joint, multiplier: multiplier.unwrap_or(1.0), offset: offset.unwrap_or(0.0) })
}
