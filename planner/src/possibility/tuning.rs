//! Constants of stage P that decide which guide routes are found and how fast, grouped by step.
//!
//! Values without another source were chosen by the benchmarks of docs/BENCHES.md. Numerical
//! tolerances stand beside their formula.

// Distance between vertices.

/// Largest distance between two vertices, as a share of a leg's reach: one foot is set down at each
/// vertex, so that it is the distance of the feet along the route. Farther ones are beyond the
/// primitives of most robots.
pub(crate) const SPACING_PER_REACH: f64 = 0.42;

// Metric and steps between mid-feet poses.

/// Weight of height in the metric: stairs cost more than floors.
pub(crate) const HEIGHT_WEIGHT: f64 = 2.0;
/// Weight of heading in the metric, m/rad. Half a turn counts 0.94 m.
pub(crate) const HEADING_WEIGHT: f64 = 0.3;
/// A target nearer than this (m) is approached without turning to face it.
pub(crate) const TURNING_DISTANCE_MIN: f64 = 0.5;
/// Largest turn in place from one vertex to the next, rad: the turn of a foot in one step.
pub(crate) const TURN_IN_PLACE_MAX: f64 = 0.2;
/// Largest turn while walking from one vertex to the next, rad.
pub(crate) const TURN_WALKING_MAX: f64 = 0.35;
/// Largest deviation from its heading at which the robot walks, rad; beyond it, it turns in place.
pub(crate) const WALKING_DEVIATION_MAX: f64 = 0.7;
/// Share of a stride below which an offset to the target is not walked.
pub(crate) const WALKING_STRIDE_SHARE_MIN: f64 = 0.2;

// Vertex candidates (C_N and C_S).

/// Lowest and highest placement relative to the ideal sole pose, m.
pub(crate) const PLACEMENT_REACH_Z: [f64; 2] = [-0.5, 0.5];
/// Placements kept for each foot of a vertex.
pub(crate) const FOOT_PLACEMENTS_MAX: usize = 6;
/// Most placements kept at a vertex.
pub(crate) const VERTEX_PLACEMENTS_MAX: usize = 2 * FOOT_PLACEMENTS_MAX;
/// Steps between two vertices that are tested by inverse kinematics, the shortest ones first.
pub(crate) const STEPS_TRIED_MAX: usize = 8;
/// Longest distance between two tests of the upper body, m: less than the thickness of any upper
/// body.
pub(crate) const FIT_STEP: f64 = 0.12;
/// Cost of a metre between the heights of two feet when a pair is chosen.
pub(crate) const HEIGHT_DIFFERENCE_COST: f64 = 2.0;
/// Cost of a metre between the height of a pair and that of the target: of several elevations the
/// one nearest to the target's is chosen [Grey 4.3].
pub(crate) const AWAY_FROM_TARGET_COST: f64 = 0.5;
/// Crouches of the upper body that are tested: share of the standing height, and pitch, rad.
pub(crate) const UPPER_BODY_CROUCHES: [(f64, f64); 6] =
    [(1.0, 0.0), (0.92, 0.1), (0.84, 0.2), (0.75, 0.3), (0.66, 0.35), (1.06, 0.0)];
/// Height above the soles at which the test of the legs begins, m: it clears rough ground.
pub(crate) const SOLE_CLEARANCE: f64 = 0.05;
/// Half the thickness of the box from a hip to a sole in the test of the legs, m.
pub(crate) const LEG_HALF_WIDTH: f64 = 0.005;

// Root postures.

/// Smallest and largest leg extension of a root posture, as a share of the standing one.
pub(crate) const POSTURE_LEG_EXTENSIONS: [f64; 2] = [0.6, 1.03];
/// Smallest and largest leg extension of a root posture of robots whose waist bends, and of the
/// postures of further searches, as a share of the standing one.
pub(crate) const DEEP_LEG_EXTENSIONS: [f64; 2] = [0.45, 1.03];
/// Smallest and largest forward pitch of the root in a posture, rad.
pub(crate) const POSTURE_PITCHES: [f64; 2] = [-0.35, 1.6];
/// Smallest and largest roll of the root in a posture, rad: beyond half a radian the hips of most
/// humanoids end.
pub(crate) const POSTURE_ROLLS: [f64; 2] = [-0.5, 0.5];
/// Distance between vertices where the root leans, as a share of that elsewhere.
pub(crate) const LEANING_SPACING_SHARE: f64 = 0.5;
/// Most root postures that are kept.
pub(crate) const POSTURES_MAX: usize = 1024;
/// Root postures that are tried for each search that needs them; about half are feasible.
pub(crate) const POSTURES_TRIED: u64 = 512;
/// Root postures that are tried at a vertex.
pub(crate) const POSTURES_PER_VERTEX: usize = 48;
/// Cost of a change of posture, relative to that of leaning.
pub(crate) const POSTURE_CHANGE_COST: f64 = 0.5;
/// Passes over a route that reduce the lean at each vertex.
pub(crate) const LEAN_PASSES: usize = 3;
/// Once a world has asked for leaning, one of this many other routes begins with it.
pub(crate) const LEANING_EVERY: u64 = 3;
/// Longest distance between two tests of the root along an edge, m.
pub(crate) const ROOT_TEST_STEP: f64 = 0.06;
/// Largest turn of the root between two tests along an edge, rad.
pub(crate) const ROOT_TEST_TURN: f64 = 0.12;

