//! Constants of stage M that decide which motions are found and how fast, grouped by the stage that
//! uses them.
//!
//! Values without another source were chosen by the benchmarks of docs/BENCHES.md. The tables of
//! swing shapes stand in `swing_shapes`. Numerical tolerances stand beside their formula.

// Mode graph.

/// Footholds of one foot closer than this are the same, m.
pub(crate) const SAME_DISTANCE_MAX: f64 = 0.01;
/// Footholds of one foot turned less than this against each other are the same: sine of half the
/// angle.
pub(crate) const SAME_HALF_SINE_MAX: f64 = 0.02;

/// S(T) with which another transition on the same footholds begins: sampling skips the attempts
/// before, which are primitive postures.
pub(crate) const ALTERNATIVE_ATTEMPTS: u32 = 13;

// Transition sequence.

/// The penalty p for each failed single-mode search between two transitions, m^3 [Grey 4.4.2]. It
/// is at least the cost of an untried transition of usual length, however unlikely its prior makes
/// it.
pub(crate) const SINGLE_MODE_PENALTY: f64 = 4.0;
/// Cost of each transition in addition to S(T) D^3(T) when steps are removed, m^3. It makes steps
/// of about 0.3 m the cheapest.
pub(crate) const FEWER_STEPS_BASE: f64 = 0.05;
/// Swings that one work unit of the sequence search relaxes. The swings of one stance foothold are
/// never divided.
pub(crate) const SWINGS_PER_UNIT: u64 = 64;

// Transition prior.

/// Attempts that count for each primitive posture that fails before one is valid.
pub(crate) const POSTURE_ATTEMPTS: u32 = 3;
/// Additional attempts that count for crossed feet, to which few swings lead.
pub(crate) const CROSSED_ATTEMPTS: u32 = 3;
/// Additional attempts that count for each foothold with partial support: small errors of the sole
/// position make the robot slip off it [Grey 4.1.2].
pub(crate) const PARTIAL_SUPPORT_ATTEMPTS: u32 = 8;
/// Share of a sole's area below which its support is partial.
pub(crate) const SUPPORT_SHARE_MIN: f64 = 0.6;

// Transition configurations.

/// Most attempts at one transition in one batch; each counts with its weight.
pub const ATTEMPTS_MAX: u32 = 24;
/// Distances along the sole's normal by which a swing foot is lifted before it moves aside, m;
/// tried in order.
pub(crate) const LIFT_HEIGHTS: [f64; 2] = [0.02, 0.012];
/// Largest distance along x and y of a lift-off in a random direction, m.
pub(crate) const ASIDE_MAX: f64 = 0.03;
/// Largest turn about each axis of a lift-off in a random direction, rad.
pub(crate) const ASIDE_TURN_MAX: f64 = 0.15;
/// Most draws of a random direction in which the sole does not slide.
pub(crate) const ASIDE_DRAWS_MAX: usize = 32;

// Local planner.

/// Most root shifts per waypoint that correct the centre of mass.
pub(crate) const WAYPOINT_COM_SHIFTS_MAX: usize = 4;
/// Shortest step, as a share of the local path. A shorter one means that a joint would jump.
pub(crate) const PATH_STEP_MIN: f64 = 1.0 / 4096.0;
/// Share of the longest allowed step that the next step aims at.
pub(crate) const PATH_STEP_AIM: f64 = 0.95;
/// Root or sole displacement that the first step of a local path aims at, m.
pub(crate) const FIRST_STEP_LENGTH: f64 = 0.03;
/// Longest displacement of any point of the robot between two waypoints, in collision steps.
pub(crate) const WAYPOINT_COLLISION_STEPS: f64 = 4.0;
/// Largest leg extension of a moving robot, as a share of the leg's reach.
pub(crate) const MOVING_LEG_EXTENSION_MAX: f64 = 0.997;
/// Largest leg extension of a motion with a raised root, as a share of the leg's reach.
pub(crate) const RAISED_LEG_EXTENSION: f64 = 0.96;
/// Roll of the pelvis that raises the hip of the swing leg in a motion with a raised root, rad.
pub(crate) const HIP_RAISE: f64 = 0.2;

// Metric of configurations.

/// Length that one radian counts, m: about the distance from the hip to a hand or a toe.
pub(crate) const METRES_PER_RADIAN: f64 = 0.35;

