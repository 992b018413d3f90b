//! Constants of the constraints that change which configurations are accepted.

/// Largest part of a mode's depth that the margin of the centre of mass takes up. It keeps a region
/// in small support polygons.
pub(crate) const MARGIN_DEPTH_SHARE_MAX: f64 = 0.6;
/// The margin of the centre of mass is at least this much larger than the checker's (m), however
/// small the support: the checker counts less of an edge of the ground, which the foot may miss.
pub(crate) const COM_MARGIN_RESERVE: f64 = 4e-3;
/// Largest loss of margin (m) of a motion from a start below the margin; at most half of the spare
/// margin is lost.
pub(crate) const START_MARGIN_LOSS_MAX: f64 = 4e-3;
/// Shares of the weight on the right foot that are tried in double support, after the share that
/// follows from the centre of mass.
pub(crate) const LOAD_SHARES: [f64; 5] = [0.5, 0.25, 0.75, 0.1, 0.9];
/// Those that are tried once the margins are relaxed, in order of their distance from an even one.
pub(crate) const MORE_LOAD_SHARES: [f64; 19] = [
    0.5, 0.45, 0.55, 0.4, 0.6, 0.35, 0.65, 0.3, 0.7, 0.25, 0.75, 0.2, 0.8, 0.15, 0.85, 0.1, 0.9,
    0.05, 0.95,
];
/// Fewest intervals in which a motion between two configurations is checked.
pub(crate) const INTERVALS_MIN: f64 = 2.0;
/// Share of the joints' margin that the curve between two configurations may use.
pub(crate) const CURVE_MARGIN_SHARE: f64 = 0.5;
/// Rounding of a joint on a curve, rad or m.
pub(crate) const CURVE_ROUNDING: f64 = 5e-7;

// Waist.

/// Largest forward bend of the waist in a crouch, rad.
pub(crate) const WAIST_BEND_MAX: f64 = 0.7;
/// Step of the bends that are tested for collisions between links, rad.
pub(crate) const BEND_STEP: f64 = 0.02;
/// Angle by which a joint is moved to find out whether it bends the trunk forward, rad.
pub(crate) const BEND_TEST_ANGLE: f64 = 0.1;
/// Least ratio of the motion of the centre of mass along x to all of it for which it does.
pub(crate) const BEND_PURITY_MIN: f64 = 0.9;
/// Least lever of the whole mass about such a joint, m.
pub(crate) const BEND_LEVER_MIN: f64 = 0.02;
