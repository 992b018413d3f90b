//! The parameters of the planner and of the checker, with the relations that must hold between
//! them.

/// A stance foot may be this far from its place between two waypoints of a plan, m.
pub const FOOT_DRIFT_MAX: f64 = 1.0e-3;
/// A stance foot may be turned this far between two waypoints of a plan, rad.
pub const FOOT_TURN_MAX: f64 = 1.7e-3;
/// A surface carries a planned sole within this distance of its plane, m.
pub const CONTACT_GAP_MAX: f64 = 1e-3;
/// A surface carries a planned sole within this tilt of its normal, rad.
pub const CONTACT_TILT_MAX: f64 = 4.0 * std::f64::consts::PI / 180.0;

/// Everything that bounds or shapes the search. Deserialised from a scenario's `[planner]` table,
/// each field optional.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlannerConfig {
    /// Work units the whole plan may use; a unit is the least that the search advances by, some ten
    /// microseconds on the average (`surefoot bench steps` measures each kind).
    pub work_max: u64,
    /// Most vertices in each tree of stage P.
    pub tree_vertices_max: u32,
    /// Most foot placements in the graph.
    pub footholds_max: u32,
    /// Most transitions in the graph.
    pub transitions_max: u32,
    /// Most transitions for which a configuration is found; four times as many motions between them
    /// can be on record.
    pub configurations_max: u32,
    /// Most waypoints of a plan, those shared by two chunks counted once.
    pub waypoints_max: u32,
    /// Sequences tried to remove steps from a complete segment; 0 removes none.
    pub step_removal_rounds_max: u32,
    /// Work of path shortcutting, as a share of the work that finding the plan took; 0 disables it.
    pub shortcut_work_share: f64,
    /// Clearance between the robot and the world, and between its own links, at every sampled
    /// configuration, m.
    pub clearance: f64,
    /// How far the centre of mass stays inside the support polygon, m; of a small polygon at most
    /// 60 % of its depth. A robot with soft joints sways by about a centimetre.
    pub com_margin: f64,
    /// The share of a joint's effort limit that may be used, 0 to 1.
    pub effort_share: f64,
    /// How far joints stay from their position limits, rad or m.
    pub joint_margin: f64,
    /// The longest joint motion between two waypoints, rad.
    pub waypoint_joint_step: f64,
    /// The longest motion of any point of the robot between two collision samples, m.
    pub collision_step: f64,
    /// The smallest support area of a foot placement, m2; of a small sole at most 26 % of it, which
    /// is what the default asks of the reference robot's, but in any case a fifth more than the
    /// checker asks for.
    pub support_area_min: f64,
    /// Distance between the guide-route vertices at which footholds are sampled, m.
    pub route_vertex_spacing: f64,
}

impl Default for PlannerConfig {
    fn default() -> Self {
        Self {
            work_max: 4_000_000,
            tree_vertices_max: 8_192,
            footholds_max: 32_768,
            transitions_max: 1_048_576,
            configurations_max: 32_768,
            waypoints_max: 65_536,
            step_removal_rounds_max: 6,
            shortcut_work_share: 0.08,
            clearance: 0.006,
            com_margin: 0.02,
            effort_share: 0.8,
            joint_margin: 0.005,
            waypoint_joint_step: 0.04,
            collision_step: 0.01,
            support_area_min: 0.008,
            route_vertex_spacing: 0.25,
        }
    }
}

/// The checker's tolerances. Deserialised from a scenario's `[checker]` table, each field optional.
/// The loader refuses a scenario whose planner margins are not strictly larger than these.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CheckerConfig {
    /// How far a stance sole may be from its declared place, m.
    pub foot_position_max: f64,
    /// How far a stance sole may be turned from its declared pose, rad.
    pub foot_rotation_max: f64,
    /// A sole point counts as supported within this distance of a surface, m; also how deep a
    /// stance foot may press.
    pub contact_gap_max: f64,
    /// How far a supporting surface's normal may be from the sole's, rad.
    pub contact_tilt_max: f64,
    /// The smallest support area of a stance sole, m2.
    pub support_area_min: f64,
    /// How deep two things may overlap before it counts as a collision, m.
    pub penetration_max: f64,
    /// How far inside the equilibrium region the centre of mass must be, m.
    pub com_margin: f64,
    /// The share of a joint's effort limit that may be used.
    pub effort_share: f64,
    /// The longest joint motion between two waypoints, rad.
    pub joint_step_max: f64,
    /// The longest root motion between two waypoints, m.
    pub root_step_max: f64,
}

impl Default for CheckerConfig {
    fn default() -> Self {
        Self {
            foot_position_max: 2e-3,
            foot_rotation_max: 0.2 * std::f64::consts::PI / 180.0,
            contact_gap_max: 3e-3,
            contact_tilt_max: 5.0 * std::f64::consts::PI / 180.0,
            support_area_min: 5e-4,
            penetration_max: 2e-3,
            com_margin: 0.0,
            effort_share: 1.0,
            joint_step_max: 0.2,
            root_step_max: 0.1,
        }
    }
}
