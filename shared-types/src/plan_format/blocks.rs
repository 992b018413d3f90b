//! The exported plan `biped-plan/1`, for viewers and independent checkers.

use std::collections::BTreeMap;

use glam::DQuat;
use serde::{Deserialize, Serialize};

use crate::base::spatial::Pose;

/// The `schema` field of every plan file.
pub const SCHEMA: &str = "biped-plan/1";

/// A plan file. Paths in it are relative to its folder.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PlanFile {
    /// [`SCHEMA`].
    pub schema: String,
    /// The robot.
    pub robot: RobotBlock,
    /// The world.
    pub scene: SceneBlock,
    /// The moving joints, in the order of `q` in the waypoints.
    pub joint_names: Vec<String>,
    /// The motion.
    pub waypoints: Vec<WaypointBlock>,
    /// The support phases, which cover all waypoints in order.
    pub phases: Vec<PhaseBlock>,
    /// The chunks of a smooth plan and where the robot may stop in them. Other programs ignore it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub chunks: Vec<ChunkBlock>,
    /// The start.
    pub start: EndBlock,
    /// The goal.
    pub goal: EndBlock,
    /// What the plan was made from. Other programs ignore it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub origin: Option<OriginBlock>,
    /// The seed with which feet were set down off their places (`--disturb`). The file holds such a
    /// walk as it was executed: the leg of a foot leaps where it lands, so it cannot be checked.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub disturb_seed: Option<u64>,
    /// Whether the file holds a walk as it was executed, with its stops, and no plan to execute.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub executed: bool,
}

/// Digests of what a plan was made from, as hexadecimal SHA-256. Those of robot, world and scenario
/// are the ones that the chunks in shared memory carry.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct OriginBlock {
    /// The stream of the plan's chunks: equal plans have equal digests.
    pub plan: String,
    /// The robot: its URDF, its robot file and all meshes.
    pub robot: String,
    /// The world: its file and all meshes.
    pub world: String,
    /// The scenario.
    pub scenario: String,
    /// The files that the plan names, directly or in its URDF, each with the digest that
    /// `sha256sum` prints.
    pub files: BTreeMap<String, String>,
}

/// A pose: position in m, rotation as unit quaternion x, y, z, w.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PoseBlock {
    /// Position.
    pub xyz: [f64; 3],
    /// Rotation.
    #[serde(default = "identity_quat")]
    pub quat_xyzw: [f64; 4],
}

impl PoseBlock {
    /// The block of a pose.
    pub fn of(pose: &Pose) -> Self {
        Self { xyz: pose.translation.to_array(), quat_xyzw: pose.rotation.to_array() }
    }

    /// The pose, with a rotation of unit length.
    pub fn pose(&self) -> Pose {
        Pose::from_parts(self.xyz.into(), DQuat::from_array(self.quat_xyzw).normalize())
    }
}

/// The robot of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct RobotBlock {
    /// Path of the URDF.
    pub urdf: String,
    /// Path of the robot file, which says how the robot stands and which links may overlap.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub robot_file: Option<String>,
    /// The feet by name, "left" and "right".
    pub feet: BTreeMap<String, FootBlock>,
    /// Joints held still, with their positions, rad or m.
    #[serde(default)]
    pub locked_joints: BTreeMap<String, f64>,
    /// Links with exact collision meshes; meshes of other links become convex hulls.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub exact_meshes: Vec<String>,
    /// Effort limits by joint name, N m or N, where they are below the URDF's.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub effort_limits: BTreeMap<String, f64>,
    /// Acceleration limits by joint name, rad/s2 or m/s2, where they differ from the default.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub acceleration_limits: BTreeMap<String, f64>,
    /// A factor on all effort limits, at most 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effort_scale: Option<f64>,
    /// What the URDF lacks.
    #[serde(default, skip_serializing_if = "UrdfAdditions::is_empty")]
    pub urdf_additions: UrdfAdditions,
}

/// What a robot file states that the robot's URDF lacks.
#[derive(Debug, Clone, Default, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct UrdfAdditions {
    /// Links whose collision shapes are those of their looks.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub visual_shapes: Vec<String>,
    /// Links whose mesh files may be missing; a shape whose file is not found is left out.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub missing_meshes: Vec<String>,
    /// Folders of packages that `package://` names and no folder near the URDF is; paths relative
    /// to the file.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub packages: BTreeMap<String, String>,
    /// Ranges by joint name, rad or m, within the URDF's where it states one.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub position_limits: BTreeMap<String, [f64; 2]>,
    /// Velocity limits by joint name, rad/s or m/s, at most the URDF's where it states one.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub velocity_limits: BTreeMap<String, f64>,
    /// Moments of inertia about the centre of mass by link name, along the link's axes, kg m2.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub inertias: BTreeMap<String, [f64; 3]>,
}

impl UrdfAdditions {
    /// Whether the URDF lacks nothing.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// The same, with the packages' folders as `convert` gives them.
    pub fn with_folders(&self, convert: impl Fn(&str) -> String) -> Self {
        let packages = self.packages.iter();
        let packages = packages.map(|(name, folder)| (name.clone(), convert(folder))).collect();
        Self { packages, ..self.clone() }
    }

    /// Whether a link's shapes are those of its looks.
    pub fn is_visual(&self, link: &str) -> bool {
        self.visual_shapes.iter().any(|name| name == link)
    }

