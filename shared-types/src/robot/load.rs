//! Loads robots: a robot file or a plan's robot block, the URDF and its meshes, all validated.

use std::path::Path;

use glam::{DMat3, DVec3};

use crate::base::digest::Digest;
use crate::base::input_error::InputError;
use crate::base::limits::JOINTS_MAX;
use crate::base::spatial::{Pose, wrap_angle, yaw_of};
use crate::base::text_file::{TextFile, absolute};
use crate::mesh::store::MeshStore;
use crate::plan_format::blocks::RobotBlock;

use crate::robot::exact_meshes::misleading_hulls;
use crate::robot::feet::build_feet;
use crate::robot::joints::{JointRole, joint_role};
use crate::robot::links::{ShapeChoice, build_link, check_moving_masses};
use crate::robot::merge::merge_fixed_links;
use crate::robot::mesh_size::check_mesh_sizes;
use crate::robot::model::{Attachment, Joint, Link, LockedJoint, RobotModel};
use crate::robot::robot_file::{read_robot_file, spec_from_block, spec_from_text};
use crate::robot::spec::RobotSpec;
use crate::robot::spec_check::{allowed_overlaps, check_root, check_spec};
use crate::robot::tree::{TreeLink, sort_links};
use crate::robot::turned_root::turn_root;
use crate::robot::urdf::{Urdf, read_urdf};
use crate::robot::urdf_link::UrdfLink;

/// Feet turned farther out or in than this (rad) do not point ahead.
const FORWARD_TURN_MAX: f64 = std::f64::consts::FRAC_PI_4;

/// Loads the robot that a `robot.toml` describes.
///
/// The file names the `urdf` (relative to it) and the two `[[feet]]` (`name` "left" or "right",
/// `link`, `sole_xyz` in m and `sole_rpy` in rad in the link frame, `polygon` in m in the sole
/// frame), and optionally the `root` link it expects, how the planned root stands in it
/// (`root_rpy`, rad), `exact_meshes` (links whose collision meshes
/// are kept; others become convex hulls, unless these alone would overlap), and the tables
/// `[standing]` (joint positions; joints not listed stand as near to 0 as their limits allow),
/// `[locked]` (joints held still, and with them those that mimic one) and `[effort_limits]` (N m or
/// N, at most the URDF's). A `continuous` joint gets the limits -pi and pi.
///
/// # Errors
/// All that is out of order in the file, the URDF and its meshes, with file, line and element.
pub fn load_robot(robot_toml: &Path) -> Result<RobotModel, InputError> {
    checked_robot(&read_robot_file(robot_toml)?)
}

/// The robot that the text of a robot file describes, as if it stood at `path`.
///
/// # Errors
/// As [`load_robot`].
pub fn robot_from_text(text: String, path: &Path) -> Result<RobotModel, InputError> {
    checked_robot(&spec_from_text(TextFile { path: path.to_owned(), text })?)
}

/// The links of a robot's URDF whose inertia no body has, with their lines: a principal moment
/// exceeds the sum of the other two by more than rounding, and the robot file states no other one.
/// Such an inertia is taken as it is; torques of fast motions are a little off.
///
/// # Errors
/// The URDF cannot be read any more.
pub fn impossible_inertias(robot: &RobotModel) -> Result<Vec<(String, usize)>, InputError> {
    let urdf = read_urdf(&robot.urdf_path, &mut Vec::new())?;
    let is_read = |link: &&UrdfLink| !robot.additions.inertias.contains_key(&link.name);
    let links = urdf.links.iter().filter(is_read).filter(|link| !link.has_possible_inertia());
    Ok(links.map(|link| (link.name.clone(), link.location.line())).collect())
}

fn checked_robot(spec: &RobotSpec) -> Result<RobotModel, InputError> {
    let robot = build_robot(spec)?;
    check_forward(&robot, spec)?;
    Ok(robot)
}

/// Refuses feet that do not point where the root does.
fn check_forward(robot: &RobotModel, spec: &RobotSpec) -> Result<(), InputError> {
    let root_from_links = robot.root_from_links(&robot.standing_q);
    let toes: Vec<f64> = robot
        .feet
        .iter()
        .map(|foot| yaw_of((root_from_links[foot.link] * foot.link_from_sole).rotation))
        .collect();
    let is_apart = |yaw: &f64| wrap_angle(yaw - toes[0]).abs() > FORWARD_TURN_MAX;
    let correction = if toes.iter().any(is_apart) {
        "turn the sole (sole_rpy)".to_owned()
    } else {
        let turn = robot.root_from_urdf_root().rotation.inverse();
        let yaw = wrap_angle(yaw_of(turn) + toes[0]);
        format!("root_rpy = [0, 0, {yaw:.5}] in the robot file turns the root")
    };
    let mut complaints = Vec::new();
    for ((foot, foot_spec), toes) in robot.feet.iter().zip(&spec.feet).zip(&toes) {
        if toes.abs() > FORWARD_TURN_MAX {
            let root = &robot.links[0].name;
            let message = format!(
                "its sole's x points {:.0} degrees off the x axis of the root link '{root}' in the standing posture; both must point ahead: {correction}",
                toes.to_degrees()
            );
            complaints.push(foot_spec.location.error(format!("foot '{}'", foot.name), message));
        }
    }
    InputError::all(complaints)
}

