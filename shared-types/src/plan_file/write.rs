//! Writes plan files.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::{DQuat, DVec3};

use crate::base::input_error::InputError;
use crate::base::spatial::{Pose, wrap_angle, yaw_of};
use crate::base::text_file::relative_to;
use crate::base::whole_file;
use crate::config::scenario::{Scenario, StancePose};
use crate::geometry::shape::{MeshSource, Shape};
use crate::message::{Contact, PlanChunk, SupportMode, Waypoint};
use crate::plan_file::check::check_plan;
use crate::plan_file::origin::origin_block;
use crate::plan_format::blocks::{
    ChunkBlock, ContactBlock, EndBlock, FootBlock, PhaseBlock, PlanFile, PoseBlock, RobotBlock,
    SCHEMA, SceneBlock, SceneShapeBlock, ShapeBlock, WaypointBlock,
};
use crate::robot::model::{Foot, Joint, Link, RobotModel};
use crate::world::world::{World, WorldShape};

/// Largest distance of the first waypoint's soles from the start stance, m.
const START_TOLERANCE: f64 = 2e-3;
/// Tilt (sine) below which the ground of a sole counts as level.
const LEVEL_TILT_MAX: f64 = 1e-9;
/// Difference in height (m) below which it does.
const LEVEL_OFFSET_MAX: f64 = 1e-9;
/// Largest difference in height (m) between a stance and its ground.
const GROUND_OFFSET_MAX: f64 = 0.1;
/// Largest distance of the first waypoint from the start configuration, m and rad.
const CONFIGURATION_TOLERANCE: f64 = 1e-3;
/// Metres that a radian counts as in the tolerance of a sole.
const METRES_PER_RADIAN: f64 = 0.5;
/// What rounding adds to the heading of a sole, m.
const TOLERANCE_ROUNDING: f64 = 1e-6;

/// The plan file of a stream of chunks. Its paths are relative to `plan_dir`, the folder in which
/// it is saved (absolute, or relative to the working directory).
///
/// The first waypoint of a chunk repeats the last one of the chunk before and is written once.
/// Consecutive chunks with equal modes and sole poses become one phase.
pub fn plan_from_chunks(
    robot: &RobotModel,
    world: &World,
    scenario: &Scenario,
    chunks: &[PlanChunk],
    plan_dir: &Path,
) -> PlanFile {
    plan_with_ends(robot, world, ends_of(robot, scenario, chunks), chunks, plan_dir)
}

/// The plan file of a motion as a robot executed it, as [`plan_from_chunks`] makes it, but without
/// chunks: those of a plan name stops, and this motion has taken its own. `disturb_seed` is that of
/// the feet's displacements, if there were any.
pub fn executed_plan(
    robot: &RobotModel,
    world: &World,
    scenario: &Scenario,
    (executed, disturb_seed): (&[PlanChunk], Option<u64>),
    plan_dir: &Path,
) -> PlanFile {
    let chunks = Vec::new();
    PlanFile {
        chunks,
        disturb_seed,
        executed: true,
        ..plan_from_chunks(robot, world, scenario, executed, plan_dir)
    }
}

/// The start and the goal of a stream of chunks that answers a scenario.
pub fn ends_of(robot: &RobotModel, scenario: &Scenario, chunks: &[PlanChunk]) -> [EndBlock; 2] {
    [start_block(robot, scenario, chunks), goal_block(robot, scenario, chunks)]
}

/// As [`plan_from_chunks`], with the start and the goal as the file states them.
pub fn plan_with_ends(
    robot: &RobotModel,
    world: &World,
    ends: [EndBlock; 2],
    chunks: &[PlanChunk],
    plan_dir: &Path,
) -> PlanFile {
    PlanFile {
        origin: origin_block(robot, world, chunks, &absolute_folder(plan_dir)),
        ..plan_without_origin(robot, world, ends, chunks, plan_dir)
    }
}

