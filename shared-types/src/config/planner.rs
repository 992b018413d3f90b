//! The parameters of the planner and of the checker.

/// Largest drift of a stance foot from its pose between two waypoints of a plan, m.
pub const FOOT_DRIFT_MAX: f64 = 1.0e-3;
/// Largest rotation of a stance foot from its pose between two waypoints of a plan, rad.
pub const FOOT_TURN_MAX: f64 = 1.7e-3;
/// Largest distance of a supporting surface from the plane of a planned sole, m.
pub const CONTACT_GAP_MAX: f64 = 1e-3;
/// Largest angle between the normals of a supporting surface and a planned sole, rad.
pub const CONTACT_TILT_MAX: f64 = 4.0 * std::f64::consts::PI / 180.0;

/// The planner's parameters: a scenario's `[planner]` table, in which every field is optional.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct PlannerConfig {
    /// Most work units of the whole search. A work unit is the smallest step of the search, about
    /// 10 µs on average (`surefoot bench steps` measures each kind).
    pub work_max: u64,
    /// Most vertices in each tree of stage P.
    pub tree_vertices_max: u32,
    /// Most footholds of stage M.
    pub footholds_max: u32,
    /// Most transitions of stage M.
    pub transitions_max: u32,
    /// Most transition configurations. The roadmap holds up to four times as many motions between
    /// them.
    pub configurations_max: u32,
    /// Most waypoints of a plan. A waypoint shared by two chunks counts once.
    pub waypoints_max: u32,
    /// Most sequences tried to remove steps from a complete route segment; 0 removes no steps.
    pub step_removal_rounds_max: u32,
    /// Work of path shortcutting as a share of the work before it; 0 disables shortcutting.
    pub shortcut_work_share: f64,
    /// Smallest distance between the robot and the world, and between links, at every sampled
    /// configuration, m.
    pub clearance: f64,
    /// Smallest distance of the centre of mass from the edge of the support polygon, m; for a small
    /// polygon at most 60 % of its depth. A robot with compliant joints sways by about 1 cm.
    pub com_margin: f64,
    /// Largest share of a joint's effort limit in use, 0 to 1.
    pub effort_share: f64,
    /// Smallest distance of a joint from its position limits, rad or m.
    pub joint_margin: f64,
    /// Largest joint motion between two waypoints, rad.
    pub waypoint_joint_step: f64,
    /// Largest motion of any point of the robot between two collision checks, m.
    pub collision_step: f64,
    /// Smallest support area of a foot placement, m2; for a small sole at most 26 % of its area
    /// (the share that the default requires of the reference robot), but at least 1.2 times the
    /// checker's `support_area_min`.
    pub support_area_min: f64,
    /// Distance between the guide-route vertices at which footholds are sampled, m; at most 42 % of
    /// the reach of a leg.
    pub route_vertex_spacing: f64,
    /// Guide routes that are alive at once: stage M works on them in turn, while stage P grows
    /// further ones. With 1 stage P waits for stage M. Memory is reserved for each.
    pub live_routes: u32,
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
            live_routes: 1,
        }
    }
}

/// The checker's tolerances: a scenario's `[checker]` table, in which every field is optional. The
/// planner's margins must be strictly stronger; the loader checks it.
#[derive(Debug, Clone, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(default, deny_unknown_fields)]
pub struct CheckerConfig {
    /// Largest distance of a stance sole from its declared position, m.
    pub foot_position_max: f64,
    /// Largest rotation of a stance sole from its declared pose, rad.
    pub foot_rotation_max: f64,
    /// Largest distance between a supported point of a sole and the surface, m; also the largest
    /// penetration of a stance foot.
    pub contact_gap_max: f64,
    /// Largest angle between the normals of a supporting surface and the sole, rad.
    pub contact_tilt_max: f64,
    /// Smallest support area of a stance sole, m2.
    pub support_area_min: f64,
    /// Largest overlap of two links, and of a foot and the world, that is not yet a collision, m.
    /// Other links stay out of the world.
    pub penetration_max: f64,
    /// Smallest distance of the centre of mass from the edge of the equilibrium region, m.
    pub com_margin: f64,
    /// Largest share of a joint's effort limit in use, 0 to 1.
    pub effort_share: f64,
    /// Largest joint motion between two waypoints, rad.
    pub joint_step_max: f64,
    /// Largest root motion between two waypoints, m.
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
            com_margin: 5e-3,
            effort_share: 0.95,
            joint_step_max: 0.2,
            root_step_max: 0.1,
        }
    }
}
