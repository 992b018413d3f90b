//! The exported plan, `biped-plan/1`: what a person, a viewer or an independent judge reads.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

/// The `schema` field of every plan file.
pub const SCHEMA: &str = "biped-plan/1";

/// A whole plan file. Paths are relative to the file.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PlanFile {
    /// [`SCHEMA`].
    pub schema: String,
    /// The robot.
    pub robot: RobotBlock,
    /// The world.
    pub scene: SceneBlock,
    /// The order of `q` in the waypoints.
    pub joint_names: Vec<String>,
    /// The motion.
    pub waypoints: Vec<WaypointBlock>,
    /// Which feet stand where, over which waypoints.
    pub phases: Vec<PhaseBlock>,
    /// Where it begins.
    pub start: EndBlock,
    /// Where it must end.
    pub goal: EndBlock,
}

/// A pose: metres, unit quaternion x, y, z, w.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct PoseBlock {
    /// Position.
    pub xyz: [f64; 3],
    /// Rotation.
    #[serde(default = "identity_quat")]
    pub quat_xyzw: [f64; 4],
}

/// The robot of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct RobotBlock {
    /// Path of the URDF.
    pub urdf: String,
    /// The feet by name, "left" and "right".
    pub feet: BTreeMap<String, FootBlock>,
    /// Joints that are not planned, with their positions.
    #[serde(default)]
    pub locked_joints: BTreeMap<String, f64>,
    /// Links whose collision meshes are taken as they are; those of others become convex hulls.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub exact_meshes: Vec<String>,
    /// Tighter effort limits by joint name, N m.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub effort_limits: BTreeMap<String, f64>,
    /// Acceleration limits by joint name where they differ from the default, rad/s2 or m/s2.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub acceleration_limits: BTreeMap<String, f64>,
    /// A factor on all effort limits, at most 1.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub effort_scale: Option<f64>,
}

/// A foot of a plan's robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct FootBlock {
    /// The link that carries the sole.
    pub link: String,
    /// The sole frame in the link's frame.
    pub sole_pose: PoseBlock,
    /// The sole's outline at z = 0 of the sole frame.
    pub polygon: Vec<[f64; 2]>,
}

/// The world of a plan.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SceneBlock {
    /// Coefficient of friction.
    pub mu: f64,
    /// The shapes.
    pub shapes: Vec<SceneShapeBlock>,
}

/// A shape of a plan's world.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct SceneShapeBlock {
    /// Its name.
    pub name: String,
    /// Its pose in the world.
    pub pose: PoseBlock,
    /// Its geometry.
    pub shape: ShapeBlock,
}

/// A geometry. Cylinders and capsules lie along z; a cylinder's length is its full one, a capsule's
/// that of its cylindrical part.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "lowercase")]
#[allow(missing_docs, reason = "the fields are the plan format's own names")]
pub enum ShapeBlock {
    /// A box.
    Box { half_extents: [f64; 3] },
    /// A ball.
    Sphere { radius: f64 },
    /// A cylinder.
    Cylinder { radius: f64, length: f64 },
    /// A capsule.
    Capsule { radius: f64, length: f64 },
    /// A convex hull, of points or of a file's vertices.
    Convex {
        #[serde(default, skip_serializing_if = "Option::is_none")]
        points: Option<Vec<[f64; 3]>>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        path: Option<String>,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        scale: Option<[f64; 3]>,
    },
    /// A triangle mesh from a file.
    Mesh {
        path: String,
        #[serde(default, skip_serializing_if = "Option::is_none")]
        scale: Option<[f64; 3]>,
    },
}

/// A configuration at an instant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct WaypointBlock {
    /// Seconds since the start, strictly increasing.
    pub t: f64,
    /// Root position.
    pub root_xyz: [f64; 3],
    /// Root rotation.
    pub root_quat_xyzw: [f64; 4],
    /// Joint positions.
    pub q: Vec<f64>,
}

/// A range of waypoints in one mode, both ends included.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct PhaseBlock {
    /// First waypoint.
    pub first: usize,
    /// Last waypoint.
    pub last: usize,
    /// "left", "right" or "double".
    pub mode: String,
    /// The feet that stand still.
    pub contacts: Vec<ContactBlock>,
}

/// A foot that stands still.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
pub struct ContactBlock {
    /// "left" or "right".
    pub foot: String,
    /// Its sole frame in the world.
    pub sole_pose: PoseBlock,
}

/// How a plan begins or ends.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(tag = "type", rename_all = "snake_case")]
#[allow(missing_docs, reason = "the fields are the plan format's own names")]
pub enum EndBlock {
    /// At one configuration.
    Config {
        root_xyz: [f64; 3],
        root_quat_xyzw: [f64; 4],
        q: Vec<f64>,
        #[serde(default = "config_tolerance")]
        tol: f64,
    },
    /// With the root in a disc.
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
    /// With the soles at some poses; rotation errors count half a metre a radian.
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