/// As [`plan_with_ends`], but it does not state what the plan was made from: no file is read.
pub fn plan_without_origin(
    robot: &RobotModel,
    world: &World,
    [start, goal]: [EndBlock; 2],
    chunks: &[PlanChunk],
    plan_dir: &Path,
) -> PlanFile {
    let plan_dir = absolute_folder(plan_dir);
    let MotionBlocks { waypoints, phases, chunks: chunk_blocks } = motion(robot, chunks);
    PlanFile {
        schema: SCHEMA.to_owned(),
        robot: robot_block(robot, &plan_dir),
        scene: SceneBlock {
            mu: world.mu,
            shapes: world.shapes.iter().map(|shape| shape_block(shape, &plan_dir)).collect(),
        },
        joint_names: robot.joints.iter().map(|joint| joint.name.clone()).collect(),
        waypoints,
        phases,
        chunks: chunk_blocks,
        start,
        goal,
        origin: None,
        disturb_seed: None,
        executed: false,
    }
}

fn absolute_folder(dir: &Path) -> PathBuf {
    dir.canonicalize().or_else(|_| std::path::absolute(dir)).unwrap_or_else(|_| dir.to_owned())
}

/// Saves a plan file, completely or not at all.
///
/// # Errors
/// The plan violates a rule of the format, or the file cannot be written.
pub fn save(plan: &PlanFile, path: &Path) -> Result<(), InputError> {
    whole_file::write(path, &text_of(plan, path)?)
        .map_err(|reason| InputError::file(path, format!("cannot be written: {reason}")))
}

/// The text of a plan file; `path` is where it is saved, for errors.
///
/// # Errors
/// The plan violates a rule of the format.
pub fn text_of(plan: &PlanFile, path: &Path) -> Result<Vec<u8>, InputError> {
    check_plan(plan).map_err(|(element, message)| InputError::element(path, element, message))?;
    check_file_names(plan).map_err(|(name, message)| InputError::element(path, name, message))?;
    let mut text =
        serde_json::to_vec(plan).map_err(|error| InputError::file(path, error.to_string()))?;
    text.push(b'\n');
    Ok(text)
}

/// Checks that a plan file can name the URDF and the files of the meshes: a mesh in memory has
/// none, and a name that is no UTF-8 cannot be written.
///
/// # Errors
/// The element, and why it cannot.
pub fn check_file_names(plan: &PlanFile) -> Result<(), (String, String)> {
    check_name(&plan.robot.urdf).map_err(|message| ("robot.urdf".to_owned(), message))?;
    for shape in &plan.scene.shapes {
        if let ShapeBlock::Mesh { path, .. } = &shape.shape {
            let named = if path.is_empty() {
                Err("is a mesh in memory; save it as an STL or OBJ file and load the world from \
                     there"
                    .to_owned())
            } else {
                check_name(path)
            };
            named.map_err(|message| (format!("shape '{}'", shape.name), message))?;
        }
    }
    Ok(())
}

/// [`relative_to`] puts the replacement character where a name is no UTF-8.
fn check_name(path: &str) -> Result<(), String> {
    match path.contains(char::REPLACEMENT_CHARACTER) {
        true => Err(format!("the path '{path}' is no UTF-8 text; rename the file or its folder")),
        false => Ok(()),
    }
}

/// The motion of a plan as it stands in the file.
struct MotionBlocks {
    waypoints: Vec<WaypointBlock>,
    phases: Vec<PhaseBlock>,
    chunks: Vec<ChunkBlock>,
}

