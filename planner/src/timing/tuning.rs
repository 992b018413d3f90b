//! The constants of timing.

/// Least distance of the centre of pressure from the edge of a sole, m. A robot on stiff ankles
/// sways, and moves its centre of pressure by up to 15 mm from the planned one; beyond the edge it
/// rocks, a little more with each step. With 1.2 cm G1 and H1-2, whose soles are 7 cm wide, fall on
/// spiral stairs and past a gap, with 1.5 cm they stand within 7 mm.
pub(crate) const COP_MARGIN_MIN: f64 = 0.015;
/// The same as a share of the sole's width.
pub(crate) const COP_WIDTH_SHARE: f64 = 0.12;
/// How much further inside the centre of pressure stays on an inclined sole, m. A robot whose feet
/// drift by 5 mm meets ground of another inclination 2 to 4 mm early or late, and leans by 10 to
/// 20 mrad until both feet stand; that moves its weight by 1 to 2 cm.
pub(crate) const COP_MARGIN_INCLINED: f64 = 0.012;
/// The part of the rates that is used on an inclined sole: the load moves from one foot to the
/// other in 0.15 s in place of 0.1 s. With all of them G1 falls on blocks, with this part and with
/// half of them it stands.
pub(crate) const INCLINED_RATES_PART: f64 = 0.7;
/// Cosine of the inclination from which a sole counts as inclined: 2.6 degrees.
pub(crate) const INCLINED_COSINE: f64 = 0.999;
/// Soles whose heights differ by more do not lie in one level plane, m.
pub(crate) const LEVEL_HEIGHT_MAX: f64 = 5e-3;
/// Least distance of the centre of pressure where a configuration cannot stand otherwise, m: first
/// the larger, then the smaller.
pub(crate) const RELAXED_COP_MARGINS: [f64; 2] = [0.01, 0.004];
/// The part of the efforts that the controller allows on which a motion relies.
pub(crate) const CHECKED_EFFORT_PART: f64 = 0.998;
/// Distance (m) beyond the controller's margin by which the zero-moment point stays inside.
pub(crate) const ZERO_MOMENT_RESERVE: f64 = 4e-3;
/// The same where the world supports a part of a sole only: the controller samples that part, and
/// finds sides up to 4 mm further inside (`tests/support_agreement.rs`).
pub(crate) const ZERO_MOMENT_PARTIAL_RESERVE: f64 = 8e-3;
/// The most of it as a share of the distance of the region's centroid to its edge.
pub(crate) const ZERO_MOMENT_DEPTH_SHARE: f64 = 0.3;
/// The share of that distance that is kept where a configuration cannot stand otherwise.
pub(crate) const ZERO_MOMENT_BARE_SHARE: f64 = 0.5;
/// Distance (m) by which a motion may move the zero-moment point of any configuration: it is so
/// slow that the controller decides by the configuration alone.
pub(crate) const ZERO_MOMENT_SHIFT_MIN: f64 = 1e-3;
/// The most of it as a share of the distance to the controller's margin.
pub(crate) const ZERO_MOMENT_SHIFT_SHARE: f64 = 0.8;
/// Nearer to the margin of the zero-moment point than this (m) on a ramp, the point is that of the
/// motion as it is interpolated between waypoints; elsewhere it is interpolated between points of
/// the path, which differs by up to 5 mm where the point is near the margin.
pub(crate) const ZERO_MOMENT_DOUBT: f64 = 6e-3;
/// Distance (m) by which the pressure of a load that is interpolated between points of the path
/// may move and still be borne, where the motion itself is not looked at.
pub(crate) const CARRIED_DOUBT: f64 = 1e-2;
/// The part of the limits for which rates are computed. The rest covers what lies between two
/// points of the path; motions are checked against the whole limits.
pub(crate) const LIMITS_PART: f64 = 0.985;
/// Distance (m) by which rates keep the centre of pressure further inside, for the same reason.
pub(crate) const COP_MARGIN_EXTRA: f64 = 5e-4;
/// Distance (m) by which the samples of a motion keep it further inside, for the motion between
/// them.
pub(crate) const COP_MARGIN_BETWEEN: f64 = 2e-4;
/// Largest ratio of a motion's speed to that of the path's parameter.
pub(crate) const RATE_MAX: f64 = 30.0;
/// Largest acceleration of the path's parameter, 1/s.
pub(crate) const RATE_CHANGE_MAX: f64 = 300.0;
/// The acceleration from rest, in both directions, that a level must allow, 1/s. The last one must
/// allow that of a motion without known contact forces.
pub(crate) const REST_ACCELERATION: f64 = 0.2;
/// Friction below which less acceleration must be allowed, in proportion.
pub(crate) const SLICK_FRICTION: f64 = 0.1;
/// The largest rate of a motion, and its largest change, where no contact forces are known (1/s).
pub(crate) const UNSUPPORTED_RATE: f64 = 0.05;
/// Distance from the centre of pressure at which friction holds the moment about the normal of the
/// only stance sole, as a share of the sole's width: two points across it.
pub(crate) const TWIST_ARM_SHARE: f64 = 0.5;
/// The same on an inclined sole. A robot that is turned by 4 mrad drifts by 1 mm a step. Where
/// slabs are inclined in opposite directions, 6 mm aside are 3 mm of height: with 0.5 Talos lands
/// half a second late there, and falls.
pub(crate) const TWIST_ARM_SHARE_INCLINED: f64 = 0.25;
/// The same on a mesh whose corners are near each other. With 0.5 Talos turns on one of quads of
/// 5 cm whose corners are 0.4 mm high or low, and ends 0.2 m beside its path.
pub(crate) const TWIST_ARM_SHARE_ROUGH: f64 = 0.1;
/// The unit of moments in the balance of contacts, as a length, m.
pub(crate) const MOMENT_ARM: f64 = 0.1;
/// Directions in which the border of a set of rates is sought, beside the first ones.
pub(crate) const DIRECTIONS_MAX: usize = 10;
/// Part of a set of rates that may be missed by leaving out corners.
pub(crate) const BORDER_TOLERANCE: f64 = 4e-3;
/// Largest excess of a torque, as a share of its limit, before its row enters the program.
pub(crate) const TORQUE_TOLERANCE: f64 = 1e-6;
/// Largest speed (m/s) and angular speed (rad/s) of a stance sole between two points of the path,
/// where the legs' curves differ a little from the solution: 0.9 of what the controller allows.
pub(crate) const STANCE_SPEEDS_MAX: [f64; 2] = [0.018, 0.09];
/// Largest speed of a landing sole along its normal, m/s.
pub(crate) const TOUCHDOWN_SPEED_MAX: f64 = 0.05;
/// The same where the foot or the stance foot is inclined. A foot that lands 2 mm early turns the
/// robot about the other one: on legs four times as long as their distance the weight moves
/// sideways four times as fast as the foot moved down. A zero-moment point that is 3 cm inside
/// catches 0.1 m/s.
pub(crate) const LANDING_SPEED_INCLINED: f64 = 0.02;
/// How much that speed grows with the distance from the foothold, 1/s.
pub(crate) const LANDING_SPEED_BY_DISTANCE: f64 = 8.0;
/// Time over which speeds are averaged, so that acceleration is continuous, s.
pub(crate) const ROUNDING_TIME: f64 = 0.1;
/// Longest time between two waypoints, s.
pub(crate) const INTERVAL_MAX: f64 = 0.02;
/// Share of the controller's longest joint step that a joint moves between two waypoints: between
/// them it is a little faster.
pub(crate) const STEP_SHARE: f64 = 0.95;
/// Rounds in which torques beyond their limits enter a program.
pub(crate) const TORQUE_ROUNDS_MAX: usize = 12;
/// Rounds in which a profile is slowed down where it is beyond the limits.
pub(crate) const ROUNDS_MAX: usize = 32;
/// Rounds after those, in which all of it is slowed down.
pub(crate) const SLOW_DOWNS_MAX: usize = 14;
/// The factor of the rates in such a round; also the least one of the rounds before.
pub(crate) const SLOW_DOWN: f64 = 0.7;
/// How much slower than needed a profile becomes where it is beyond the limits.
pub(crate) const SLOWER: f64 = 0.995;
/// The ratio of a ramp's duration to that of the next shorter one tried.
pub(crate) const RAMP_STEP: f64 = 1.12;
/// Durations of ramps tried, at most.
pub(crate) const RAMP_STEPS_MAX: usize = 26;
/// Intervals of the first samples of a ramp.
pub(crate) const RAMP_SAMPLES: usize = 32;
/// Samples of a ramp between two waypoints.
pub(crate) const RAMP_PARTS: usize = 4;
/// Largest share of the rates around a point that a rounded profile takes: less than their distance
/// to the limits, against which the motion is checked after that.
pub(crate) const RATES_SHARE_MAX: f64 = 1.01;
/// Largest share of the rates around a point that a ramp takes where the motion at full speed takes
/// less: rates between two points are interpolated.
pub(crate) const RAMP_SHARE_MAX: f64 = 0.96;
/// Places in a chunk at which braking may end.
pub(crate) const REST_PLACES: usize = 4;
/// The time before the end of a chunk in which it becomes slower where it has no stop, s.
pub(crate) const SLOWER_BEFORE_STOP: f64 = 1.5;