/// Builds the robot that a plan file names. Its URDF is relative to `base_dir`; errors in the block
/// name `plan_path`.
///
/// The standing posture is as near to 0 as the limits allow: a plan does not say it.
///
/// # Errors
/// As [`load_robot`].
pub fn robot_from_block(
    block: &RobotBlock,
    base_dir: &Path,
    plan_path: &Path,
) -> Result<RobotModel, InputError> {
    build_robot(&spec_from_block(block, base_dir, plan_path)?)
}

/// Builds the robot, or finds as many mistakes at once as it can.
fn build_robot(spec: &RobotSpec) -> Result<RobotModel, InputError> {
    let mut complaints = Vec::new();
    let mut urdf = read_urdf(&spec.urdf_path, &mut complaints)?;
    urdf.package_folders.clone_from(&spec.additions.packages);
    let is_read_whole = complaints.is_empty();
    check_spec(&urdf, spec, &mut complaints);
    let roles = joint_roles(&urdf, spec, &mut complaints);
    let mut meshes = MeshStore::default();
    let tree = sort_links(&urdf, &mut complaints);
    let (Some(tree), Some(roles)) = (&tree, roles) else {
        // Meshes may be wrong as well.
        for (at, link) in urdf.links.iter().enumerate() {
            let choice = ShapeChoice::of(&spec.additions, &link.name, false);
            drop(build_link(&urdf, at, choice, &mut meshes, &mut complaints));
        }
        return Err(first_of(complaints, &urdf));
    };
    check_root(&urdf, tree, spec, &mut complaints);
    let known = complaints.len();
    let mut links = build_links(&urdf, tree, spec, &mut meshes, &mut complaints);
    let has_all_shapes = is_read_whole && complaints.len() == known;
    let joints = attach_all(&urdf, tree, roles, &mut links);
    check_count(&urdf, &joints, &mut complaints);
    check_moving_masses(&urdf, tree, &links, &mut complaints);
    // Without all shapes, a sole would be blamed for what its foot lacks.
    let mut foot_complaints = Vec::new();
    let (feet, several) = build_feet(spec, &links, &joints.locked, &mut foot_complaints);
    complaints.extend(foot_complaints.into_iter().filter(|_| has_all_shapes));
    let mut robot = RobotModel {
        name: urdf.name.clone(),
        urdf_path: absolute(&spec.urdf_path),
        robot_path: spec.path.as_deref().map(absolute),
        mesh_paths: Vec::new(),
        standing_q: standing_posture(spec, &joints, &mut complaints),
        links,
        joints: joints.moving,
        feet,
        locked_joints: joints.locked,
        additions: spec.additions.clone(),
        allowed_overlaps: allowed_overlaps(spec, &urdf, &mut complaints),
        digest: Digest::default(),
    };
    InputError::all(complaints)?;
    check_mesh_sizes(&robot, &urdf, tree)?;
    keep_surfaces(&urdf, tree, &mut robot, &mut meshes);
    several.iter().for_each(|parts| parts.join(&mut robot.links));
    merge_fixed_links(&mut robot);
    if let Some(urdf_root_from_root) = spec.urdf_root_from_root {
        turn_root(&mut robot, urdf_root_from_root);
    }
    robot.mesh_paths = meshes.paths();
    robot.digest = Digest::of(&[&urdf.bytes, &spec.bytes, &meshes.digest().0]);
    Ok(robot)
}

/// The complaints, of which there is one at least, as one error.
fn first_of(complaints: Vec<InputError>, urdf: &Urdf) -> InputError {
    match InputError::all(complaints) {
        Err(error) => error,
        Ok(()) => InputError::file(&urdf.source.path, "its joints form no tree"),
    }
}

/// Gives links their exact meshes whose hulls would hide collisions, whichever joints are locked:
/// which links may touch is decided with all of them moving.
fn keep_surfaces(urdf: &Urdf, tree: &[TreeLink], robot: &mut RobotModel, meshes: &mut MeshStore) {
    let exact = |at: usize| {
        let mut complaints = Vec::new();
        let index = tree[at].urdf_link;
        let choice = ShapeChoice::of(&robot.additions, &urdf.links[index].name, true);
        let link = build_link(urdf, index, choice, meshes, &mut complaints);
        complaints.is_empty().then_some(link)
    };
    for (at, shapes) in misleading_hulls(&robot.unlocked(), exact) {
        robot.links[at].shapes = shapes;
    }
}