fn motion(robot: &RobotModel, chunks: &[PlanChunk]) -> MotionBlocks {
    let is_smooth = chunks.iter().any(PlanChunk::is_smooth);
    let mut waypoints: Vec<WaypointBlock> = Vec::new();
    let mut phases: Vec<PhaseBlock> = Vec::new();
    let mut blocks: Vec<ChunkBlock> = Vec::new();
    for chunk in chunks {
        let first = waypoints.len().saturating_sub(1);
        let repeated = usize::from(!waypoints.is_empty());
        waypoints.extend(
            chunk
                .waypoints()
                .iter()
                .skip(repeated)
                .map(|waypoint| waypoint_block(waypoint, robot, is_smooth)),
        );
        let last = waypoints.len().saturating_sub(1);
        if is_smooth {
            blocks.push(chunk_block(chunk, first, last));
        }
        let mode = SupportMode::from_wire(chunk.mode).map_or("unknown", SupportMode::name);
        let contacts: Vec<_> =
            chunk.contacts().iter().map(|contact| contact_block(contact, robot)).collect();
        match phases.last_mut() {
            Some(phase) if phase.mode == mode && phase.contacts == contacts => phase.last = last,
            _ => phases.push(PhaseBlock { first, last, mode: mode.to_owned(), contacts }),
        }
    }
    MotionBlocks { waypoints, phases, chunks: blocks }
}

fn chunk_block(chunk: &PlanChunk, first: usize, last: usize) -> ChunkBlock {
    let PlanChunk { brake_at, brake_duration, resume_duration, .. } = *chunk;
    ChunkBlock { first, last, brake_at, brake_duration, resume_duration }
}

fn waypoint_block(waypoint: &Waypoint, robot: &RobotModel, is_smooth: bool) -> WaypointBlock {
    let (root_xyz, root_quat_xyzw) = root_pose(waypoint, robot);
    let joints = robot.joints.len();
    let mut block = WaypointBlock {
        t: waypoint.time,
        root_xyz,
        root_quat_xyzw,
        q: waypoint.q[..joints].to_vec(),
        velocity: vec![],
        acceleration: vec![],
        torque: vec![],
        rest_torque: vec![],
        rate_change_torque: vec![],
    };
    if is_smooth {
        let (velocity, acceleration) = urdf_root_rates(waypoint, robot);
        block.velocity = [&velocity, &waypoint.joint_velocity[..joints]].concat();
        block.acceleration = [&acceleration, &waypoint.joint_acceleration[..joints]].concat();
        block.torque = waypoint.torque[..joints].to_vec();
        block.rest_torque = waypoint.rest_torque[..joints].to_vec();
        block.rate_change_torque = waypoint.rate_change_torque[..joints].to_vec();
    }
    block
}

/// Velocity and acceleration of the origin of the URDF's root link, and the root's angular ones.
fn urdf_root_rates(waypoint: &Waypoint, robot: &RobotModel) -> ([f64; 6], [f64; 6]) {
    let offset = waypoint.world_from_root().rotation * robot.root_from_urdf_root().translation;
    let split = |rates: &[f64; 6]| {
        (DVec3::new(rates[0], rates[1], rates[2]), DVec3::new(rates[3], rates[4], rates[5]))
    };
    let (velocity, omega) = split(&waypoint.root_velocity);
    let (acceleration, alpha) = split(&waypoint.root_acceleration);
    let joined = |linear: DVec3, angular: DVec3| {
        [linear.x, linear.y, linear.z, angular.x, angular.y, angular.z]
    };
    let of_origin = acceleration + alpha.cross(offset) + omega.cross(omega.cross(offset));
    (joined(velocity + omega.cross(offset), omega), joined(of_origin, alpha))
}

/// Where the URDF's root link is: a plan file knows no other root.
fn root_pose(waypoint: &Waypoint, robot: &RobotModel) -> ([f64; 3], [f64; 4]) {
    let (position, rotation) = (waypoint.root_position, waypoint.root_rotation);
    let root_from_urdf_root = robot.root_from_urdf_root();
    if root_from_urdf_root == Pose::IDENTITY {
        return (position, rotation);
    }
    let world_from_root = Pose::from_parts(position.into(), DQuat::from_array(rotation));
    let pose = PoseBlock::of(&(world_from_root * root_from_urdf_root));
    (pose.xyz, pose.quat_xyzw)
}

