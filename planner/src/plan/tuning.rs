//! The constants of a plan's timing. They decide how fast a plan moves.

/// The fastest joint of a plan, rad/s or m/s: slow enough to be quasi-static for every robot that
/// was replayed in a physics simulator.
pub(crate) const JOINT_SPEED_MAX: f64 = 0.4;
/// The fastest root of a plan, m/s, for the same reason.
pub(crate) const ROOT_SPEED_MAX: f64 = 0.12;
/// The shortest time between two waypoints, s.
pub(crate) const WAYPOINT_INTERVAL_MIN: f64 = 0.01;
/// The share of the robot's own speed limits that a plan uses.
pub(crate) const LIMIT_SHARE: f64 = 0.95;
/// The share of the robot's acceleration limits by which the speed changes at a waypoint, over half
/// the time of both intervals beside it. A joint that keeps to the waypoints with a continuous
/// speed needs up to twice as much.
pub(crate) const ACCELERATION_SHARE: f64 = 0.5 * LIMIT_SHARE;
/// The share of the balance reserve, the margin of a motion beyond the checker's, by which
/// accelerations may move the zero-moment point. The rest covers that the checker's region is
/// smaller where ground ends under a foot.
pub(crate) const CENTRE_SHIFT_SHARE: f64 = 0.8;
/// The share of the friction that accelerations may use, for the same reason.
pub(crate) const FRICTION_SHARE: f64 = 0.8;
/// The balance reserve of a motion that has less, m: it is so slow that the checker decides by the
/// configurations alone.
pub(crate) const BALANCE_RESERVE_MIN: f64 = 2e-4;
/// A change of the speed of the centre of mass at a waypoint counts as spread over at most this
/// time, s.
pub(crate) const SPREAD_MAX: f64 = 0.2;
/// The time of a motion along a polynomial of degree 5 from rest to rest over that of a motion with
/// two equal accelerations: its largest acceleration is `5.78 d / T^2`, that of the other one
/// `2 d / T^2`.
pub(crate) const POLYNOMIAL_SLOWDOWN: f64 = 1.75;
/// Sweeps over the intervals, forward and backward alternately. More sweeps give shorter times.
pub(crate) const SWEEPS: usize = 4;
/// Halvings in the search for an interval's shortest time. More halvings give shorter times.
pub(crate) const HALVINGS: usize = 6;
