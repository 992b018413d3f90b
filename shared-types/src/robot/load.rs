//! Loads robots: a robot file or a plan's robot block, the URDF and its meshes, all validated.

use std::path::Path;

use crate::base::digest::Digest;
use crate::base::input_error::InputError;
use crate::base::limits::JOINTS_MAX;
use crate::base::spatial::Pose;
use crate::base::spatial::yaw_of;
use crate::base::text_file::absolute;
use crate::mesh::store::MeshStore;
use crate::plan_format::blocks::RobotBlock;

use crate::robot::exact_meshes::misleading_hulls;
use crate::robot::joints::{JointRole, check_names, joint_role, parent_from_joint};
use crate::robot::links::{build_link, check_moving_masses};
use crate::robot::model::{Attachment, Foot, Joint, Link, LockedJoint, RobotModel};
use crate::robot::robot_file::{read_robot_file, spec_from_block};
use crate::robot::sole::check_sole;
use crate::robot::spec::{FootSpec, RobotSpec};
use crate::robot::tree::{TreeLink, sort_links};
use crate::robot::urdf::{Urdf, read_urdf};

/// Feet turned farther out or in than this (rad) do not point ahead.
const FORWARD_TURN_MAX: f64 = std::f64::consts::FRAC_PI_4;

/// Loads the robot that a `robot.toml` describes.
///
/// The file names the `urdf` (relative to it) and the two `[[feet]]` (`name` "left" or "right",
/// `link`, `sole_xyz` in m and `sole_rpy` in rad in the link frame, `polygon` in m in the sole
/// frame), and optionally the `root` link it expects, `exact_meshes` (links whose collision meshes
/// are kept; others become convex hulls, unless these alone would overlap), and the tables
/// `[standing]` (joint positions; joints not listed stand as near to 0 as their limits allow),
/// `[locked]` (joints held still, and with them those that mimic one) and `[effort_limits]` (N m or
/// N, at most the URDF's). A `continuous` joint gets the limits -pi and pi.
///
/// # Errors
/// The first thing in the file, the URDF or a mesh that is out of order, with its file, line and
/// element.
pub fn load_robot(robot_toml: &Path) -> Result<RobotModel, InputError> {
    let spec = read_robot_file(robot_toml)?;
    let robot = build_robot(&spec)?;
    check_forward(&robot, &spec)?;
    Ok(robot)
}

/// Refuses a foot that does not point where the root does.
fn check_forward(robot: &RobotModel, spec: &RobotSpec) -> Result<(), InputError> {
    let root_from_links = robot.root_from_links(&robot.standing_q);
    for (foot, foot_spec) in robot.feet.iter().zip(&spec.feet) {
        let toes = yaw_of((root_from_links[foot.link] * foot.link_from_sole).rotation);
        if toes.abs() > FORWARD_TURN_MAX {
            let root = &robot.links[0].name;
            let message = format!(
                "its sole's x points {:.0} degrees off the x axis of the root link '{root}' in the standing posture; both must point ahead: \
                 turn the sole, or hang the root on a new root link by a fixed joint that turns it",
                toes.to_degrees()
            );
            return Err(foot_spec.location.error(format!("foot '{}'", foot.name), message));
        }
    }
    Ok(())
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

fn build_robot(spec: &RobotSpec) -> Result<RobotModel, InputError> {
    let urdf = read_urdf(&spec.urdf_path)?;
    check_names(&urdf, "[standing]", &spec.standing)?;
    check_names(&urdf, "[locked]", &spec.locked)?;
    check_names(&urdf, "[effort_limits]", &spec.effort_limits)?;
    check_names(&urdf, "[accelerations]", &spec.accelerations)?;
    let tree = sort_links(&urdf)?;
    check_root(&urdf, &tree, spec)?;
    let mut meshes = MeshStore::default();
    let (links, joints) = build_bodies(&urdf, &tree, spec, &mut meshes)?;
    check_moving_masses(&urdf, &tree, &links)?;
    let feet = build_feet(spec, &links)?;
    let mut robot = RobotModel {
        name: urdf.robot.name.clone(),
        urdf_path: absolute(&spec.urdf_path),
        standing_q: standing_posture(spec, &joints)?,
        links,
        joints: joints.moving,
        feet,
        locked_joints: joints.locked,
        digest: Digest::default(),
    };
    keep_surfaces(&urdf, &tree, &mut robot, &mut meshes);
    robot.digest = Digest::of(&[urdf.source.text.as_bytes(), &spec.bytes, &meshes.digest().0]);
    Ok(robot)
}

/// Gives links their exact meshes whose hulls would hide collisions, whichever joints are locked:
/// which links may touch is decided with all of them moving.
fn keep_surfaces(urdf: &Urdf, tree: &[TreeLink], robot: &mut RobotModel, meshes: &mut MeshStore) {
    let exact = |at: usize| build_link(urdf, tree[at].urdf_link, true, meshes).ok();
    for (at, shapes) in misleading_hulls(&robot.unlocked(), exact) {
        robot.links[at].shapes = shapes;
    }
}

fn check_root(urdf: &Urdf, tree: &[TreeLink], spec: &RobotSpec) -> Result<(), InputError> {
    let root = &urdf.robot.links[tree[0].urdf_link].name;
    match &spec.root {
        Some((stated, location)) if stated != root => {
            Err(location
                .error("root", format!("is '{stated}', but the URDF's root link is '{root}'")))
        }
        _ => Ok(()),
    }
}

fn build_bodies(
    urdf: &Urdf,
    tree: &[TreeLink],
    spec: &RobotSpec,
    meshes: &mut MeshStore,
) -> Result<(Vec<Link>, Joints), InputError> {
    for (name, location) in &spec.exact_meshes {
        if !urdf.robot.links.iter().any(|link| link.name == *name) {
            return Err(location.error("exact_meshes", format!("the URDF has no link '{name}'")));
        }
    }
    let mut links = Vec::with_capacity(tree.len());
    let mut joints = Joints::default();
    for (at, node) in tree.iter().enumerate() {
        let exact = spec
            .exact_meshes
            .iter()
            .any(|(name, _)| *name == urdf.robot.links[node.urdf_link].name);
        let mut link = build_link(urdf, node.urdf_link, exact, meshes)?;
        if let Some((parent, joint)) = node.parent {
            link.parent = Some(attach(urdf, spec, (parent, joint, at), &mut joints)?);
        }
        links.push(link);
    }
    if joints.moving.len() > JOINTS_MAX {
        let message = format!(
            "{} joints move; at most {JOINTS_MAX} may. Lock some in the robot file",
            joints.moving.len()
        );
        return Err(InputError::file(&urdf.source.path, message));
    }
    Ok((links, joints))
}

/// All joints that are not fixed.
#[derive(Default)]
struct Joints {
    moving: Vec<Joint>,
    locked: Vec<LockedJoint>,
}

/// Hangs link `child` on link `parent` by a URDF joint, which joins `joints` unless it is fixed.
fn attach(
    urdf: &Urdf,
    spec: &RobotSpec,
    (parent, urdf_joint, child): (usize, usize, usize),
    joints: &mut Joints,
) -> Result<Attachment, InputError> {
    Ok(match joint_role(urdf, urdf_joint, spec)? {
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
            let parent_from_joint = parent_from_joint(&urdf.robot.joints[urdf_joint]);
            Attachment { parent, parent_from_joint, joint: Some(joints.moving.len() - 1) }
        }
    })
}