fn contact_block(contact: &Contact, robot: &RobotModel) -> ContactBlock {
    let foot = robot.feet.get(contact.limb as usize).map_or("unknown", |foot| &foot.name);
    ContactBlock {
        foot: foot.to_owned(),
        sole_pose: PoseBlock { xyz: contact.position, quat_xyzw: contact.rotation },
    }
}

fn robot_block(robot: &RobotModel, plan_dir: &Path) -> RobotBlock {
    RobotBlock {
        urdf: relative_to(&robot.urdf_path, plan_dir),
        robot_file: robot.robot_path.as_deref().map(|path| relative_to(path, plan_dir)),
        feet: robot.feet.iter().map(|foot| (foot.name.clone(), foot_block(foot, robot))).collect(),
        locked_joints: robot
            .locked_joints
            .iter()
            .map(|locked| (locked.joint.name.clone(), locked.position))
            .collect(),
        exact_meshes: exact_meshes(robot),
        effort_limits: effort_limits(robot),
        acceleration_limits: acceleration_limits(robot),
        effort_scale: None,
        urdf_additions: robot
            .additions
            .with_folders(|folder| relative_to(Path::new(folder), plan_dir)),
    }
}

fn exact_meshes(robot: &RobotModel) -> Vec<String> {
    let has_mesh =
        |link: &&Link| link.shapes.iter().any(|part| matches!(part.shape, Shape::Mesh { .. }));
    robot.links.iter().filter(has_mesh).map(|link| link.name.clone()).collect()
}

/// The finite effort limits of all joints, locked ones included.
fn effort_limits(robot: &RobotModel) -> BTreeMap<String, f64> {
    let joints = robot.joints.iter().chain(robot.locked_joints.iter().map(|locked| &locked.joint));
    joints
        .filter(|joint| joint.effort.is_finite())
        .map(|joint| (joint.name.clone(), joint.effort))
        .collect()
}

fn acceleration_limits(robot: &RobotModel) -> BTreeMap<String, f64> {
    let stated = |joint: &Joint| Some((joint.name.clone(), joint.stated_acceleration?));
    robot.joints.iter().filter_map(stated).collect()
}

fn foot_block(foot: &Foot, robot: &RobotModel) -> FootBlock {
    FootBlock {
        link: robot.links[foot.link].name.clone(),
        sole_pose: PoseBlock::of(&foot.link_from_sole),
        polygon: foot.polygon.iter().map(|corner| corner.to_array()).collect(),
    }
}

fn shape_block(shape: &WorldShape, plan_dir: &Path) -> SceneShapeBlock {
    let block = match &shape.shape {
        Shape::Box { half_extents } => ShapeBlock::Box { half_extents: half_extents.to_array() },
        Shape::Sphere { radius } => ShapeBlock::Sphere { radius: *radius },
        Shape::Cylinder { radius, half_length } => {
            ShapeBlock::Cylinder { radius: *radius, length: 2.0 * half_length }
        }
        Shape::Capsule { radius, half_length } => {
            ShapeBlock::Capsule { radius: *radius, length: 2.0 * half_length }
        }
        Shape::ConvexHull { points, .. } => ShapeBlock::Convex {
            points: Some(points.iter().map(|point| point.to_array()).collect()),
            path: None,
            scale: None,
        },
        Shape::Mesh { source: Some(MeshSource { path, scale }), .. } => ShapeBlock::Mesh {
            path: relative_to(path, plan_dir),
            scale: (*scale != DVec3::ONE).then(|| scale.to_array()),
        },
        Shape::Mesh { source: None, .. } => ShapeBlock::Mesh { path: String::new(), scale: None },
    };
    SceneShapeBlock {
        name: shape.name.clone(),
        pose: PoseBlock::of(&shape.world_from_shape),
        shape: block,
    }
}