// Single-mode search.

/// Points of a swing shape that are tested before the shape is followed, evenly spaced. They reject
/// most infeasible shapes at little cost. The first shape is the likeliest and is followed at once.
pub(crate) const PROBES: u32 = 7;
/// Samples of the first CBiRRT search between two states, and of each later one. Most paths are
/// found by few samples, and another sequence may be easier.
pub(crate) const TREE_SAMPLES_MAX: [u32; 2] = [36, 64];
/// Most waypoints that one extension adds toward a sample.
pub(crate) const EXTENSION_WAYPOINTS_MAX: u32 = 24;
/// Spread of root samples about the straight line between both ends, as a share of the leg's reach.
/// In single support the line lies higher by the same amount, because an upright robot has more
/// space for the swing foot.
pub(crate) const ROOT_SPREAD: f64 = 0.2;
/// Spread of the rotation of root samples, rad.
pub(crate) const ROOT_TURN_SPREAD: f64 = 0.25;
/// Spread of swing sole samples about the straight line, as a share of the leg's reach. Most are
/// out of reach and lead the foot around obstacles.
pub(crate) const SOLE_SPREAD: f64 = 0.75;
/// Spread of the rotation of swing sole samples, rad.
pub(crate) const SOLE_TURN_SPREAD: f64 = 0.5;
/// Spread of free joints about the straight line, rad; every other sample, on average, moves them.
pub(crate) const FREE_JOINT_SPREAD: f64 = 0.6;

/// Failed searches of a motion after which the boxes of its samples grow, and its searches become
/// longer.
pub(crate) const GROWTH_FROM: u32 = 4;
/// Each failed search then doubles the boxes, up to this number of times; the next begins again
/// with the smallest ones, which suit most motions.
pub(crate) const DOUBLINGS_MAX: u32 = 4;
/// Failed searches after which the number of samples of a search doubles.
pub(crate) const SAMPLES_DOUBLE_EVERY: u32 = 5;
/// Most samples of a CBiRRT search.
pub(crate) const TREE_SAMPLES_LIMIT: u32 = 1024;
/// One of this many samples with grown boxes extends a random node instead of the nearest one,
/// because the metric does not count free joints.
pub(crate) const RANDOM_NODE_EVERY: usize = 4;

// Shortcuts.

/// Swing soles nearer than this to where a motion begins or ends keep their path, m: they lift off
/// and land along the sole's normal.
pub(crate) const LIFT_OFF_KEPT: f64 = 0.012;
/// Share by which a shortcut must shorten the part of the path that it replaces.
pub(crate) const SHORTCUT_GAIN_MIN: f64 = 0.05;
/// A shortcut is tried only if the straight line is shorter than this share of the allowed length:
/// the joints of a leg do not move straight where its sole does.
pub(crate) const STRAIGHT_SHARE_MAX: f64 = 0.9;
/// Consecutive failed shortcuts that end the pass.
pub(crate) const SHORTCUT_FAILURES_MAX: u32 = 6;
/// At a corner the path over the middle waypoint exceeds the straight line by this share.
pub(crate) const CORNER_EXCESS_MIN: f64 = 0.02;
/// Work units that shortcuts of a motion may spend for each of its waypoints.
pub(crate) const SHORTCUT_WORK_PER_WAYPOINT: u64 = 2;

// Batches and capacities.

/// Route segments that are planned in parallel.
pub const SEGMENT_SEARCHES_MAX: usize = 4;
/// Searches that run in parallel in one batch.
pub(crate) const BATCH_SEARCHES_MAX: usize = 32;
/// Most waypoints of one single-mode motion.
pub(crate) const PATH_WAYPOINTS_MAX: usize = 1024;
/// Most waypoints of a lift-off.
pub(crate) const LIFT_OFF_WAYPOINTS_MAX: usize = 128;
/// Most waypoints of a shortcut.
pub(crate) const SHORTCUT_WAYPOINTS_MAX: usize = 256;
/// Most nodes of one tree.
pub(crate) const TREE_NODES_MAX: usize = 1024;
/// Trees that are kept from batch to batch; one batch uses at most two for each of its searches.
pub(crate) const TREES_MAX: usize = 64;
/// Waypoints of found motions per waypoint of the longest plan allowed; not all motions are used.
pub(crate) const MOTIONS_PER_PLAN: usize = 3;