/// What becomes of each joint of the URDF; `None` where complaints about one were or are made.
fn joint_roles(
    urdf: &Urdf,
    spec: &RobotSpec,
    complaints: &mut Vec<InputError>,
) -> Option<Vec<JointRole>> {
    let mut roles = Vec::with_capacity(urdf.joints.len());
    for (at, joint) in urdf.joints.iter().enumerate() {
        if joint.is_broken {
            continue;
        }
        match joint_role(urdf, at, spec) {
            Ok(role) => roles.push(role),
            Err(mut error) => {
                let others = std::mem::take(&mut error.others);
                complaints.push(error);
                complaints.extend(others);
            }
        }
    }
    (roles.len() == urdf.joints.len()).then_some(roles)
}

fn build_links(
    urdf: &Urdf,
    tree: &[TreeLink],
    spec: &RobotSpec,
    meshes: &mut MeshStore,
    complaints: &mut Vec<InputError>,
) -> Vec<Link> {
    let mut build = |node: &TreeLink| {
        let name = &urdf.links[node.urdf_link].name;
        let exact = spec.exact_meshes.iter().any(|(exact, _)| exact == name);
        let choice = ShapeChoice::of(&spec.additions, name, exact);
        let mut link = build_link(urdf, node.urdf_link, choice, meshes, complaints);
        if let Some(moments) = spec.additions.inertias.get(name) {
            link.inertia = DMat3::from_diagonal(DVec3::from_array(*moments));
        }
        link
    };
    tree.iter().map(&mut build).collect()
}

/// Hangs all links on their parents, and sorts their joints as the tree does.
fn attach_all(urdf: &Urdf, tree: &[TreeLink], roles: Vec<JointRole>, links: &mut [Link]) -> Joints {
    let mut joints = Joints::default();
    let mut roles: Vec<Option<JointRole>> = roles.into_iter().map(Some).collect();
    for (at, node) in tree.iter().enumerate() {
        let Some((parent, joint)) = node.parent else { continue };
        let Some(role) = roles[joint].take() else { continue };
        let parent_from_joint = urdf.joints[joint].parent_from_joint;
        links[at].parent = Some(attach(role, (parent, at), parent_from_joint, &mut joints));
    }
    joints
}

fn check_count(urdf: &Urdf, joints: &Joints, complaints: &mut Vec<InputError>) {
    if joints.moving.len() > JOINTS_MAX {
        let message = format!(
            "{} joints move; at most {JOINTS_MAX} may. Lock some in the robot file; 'surefoot robot add' chooses fingers and heads",
            joints.moving.len()
        );
        complaints.push(InputError::file(&urdf.source.path, message));
    }
}

/// All joints that are not fixed.
#[derive(Default)]
struct Joints {
    moving: Vec<Joint>,
    locked: Vec<LockedJoint>,
}

/// Hangs link `child` on link `parent` by a joint, which joins `joints` unless it is fixed.
fn attach(
    role: JointRole,
    (parent, child): (usize, usize),
    parent_from_joint: Pose,
    joints: &mut Joints,
) -> Attachment {
    match role {
        JointRole::Fixed(parent_from_child) => {
            Attachment { parent, parent_from_joint: parent_from_child, joint: None }
        }
        JointRole::Locked(parent_from_child, mut locked) => {
            locked.joint.child = child;
            joints.locked.push(locked);
            Attachment { parent, parent_from_joint: parent_from_child, joint: None }
        }
        JointRole::Moving(joint) => {
            joints.moving.push(Joint { child, ..joint });
            Attachment { parent, parent_from_joint, joint: Some(joints.moving.len() - 1) }
        }
    }
}

fn standing_posture(
    spec: &RobotSpec,
    joints: &Joints,
    complaints: &mut Vec<InputError>,
) -> Vec<f64> {
    let is_locked = |name: &String| joints.locked.iter().any(|locked| locked.joint.name == *name);
    for (name, (_, location)) in spec.standing.iter().filter(|(name, _)| is_locked(name)) {
        let message = "this joint is locked, or mimics one that is; remove one of the two entries";
        complaints.push(location.error(format!("[standing] '{name}'"), message));
    }
    let mut position = |joint: &Joint| {
        let neutral = 0.0_f64.clamp(joint.lower, joint.upper);
        let Some((position, location)) = spec.standing.get(&joint.name) else { return neutral };
        if !(joint.lower..=joint.upper).contains(position) {
            let limits = format!("{}..{}", joint.lower, joint.upper);
            let advice = if position.abs() > std::f64::consts::TAU {
                "angles are in radians"
            } else {
                "choose one between them"
            };
            complaints.push(location.error(
                format!("[standing] '{}'", joint.name),
                format!("is {position}, outside the joint's limits {limits}; {advice}"),
            ));
        }
        *position
    };
    joints.moving.iter().map(&mut position).collect()
}