    /// Whether a link may lack mesh files.
    pub fn may_lack_meshes(&self, link: &str) -> bool {
        self.missing_meshes.iter().any(|name| name == link)
    }
}

/// A foot of a plan's robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct FootBlock {
    /// The link that carries the sole.
    pub link: String,
    /// The sole frame in the link's frame.
    pub sole_pose: PoseBlock,
    /// The sole's outline in the sole frame at z = 0, m.
    pub polygon: Vec<[f64; 2]>,
}

/// The world of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SceneBlock {
    /// Coefficient of friction.
    pub mu: f64,
    /// The shapes.
    pub shapes: Vec<SceneShapeBlock>,
}

/// A shape of a plan's world.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct SceneShapeBlock {
    /// Its name.
    pub name: String,
    /// Its pose in the world.
    pub pose: PoseBlock,
    /// Its geometry.
    pub shape: ShapeBlock,
}

/// A geometry, lengths in m. Cylinders and capsules lie along z. The length of a capsule is the
/// length of its cylindrical part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "type", rename_all = "lowercase")]
#[allow(missing_docs, reason = "the fields are the plan format's own names")]
pub enum ShapeBlock {
    /// A box.
    Box { half_extents: [f64; 3] },
    /// A sphere.
    Sphere { radius: f64 },
    /// A cylinder.
    Cylinder { radius: f64, length: f64 },
    /// A capsule.
    Capsule { radius: f64, length: f64 },
    /// A convex hull of points or of the vertices of a mesh file.
    Convex {
        #[serde(default, skip_serializing_if = "Option::is_none")]
        points: Option<Vec<[f64; 3]>>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        path: Option<String>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        scale: Option<[f64; 3]>,
    },
    /// A triangle mesh of a file.
    Mesh {
        path: String,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        scale: Option<[f64; 3]>,
    },
}

/// A configuration with its time.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct WaypointBlock {
    /// Time since the start, s; strictly increasing.
    pub t: f64,
    /// Root position in the world, m.
    pub root_xyz: [f64; 3],
    /// Root rotation in the world, unit quaternion x, y, z, w.
    pub root_quat_xyzw: [f64; 4],
    /// Joint positions, rad or m.
    pub q: Vec<f64>,
    /// Velocity of the root's origin (m/s), angular velocity of the root (rad/s), both along the
    /// world's axes, then joint velocities. Empty in a plan of straight lines.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub velocity: Vec<f64>,
    /// The derivative of `velocity`; empty where that is.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub acceleration: Vec<f64>,
    /// Feed-forward joint efforts, N m or N; empty in a plan without.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub torque: Vec<f64>,
    /// The same if the robot rests in this configuration. Other programs ignore it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rest_torque: Vec<f64>,
    /// By how much feed-forward changes where the rate of plan time changes by 1 a second, N m s
    /// or N s. Other programs ignore it.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub rate_change_torque: Vec<f64>,
}

/// A chunk of a smooth plan. The names and meanings are those of
/// [`PlanChunk`](crate::message::PlanChunk).
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ChunkBlock {
    /// Index of the first waypoint.
    pub first: usize,
    /// Index of the last waypoint, included.
    pub last: usize,
    /// The plan time at which the robot brakes if the next chunk is not accepted, s.
    pub brake_at: f64,
    /// How long the robot brakes, s.
    pub brake_duration: f64,
    /// How long the robot takes to full speed after it has braked in this chunk, s.
    pub resume_duration: f64,
}

/// A range of waypoints with one support mode.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct PhaseBlock {
    /// Index of the first waypoint.
    pub first: usize,
    /// Index of the last waypoint, included.
    pub last: usize,
    /// Support mode: "left", "right" or "double".
    pub mode: String,
    /// The stance feet.
    pub contacts: Vec<ContactBlock>,
}

/// A stance foot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
pub struct ContactBlock {
    /// "left" or "right".
    pub foot: String,
    /// The sole frame in the world.
    pub sole_pose: PoseBlock,
}

/// The start or the goal of a plan. `tol` is a tolerance in m; a rotation error of 1 rad counts as
/// 0.5 m.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[cfg_attr(feature = "schema", derive(schemars::JsonSchema))]
#[serde(tag = "type", rename_all = "snake_case")]
#[allow(missing_docs, reason = "the fields are the plan format's own names")]
pub enum EndBlock {
    /// One configuration.
    Config {
        root_xyz: [f64; 3],
        root_quat_xyzw: [f64; 4],
        q: Vec<f64>,
        #[serde(default = "config_tolerance")]
        tol: f64,
    },
    /// A region of the root: a disc, optionally with a range of heights and headings.
    RootRegion {
        xy: [f64; 2],
        radius: f64,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        z_range: Option<[f64; 2]>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        yaw: Option<f64>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        yaw_tol: Option<f64>,
    },
    /// Poses of the soles.
    Feet {
        soles: BTreeMap<String, PoseBlock>,
        #[serde(default = "feet_tolerance")]
        tol: f64,
    },
}

fn identity_quat() -> [f64; 4] {
    [0.0, 0.0, 0.0, 1.0]
}

fn config_tolerance() -> f64 {
    1e-3
}

fn feet_tolerance() -> f64 {
    2e-3
}
