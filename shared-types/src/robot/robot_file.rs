//! Reads `robot.toml` and a plan's robot block into a [`RobotSpec`].

use std::collections::BTreeMap;
use std::path::Path;

use glam::DQuat;
use serde::Deserialize;
use toml::Spanned;

use crate::base::exactly::Exactly;
use crate::base::file_kind::FileKind;
use crate::base::input_error::InputError;
use crate::base::spatial::Pose;
use crate::base::spatial::rotation_from_rpy;
use crate::base::text_file::{
    FileLocation, TEXT_BYTES_MAX, TextFile, absolute, absolute_folder, check_angles, check_numbers,
    check_positive, folder_of,
};
use crate::plan_format::blocks::{RobotBlock, UrdfAdditions};
use crate::world::shape_block::{pose_from_arrays, pose_from_block};

use crate::robot::model::AllowedOverlap;
use crate::robot::model::FOOT_NAMES;
use crate::robot::spec::{FootSpec, JointValues, RobotSpec};

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawRobot {
    urdf: String,
    root: Option<Spanned<String>>,
    root_rpy: Option<Spanned<Exactly<f64, 3>>>,
    #[serde(default)]
    exact_meshes: Vec<Spanned<String>>,
    #[serde(default)]
    feet: Vec<Spanned<RawFoot>>,
    #[serde(default)]
    standing: BTreeMap<String, Spanned<f64>>,
    #[serde(default)]
    locked: BTreeMap<String, Spanned<f64>>,
    #[serde(default)]
    effort_limits: BTreeMap<String, Spanned<f64>>,
    #[serde(default)]
    accelerations: BTreeMap<String, Spanned<f64>>,
    #[serde(default)]
    visual_shapes: Vec<String>,
    #[serde(default)]
    missing_meshes: Vec<String>,
    #[serde(default)]
    packages: BTreeMap<String, String>,
    #[serde(default)]
    position_limits: BTreeMap<String, Exactly<f64, 2>>,
    #[serde(default)]
    velocity_limits: BTreeMap<String, f64>,
    #[serde(default)]
    inertias: BTreeMap<String, Exactly<f64, 3>>,
    #[serde(default)]
    allowed_overlaps: Vec<Spanned<RawOverlap>>,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawOverlap {
    links: Exactly<String, 2>,
    depth: f64,
}

#[derive(Deserialize)]
#[serde(deny_unknown_fields)]
struct RawFoot {
    name: String,
    link: String,
    sole_xyz: Exactly<f64, 3>,
    #[serde(default)]
    sole_rpy: Exactly<f64, 3>,
    polygon: Vec<Exactly<f64, 2>>,
}

/// Reads a robot file.
pub(crate) fn read_robot_file(path: &Path) -> Result<RobotSpec, InputError> {
    spec_from_text(TextFile::read(path, FileKind::Robot, TEXT_BYTES_MAX)?)
}

/// Reads the text of a robot file, which need not be written yet.
pub(crate) fn spec_from_text(source: TextFile) -> Result<RobotSpec, InputError> {
    let path = source.path.clone();
    let path = path.as_path();
    let raw: RawRobot = source.parse_toml(FileKind::Robot)?;
    let named = |name: Spanned<String>| {
        let location = source.location(name.span().start);
        (name.into_inner(), location)
    };
    let location = FileLocation::file(path);
    let feet =
        raw.feet.into_iter().map(|foot| foot_from_file(foot, &source)).collect::<Result<_, _>>()?;
    Ok(RobotSpec {
        path: Some(path.to_owned()),
        feet: left_and_right(feet, &location)?,
        urdf_path: path.parent().unwrap_or(Path::new("")).join(raw.urdf),
        root: raw.root.map(named),
        urdf_root_from_root: raw.root_rpy.map(|rpy| root_turn(&rpy, &source)).transpose()?,
        exact_meshes: raw.exact_meshes.into_iter().map(named).collect(),
        standing: joint_values("[standing]", raw.standing, &source)?,
        locked: joint_values("[locked]", raw.locked, &source)?,
        effort_limits: joint_values("[effort_limits]", raw.effort_limits, &source)?,
        accelerations: joint_values("[accelerations]", raw.accelerations, &source)?,
        additions: UrdfAdditions {
            visual_shapes: raw.visual_shapes,
            missing_meshes: raw.missing_meshes,
            packages: raw.packages,
            position_limits: values(raw.position_limits),
            velocity_limits: raw.velocity_limits,
            inertias: values(raw.inertias),
        }
        .with_folders(|folder| joined(&folder_of(path), folder)),
        additions_location: location,
        allowed_overlaps: raw
            .allowed_overlaps
            .into_iter()
            .map(|overlap| allowed_overlap(overlap, &source))
            .collect::<Result<_, _>>()?,
        effort_scale: 1.0,
        bytes: source.text.into_bytes(),
    })
}

/// Takes a plan's robot block, its URDF relative to `base_dir`.
pub(crate) fn spec_from_block(
    block: &RobotBlock,
    base_dir: &Path,
    plan_path: &Path,
) -> Result<RobotSpec, InputError> {
    let location = FileLocation::file(plan_path);
    let feet = block
        .feet
        .iter()
        .map(|(name, foot)| {
            let link_from_sole = pose_from_block(&foot.sole_pose)
                .map_err(|message| location.error(format!("foot '{name}'"), message))?;
            FootSpec::new(
                name.clone(),
                foot.link.clone(),
                link_from_sole,
                &foot.polygon,
                location.clone(),
            )
        })
        .collect::<Result<_, _>>()?;
    let effort_scale = block.effort_scale.unwrap_or(1.0);
    if !(effort_scale > 0.0 && effort_scale <= 1.0) {
        let message = format!("is {effort_scale}; it must be positive and at most 1");
        return Err(location.error("effort_scale", message));
    }
    check_urdf_is_there(&block.urdf, base_dir, &location)?;
    let named = named_robot_file(block, base_dir)?;
    let urdf_additions = block.urdf_additions.with_folders(|_| String::new());
    let anonymous =
        RobotBlock { urdf: String::new(), robot_file: None, urdf_additions, ..block.clone() };
    let mut bytes = serde_json::to_vec(&anonymous)
        .map_err(|error| location.error("robot", error.to_string()))?;
    let (path, standing, allowed_overlaps) = match named {
        Some(file) => {
            bytes.extend(file.bytes);
            (file.path, file.standing, file.allowed_overlaps)
        }
        None => (None, JointValues::new(), Vec::new()),
    };
    Ok(RobotSpec {
        path,
        feet: left_and_right(feet, &location)?,
        urdf_path: base_dir.join(&block.urdf),
        root: None,
        urdf_root_from_root: None,
        exact_meshes: block
            .exact_meshes
            .iter()
            .map(|link| (link.clone(), location.clone()))
            .collect(),
        standing,
        locked: block_values("locked_joints", &block.locked_joints, &location)?,
        effort_limits: block_values("effort_limits", &block.effort_limits, &location)?,
        accelerations: block_values("acceleration_limits", &block.acceleration_limits, &location)?,
        additions: block.urdf_additions.with_folders(|folder| joined(base_dir, folder)),
        additions_location: location,
        allowed_overlaps,
        effort_scale,
        bytes,
    })
}

/// Refuses a plan that was moved away from its robot.
fn check_urdf_is_there(
    urdf: &str,
    base_dir: &Path,
    location: &FileLocation,
) -> Result<(), InputError> {
    let path = base_dir.join(urdf);
    if path.exists() {
        return Ok(());
    }
    let message = format!(
        "there is no file {}; a plan names its robot from its own folder: put it back to where it was written, or export it again",
        path.display()
    );
    Err(location.error("robot.urdf", message))
}

/// The absolute path of a folder that a file names from where it is.
fn joined(base: &Path, folder: &str) -> String {
    absolute_folder(&base.join(folder)).to_string_lossy().into_owned()
}

/// The robot file that a plan names, if it is there and of the plan's URDF. How the robot stands
/// and which links may overlap is read there: a plan may not loosen the checks of its robot.
fn named_robot_file(block: &RobotBlock, base_dir: &Path) -> Result<Option<RobotSpec>, InputError> {
    let Some(path) = block.robot_file.as_ref().map(|file| base_dir.join(file)) else {
        return Ok(None);
    };
    if !path.exists() {
        return Ok(None);
    }
    let file = read_robot_file(&path)?;
    let is_of_plan = absolute(&file.urdf_path) == absolute(&base_dir.join(&block.urdf));
    Ok(Some(file).filter(|_| is_of_plan))
}

fn foot_from_file(foot: Spanned<RawFoot>, source: &TextFile) -> Result<FootSpec, InputError> {
    let location = source.location(foot.span().start);
    let RawFoot { name, link, sole_xyz, sole_rpy, polygon } = foot.into_inner();
    let polygon: Vec<[f64; 2]> = polygon.into_iter().map(|corner| corner.0).collect();
    let link_from_sole = sole_pose(sole_xyz.0, sole_rpy.0)
        .map_err(|message| location.error(format!("foot '{name}'"), message))?;
    FootSpec::new(name, link, link_from_sole, &polygon, location)
}

/// A table of arrays, by their names.
fn values<const N: usize>(raw: BTreeMap<String, Exactly<f64, N>>) -> BTreeMap<String, [f64; N]> {
    raw.into_iter().map(|(name, value)| (name, value.0)).collect()
}

fn allowed_overlap(
    overlap: Spanned<RawOverlap>,
    source: &TextFile,
) -> Result<(AllowedOverlap, FileLocation), InputError> {
    let location = source.location(overlap.span().start);
    let RawOverlap { links: Exactly(links), depth } = overlap.into_inner();
    check_positive("depth", &[depth])
        .map_err(|message| location.error("allowed_overlaps", message))?;
    Ok((AllowedOverlap { links, depth }, location))
}

fn root_turn(rpy: &Spanned<Exactly<f64, 3>>, source: &TextFile) -> Result<DQuat, InputError> {
    let Exactly([roll, pitch, yaw]) = *rpy.get_ref();
    check_angles("it", &[roll, pitch, yaw])
        .map_err(|message| source.location(rpy.span().start).error("root_rpy", message))?;
    Ok(rotation_from_rpy(roll, pitch, yaw))
}

fn sole_pose(xyz: [f64; 3], rpy: [f64; 3]) -> Result<Pose, String> {
    check_angles("sole_rpy", &rpy)?;
    pose_from_arrays(xyz, rotation_from_rpy(rpy[0], rpy[1], rpy[2]).to_array())
}

fn left_and_right(
    feet: Vec<FootSpec>,
    location: &FileLocation,
) -> Result<Vec<FootSpec>, InputError> {
    let mut feet = feet;
    feet.sort_by_key(|foot| FOOT_NAMES.iter().position(|name| *name == foot.name));
    if feet.iter().map(|foot| foot.name.as_str()).eq(FOOT_NAMES) {
        let link = &feet[0].link;
        if feet[1].link == *link {
            let message = format!("are both on link '{link}'; each foot has a link of its own");
            return Err(location.error("feet", message));
        }
        return Ok(feet);
    }
    let names: Vec<_> = feet.iter().map(|foot| foot.name.as_str()).collect();
    Err(location.error(
        "feet",
        format!("are {names:?}; a biped needs exactly one named \"left\" and one named \"right\""),
    ))
}

fn joint_values(
    table: &str,
    raw: BTreeMap<String, Spanned<f64>>,
    source: &TextFile,
) -> Result<JointValues, InputError> {
    raw.into_iter()
        .map(|(name, value)| {
            checked_value(table, name, *value.get_ref(), source.location(value.span().start))
        })
        .collect()
}

fn block_values(
    table: &str,
    raw: &BTreeMap<String, f64>,
    location: &FileLocation,
) -> Result<JointValues, InputError> {
    raw.iter()
        .map(|(name, value)| checked_value(table, name.clone(), *value, location.clone()))
        .collect()
}

fn checked_value(
    table: &str,
    name: String,
    value: f64,
    location: FileLocation,
) -> Result<(String, (f64, FileLocation)), InputError> {
    match check_numbers("entry", &[value]) {
        Ok(()) => Ok((name, (value, location))),
        Err(message) => Err(location.error(format!("{table} '{name}'"), message)),
    }
}