// Samples.

/// Samples drawn under C_S, and as many under C_N alone, for each [`SAMPLED_LENGTH`] of the region.
pub(crate) const REGION_SAMPLES_MAX: f64 = 384.0;
/// A search with leaning roots draws this part of the samples: its vertices cost more.
pub(crate) const LEANING_SAMPLES_DIVISOR: u32 = 4;
/// Length of a region for which [`REGION_SAMPLES_MAX`] samples suffice, m.
pub(crate) const SAMPLED_LENGTH: f64 = 10.0;
/// Length up to which a region counts as short, m.
pub(crate) const SHORT_LENGTH_MAX: f64 = 12.0;
/// Margin of the sampled region around the box of both ends: at least this, m, and this share of
/// their distance.
pub(crate) const REGION_MARGIN: (f64, f64) = (2.5, 0.5);
/// Growth of the sampled region on each side where it holds no route, as a share of its horizontal
/// diagonal: a detour as long as the wall that asks for it is found after few widenings.
pub(crate) const REGION_GROWTH: f64 = 0.25;
/// Attempts of the first search in wider regions after a tree was full.
pub(crate) const WIDENINGS_MAX: u32 = 16;
/// One of this many samples of a tree lies anywhere; the others lie ahead of a vertex.
pub(crate) const ANYWHERE_EVERY: u32 = 4;
/// Only this many of the latest vertices are extended; older ones are assumed to be exhausted.
pub(crate) const RECENT_VERTICES: usize = 192;
/// In a long region each metre from the root of the other tree counts as this many neighbours, so
/// that the front of the tree is extended first.
pub(crate) const NEIGHBOURS_PER_METRE: f64 = 2.0;
/// Shortest and longest distance of a sample ahead of its vertex, m.
pub(crate) const AHEAD_DISTANCES: [f64; 2] = [0.5, 1.5];
/// Largest angle of a sample ahead off the heading of its vertex, rad.
pub(crate) const AHEAD_TURN_MAX: f64 = 1.0;
/// Largest height of a sample ahead above or below its vertex, m.
pub(crate) const AHEAD_RISE_MAX: f64 = 0.4;
/// Vertices within this distance (metric of Gamma_P, m) count as neighbours.
pub(crate) const NEIGHBOUR_RADIUS: f64 = 0.5;

// Branches.

/// Most branches that grow in parallel.
pub(crate) const BRANCHES_MAX: usize = 8;
/// Most vertices of one branch.
pub(crate) const BRANCH_VERTICES_MAX: usize = 97;
/// Strides tried by an extension, as multiples of the vertex spacing, each with its lateral offset,
/// m. Longer strides lead across gaps.
pub(crate) const EXTENSION_STRIDES: [(f64, f64); 7] =
    [(1.0, 0.0), (1.8, 0.0), (2.6, 0.0), (1.0, 0.06), (1.0, -0.06), (1.0, 0.12), (1.0, -0.12)];
/// Number of them that are tried without sidestepping: narrow passages leave little clearance in
/// front of the robot and behind it.
pub(crate) const STRIDES_AHEAD: usize = 3;
/// Share of a stride by which a vertex must come nearer to the target.
pub(crate) const PROGRESS_MIN: f64 = 0.25;
/// Distance to the target, in vertex spacings, at which a branch may join it.
pub(crate) const JOINING_SPACINGS: f64 = 1.3;
/// Largest difference in height between two vertices under the strictest condition and under the
/// next, as shares of a leg's reach: the height of one step.
pub(crate) const EDGE_CLIMB_MAX: [f64; 2] = [0.4, 0.55];
/// Largest turn with which a branch joins its target, rad.
pub(crate) const JOINING_TURN_MAX: f64 = 0.5;
/// Largest displacement of a vertex in a turn in place, m.
pub(crate) const TURN_DRIFT_MAX: f64 = 0.2;