/// The start as the first chunk holds it: the sole poses of its contacts, which on a slope are not
/// level as the stance is. A plan that continues an interrupted walk may start on one foot; its
/// start is the first configuration.
fn start_block(robot: &RobotModel, scenario: &Scenario, chunks: &[PlanChunk]) -> EndBlock {
    let contacts = chunks.first().map_or(&[][..], PlanChunk::contacts);
    if let Some([first, ..]) =
        chunks.first().map(PlanChunk::waypoints).filter(|_| contacts.len() < robot.feet.len())
    {
        let (root_xyz, root_quat_xyzw) = root_pose(first, robot);
        return EndBlock::Config {
            root_xyz,
            root_quat_xyzw,
            q: first.q[..robot.joints.len()].to_vec(),
            tol: CONFIGURATION_TOLERANCE,
        };
    }
    let mut block = end_block(robot, &scenario.start, START_TOLERANCE);
    if let EndBlock::Feet { soles, .. } = &mut block {
        soles.extend(
            contacts
                .iter()
                .map(|contact| contact_block(contact, robot))
                .map(|contact| (contact.foot, contact.sole_pose)),
        );
    }
    block
}

/// The goal that the scenario states, with the height and the tilt of the ground on which the last
/// chunk's soles stand: a stance is level, a slope is not.
///
/// The format has one tolerance, of which a radian takes half a metre. It is that of the scenario's
/// position, and more only where the plan makes use of the tolerance of heading.
fn goal_block(robot: &RobotModel, scenario: &Scenario, chunks: &[PlanChunk]) -> EndBlock {
    let mut block = end_block(robot, &scenario.goal, scenario.goal_tolerance.position);
    let contacts = chunks.last().map_or(&[][..], PlanChunk::contacts);
    if let EndBlock::Feet { soles, tol } = &mut block {
        for contact in contacts {
            let ContactBlock { foot, sole_pose } = contact_block(contact, robot);
            if let Some(level) = soles.get_mut(&foot) {
                *level = on_ground(level, &sole_pose);
                let heading = yaw_of(sole_pose.pose().rotation);
                let turn = wrap_angle(heading - scenario.goal.yaw).abs();
                let used = METRES_PER_RADIAN * turn.min(scenario.goal_tolerance.yaw);
                *tol = tol.max(used + TOLERANCE_ROUNDING);
            }
        }
    }
    block
}

/// A level sole pose moved vertically, and tilted, onto the plane of the sole of a contact. The
/// same pose if that plane is level at its height, or more than 10 cm higher or lower.
pub fn on_ground(level: &PoseBlock, contact: &PoseBlock) -> PoseBlock {
    let [level_pose, contact] = [level.pose(), contact.pose()];
    let normal = contact.rotation * DVec3::Z;
    let [position, on_plane] = [level_pose.translation, contact.translation];
    let slope = -normal.truncate() / normal.z;
    let height = on_plane.z + slope.dot((position - on_plane).truncate());
    let is_level = normal.truncate().length() < LEVEL_TILT_MAX
        && (height - position.z).abs() < LEVEL_OFFSET_MAX;
    let is_other_ground = (height - position.z).abs() > GROUND_OFFSET_MAX;
    if is_level || is_other_ground || normal.z <= 0.0 {
        return *level;
    }
    PoseBlock::of(&Pose::from_parts(
        position.truncate().extend(height),
        DQuat::from_rotation_arc(DVec3::Z, normal) * level_pose.rotation,
    ))
}

/// The end of a plan that a stance (soles side by side, level) with a tolerance (m) asks for.
pub fn end_block(robot: &RobotModel, stance: &StancePose, tol: f64) -> EndBlock {
    let soles: BTreeMap<_, _> = robot
        .feet
        .iter()
        .zip(stance.world_from_soles())
        .map(|(foot, pose)| (foot.name.clone(), PoseBlock::of(&pose)))
        .collect();
    EndBlock::Feet { soles, tol }
}