fn build_feet(spec: &RobotSpec, links: &[Link]) -> Result<Vec<Foot>, InputError> {
    spec.feet
        .iter()
        .map(|foot_spec| {
            let element = format!("foot '{}'", foot_spec.name);
            let Some(link) = links.iter().position(|link| link.name == foot_spec.link) else {
                return Err(foot_spec
                    .location
                    .error(element, format!("the URDF has no link '{}'", foot_spec.link)));
            };
            let (link, link_from_named) = shaped_ancestor(links, link);
            let FootSpec { name, link_from_sole, polygon, .. } = foot_spec;
            let foot = Foot {
                name: name.clone(),
                link,
                link_from_sole: link_from_named * *link_from_sole,
                polygon: polygon.clone(),
            };
            check_sole(&foot, &links[link], foot_spec)?;
            Ok(foot)
        })
        .collect()
}

/// The nearest link from one toward the root that has shapes and to which that one is fixed, as a
/// frame of a sole is to its foot, and the frame's pose there; the link itself where there is none.
fn shaped_ancestor(links: &[Link], link: usize) -> (usize, Pose) {
    let (mut at, mut at_from_link) = (link, Pose::IDENTITY);
    while links[at].shapes.is_empty() {
        let Some(Attachment { parent, parent_from_joint, joint: None }) = &links[at].parent else {
            return (link, Pose::IDENTITY);
        };
        (at, at_from_link) = (*parent, *parent_from_joint * at_from_link);
    }
    (at, at_from_link)
}

fn standing_posture(spec: &RobotSpec, joints: &Joints) -> Result<Vec<f64>, InputError> {
    let is_locked = |name: &String| joints.locked.iter().any(|locked| locked.joint.name == *name);
    if let Some((name, (_, location))) = spec.standing.iter().find(|(name, _)| is_locked(name)) {
        let message = "this joint is locked, or mimics one that is; remove one of the two entries";
        return Err(location.error(format!("[standing] '{name}'"), message));
    }
    joints
        .moving
        .iter()
        .map(|joint| match spec.standing.get(&joint.name) {
            None => Ok(0.0_f64.clamp(joint.lower, joint.upper)),
            Some((position, _)) if (joint.lower..=joint.upper).contains(position) => Ok(*position),
            Some((position, location)) => Err(location.error(
                format!("[standing] '{}'", joint.name),
                format!(
                    "is {position}, outside the joint's limits {}..{}",
                    joint.lower, joint.upper
                ),
            )),
        })
        .collect()
}