// Route search.

/// Branches that grow in parallel toward samples at first, one of each tree. No branch uses the
/// results of the others, so few branches make a short search.
pub(crate) const PARALLEL_BRANCHES_MIN: usize = 2;
/// Samples after which one more branch grows in parallel.
pub(crate) const SAMPLES_PER_BRANCH: u32 = 32;
/// The first of every this many restarted routes is walked backward.
pub(crate) const BACKWARD_EVERY: u64 = 3;
/// Distance to the goal at which the straight-line route ends (metric of Gamma_P, m).
pub(crate) const STRAIGHT_END_DISTANCE: f64 = 0.02;
/// Most regions excluded from sampling; beyond it the oldest is dropped.
pub(crate) const BLOCKED_REGIONS_MAX: usize = 64;

// Coarse path.

/// Most legs of a coarse path that is followed.
pub(crate) const COARSE_LEGS_MAX: usize = 512;
/// How far behind the end of a leg its branch heads for, in vertex spacings.
pub(crate) const LEG_OVERSHOOT: f64 = 0.8;
/// Distance at which a vertex counts as the end of a leg, m.
pub(crate) const LEG_END_DISTANCE: f64 = 0.5;

// Route shortcuts.

/// Shortcuts that are tried in parallel, on a short and on a long route. Of those that overlap at
/// most one is taken.
pub(crate) const PARALLEL_SHORTCUTS: [usize; 2] = [2, BRANCHES_MAX];
/// Shortcuts tried on a route of up to [`SHORTCUT_SPAN_MAX`] vertices, each by one branch.
pub(crate) const SHORTCUTS_MAX: usize = 12;
/// Shortcuts tried on a longer route for each [`SHORTCUT_SPAN_MAX`] of its vertices.
pub(crate) const LONG_SHORTCUTS_MAX: usize = 36;
/// Most vertices that a shortcut spans. Half as many on a longer route, which is about the average
/// on a short one.
pub(crate) const SHORTCUT_SPAN_MAX: usize = 96;
/// Draws of the ends of a shortcut of which the one with the longest detour is taken.
pub(crate) const SHORTCUT_DRAWS: usize = 8;
/// Fewest vertices that a shortcut spans.
pub(crate) const SHORTCUT_SPAN_MIN: usize = 3;

// Guide route.

/// A foot within this distance of a vertex (metric of Gamma_P, m) has the heading of the robot
/// there. Half a turn counts 0.94 m.
pub(crate) const ALIGNED_DISTANCE: f64 = 0.6;

// Crouch profile.

/// Leg extensions of the crouches, as shares of the standing one.
pub(crate) const CROUCH_LEG_EXTENSIONS: [f64; 5] = [1.0, 0.92, 0.84, 0.76, 0.68];
/// Forward pitches of the root in the crouches, rad.
pub(crate) const CROUCH_PITCHES: [f64; 5] = [0.0, 0.3, 0.6, 0.9, 1.2];
/// Offsets of the swing foot ahead of the stance foot at which a crouch is tested, m.
pub(crate) const CROUCH_TEST_STRIDES: [f64; 3] = [0.0, 0.2, -0.2];
/// If the upright robot fits at this many vertices before and after, every crouch counts as free.
pub(crate) const OPEN_REACH: usize = 6;
/// Collision tests between one vertex and the next.
pub(crate) const EDGE_TESTS: usize = 2;
/// Cost of a collision. Finite, because arms may move and the root shifts in single support.
pub(crate) const COLLISION_COST: f64 = 30.0;
/// Cost of each single-support stance in which a crouch is infeasible.
pub(crate) const INFEASIBLE_COST: f64 = 3.0;
/// Cost of each neighbouring crouch that collides.
pub(crate) const NEIGHBOUR_COST: f64 = 1.0;
/// Cost of a change to a neighbouring crouch.
pub(crate) const CHANGE_COST: f64 = 0.5;
/// Offsets to the left of the route at which the trunk is tested, m.
pub(crate) const TRUNK_OFFSETS: [f64; 3] = [0.0, 0.15, -0.15];
/// Crouches or vertices that are evaluated in parallel.
pub(crate) const CROUCH_BATCH_MAX: usize = 32;
