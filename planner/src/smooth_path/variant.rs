//! The variants of a step that are tried in order, from the smoothest to the nearest to the
//! searched motion.

/// How the path passes a stance and the swing over it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Variant {
    /// Height of the swing sole above its higher end, m.
    pub lift: f64,
    /// Share of the swing at both ends in which the sole hardly moves across.
    pub aside: f64,
    /// Largest angle (rad) by which the sole lowers its front after lift-off.
    pub roll_off: f64,
    /// Distance of the entry and the exit of the centre of mass from the centroid of the stance, as
    /// a share of the distance to the neighbouring stance.
    pub overlap: f64,
    /// Keys on either side over which the root keeps one height, in addition to those that a
    /// cubic spline needs.
    pub level_keys: f64,
    /// Largest share of its reach that a leg uses.
    pub leg_extension: f64,
    /// Whether the root and the free joints follow the plan's own configurations at both ends of
    /// the swing. Otherwise they take the mean of both, as high as the legs allow.
    pub follows_plan: bool,
}

/// The variants in the order in which they are tried.
pub(crate) const VARIANTS: [Variant; 13] = [
    in_mean_posture([0.04, 0.06, 0.0], 0.3, 2.0, 0.94),
    in_mean_posture([0.07, 0.15, 0.0], 0.3, 0.0, 0.94),
    in_mean_posture([0.05, 0.1, 0.0], 0.3, 0.0, 0.97),
    in_mean_posture([0.05, 0.1, 0.4], 0.3, 0.0, 0.97),
    in_planned_posture([0.05, 0.15, 0.0], 0.3),
    in_planned_posture([0.05, 0.15, 0.4], 0.3),
    in_planned_posture([0.1, 0.2, 0.0], 0.2),
    in_planned_posture([0.1, 0.2, 0.5], 0.2),
    in_mean_posture([0.1, 0.25, 0.0], 0.1, 0.0, 0.97),
    in_mean_posture([0.1, 0.25, 0.6], 0.1, 0.0, 0.97),
    in_planned_posture([0.16, 0.3, 0.0], 0.1),
    in_planned_posture([0.16, 0.3, 0.6], 0.1),
    in_planned_posture([0.25, 0.35, 0.0], 0.1),
];

/// A variant whose root is as high as the legs allow.
const fn in_mean_posture(
    [lift, aside, roll_off]: [f64; 3],
    overlap: f64,
    level_keys: f64,
    leg_extension: f64,
) -> Variant {
    Variant { lift, aside, roll_off, overlap, level_keys, leg_extension, follows_plan: false }
}

/// A variant that follows the plan's own configurations.
const fn in_planned_posture([lift, aside, roll_off]: [f64; 3], overlap: f64) -> Variant {
    Variant {
        lift,
        aside,
        roll_off,
        overlap,
        level_keys: 0.0,
        leg_extension: 0.98,
        follows_plan: true,
    }
}
