//! The kinds of splines along a searched motion that are tried in order, from the smoothest to the
//! nearest to the motion.

/// What a spline along a searched motion is a spline of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum FollowedKind {
    /// The centre of mass, the soles, the root's height and rotation, and the free joints. The legs
    /// follow from these.
    Soles,
    /// The root and all joints: it stays within the limits of the joints and near the motion, and
    /// stance soles drift a little between two keys, as they do in the motion itself.
    Joints,
}

/// How a searched motion is followed.
#[derive(Debug, Clone, Copy)]
pub(crate) struct FollowedTrial {
    pub kind: FollowedKind,
    /// How often every other key is left out where the swing foot is far from its footholds.
    pub coarsenings: u8,
    /// How often the distance of two keys is halved.
    pub refinements: u8,
}

/// The trials in order. Those with fewer keys are for swings only: in double support the load
/// would move from foot to foot so fast that robots sway.
pub(crate) const FOLLOWED_TRIALS: [FollowedTrial; 10] = [
    coarse(FollowedKind::Soles, 3),
    coarse(FollowedKind::Soles, 2),
    coarse(FollowedKind::Soles, 1),
    fine(FollowedKind::Soles, 0),
    coarse(FollowedKind::Joints, 2),
    fine(FollowedKind::Soles, 1),
    fine(FollowedKind::Soles, 2),
    fine(FollowedKind::Joints, 0),
    fine(FollowedKind::Joints, 1),
    fine(FollowedKind::Joints, 2),
];

/// The first trial from `first` on for a phase in which a foot swings or none does.
pub(crate) fn next_trial(first: u8, has_swing: bool) -> Option<u8> {
    let suits = |trial: &FollowedTrial| has_swing || trial.coarsenings == 0;
    let place = FOLLOWED_TRIALS.iter().skip(usize::from(first)).position(suits)?;
    Some(first + place as u8)
}

/// A trial with fewer keys.
const fn coarse(kind: FollowedKind, coarsenings: u8) -> FollowedTrial {
    FollowedTrial { kind, coarsenings, refinements: 0 }
}

/// A trial with more keys.
const fn fine(kind: FollowedKind, refinements: u8) -> FollowedTrial {
    FollowedTrial { kind, coarsenings: 0, refinements }
}
