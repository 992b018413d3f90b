//! Constants of collision checks that change which motions are accepted, or how fast they are
//! checked.

// Feet.

/// Lift (m) of a stance foot before its test: the sole may touch the ground but not sink deeper.
pub(crate) const STANCE_LIFT: f64 = 0.0015;
/// Lift (m) of a foot in lift-off beyond its clearance before its test: ground may rise so far into
/// a sole that is placed on it. The controller allows 0.5 mm where a smooth motion lands, and
/// measures at other places: with 0.5 mm here it found 0.64 mm on a mesh.
pub(crate) const LIFT_OFF_LIFT: f64 = 0.0003;
/// How far a sole may move while it may still touch its foothold, m; less than the controller
/// allows (6 mm).
pub(crate) const SLIDE_MAX: f64 = 5e-3;
/// How far a sole may turn while it may still touch its foothold, rad; less than the controller
/// allows (0.025).
pub(crate) const SLIDE_TURN_MAX: f64 = 0.02;
/// Height at which a corner of a sole is clear of its foothold, m; the controller's distance is
/// 1 mm.
pub(crate) const SLIDE_CLEAR_MIN: f64 = 1.5e-3;
/// Largest height (m) of a sole above or below a keep-out zone at which the zone applies.
pub(crate) const KEEP_OUT_HEIGHT: f64 = 0.05;

// World.

/// Most shapes near the robot that are listed; a longer list is slower than the tree.
pub(crate) const NEARBY_MAX: usize = 24;

// Self-collision.

/// Random configurations that show which pairs always collide.
pub(crate) const SURVEY_SAMPLES: usize = 300;
/// Fewest colliding samples (95 %) of a pair that may touch if it does in the standing posture.
pub(crate) const COLLIDING_SAMPLES_MIN: usize = SURVEY_SAMPLES * 95 / 100;
/// Most moving joints between a pair that may touch because it does in the standing posture.
pub(crate) const NEIGHBOR_JOINTS_MAX: usize = 3;
