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
    /// How often the distance of two keys is halved.
    pub refinements: u8,
}

/// The trials in order.
pub(crate) const FOLLOWED_TRIALS: [FollowedTrial; 6] = [
    FollowedTrial { kind: FollowedKind::Soles, refinements: 0 },
    FollowedTrial { kind: FollowedKind::Soles, refinements: 1 },
    FollowedTrial { kind: FollowedKind::Soles, refinements: 2 },
    FollowedTrial { kind: FollowedKind::Joints, refinements: 0 },
    FollowedTrial { kind: FollowedKind::Joints, refinements: 1 },
    FollowedTrial { kind: FollowedKind::Joints, refinements: 2 },
];
