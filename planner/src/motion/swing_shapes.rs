//! Shapes of motions between two states of a mode: the trajectory of the swing sole, and whether
//! the root rises. They are the parametrised primitive trajectories with which a single-mode search
//! begins [Grey 4.4.5].

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::{interpolate, rotation_about, yaw_of};

use crate::primitives::level_sole::side_of;

/// Shape of a motion between two states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct MotionShape {
    /// Trajectory of the swing sole.
    pub swing: SwingShape,
    /// Whether the root rises as high as the legs allow, the hip of the swing leg above the other
    /// one, and descends again. Nearly straight legs need less space.
    pub raises_root: bool,
}

/// Trajectory of the swing sole between two poses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum SwingShape {
    /// A straight line.
    Straight,
    /// A straight line plus a curve along z and away from the other leg.
    Curved {
        /// Largest offset along z, m.
        rise: f64,
        /// Largest offset away from the other leg, along y of the root's heading halfway, m.
        aside: f64,
    },
    /// Up, across with a curve away from the other leg, and down.
    UpAndOver {
        /// Height above the higher end, m.
        height: f64,
        /// Largest offset away from the other leg, as above, m.
        aside: f64,
    },
    /// Out, across, and back: around the other leg if one foot is in front of the other.
    Around {
        /// Offset along z, m.
        rise: f64,
        /// Offset away from the other leg, as above, m.
        aside: f64,
    },
}

/// Shapes tried in single support, in this order: small motions first, then the shape that most
/// often succeeds where those before it fail.
pub const SWINGS: [MotionShape; 23] = [
    curved(0.02, 0.0),
    curved(0.06, 0.0),
    up_and_over(0.02, 0.0),
    curved(0.06, 0.08),
    with_raised_root(up_and_over(0.08, 0.0)),
    curved(0.14, 0.08),
    with_raised_root(up_and_over(0.02, 0.24)),
    with_raised_root(curved(0.14, 0.16)),
    curved(0.14, 0.16),
    up_and_over(0.08, 0.0),
    with_raised_root(up_and_over(0.1, 0.1)),
    around(0.3, 0.1),
    with_raised_root(around(0.15, 0.25)),
    with_raised_root(around(0.06, 0.15)),
    with_raised_root(around(0.02, 0.3)),
    around(0.02, 0.2),
    with_raised_root(curved(0.06, 0.08)),
    with_raised_root(curved(0.06, 0.0)),
    with_raised_root(curved(0.06, 0.16)),
    around(0.02, 0.1),
    curved(0.14, 0.0),
    up_and_over(0.2, 0.0),
    curved(0.3, 0.0),
];
/// Shapes tried in double support, where only the root moves.
pub const SHIFTS: [MotionShape; 2] =
    [MotionShape::STRAIGHT, with_raised_root(MotionShape::STRAIGHT)];

impl MotionShape {
    /// Straight in all coordinates.
    pub const STRAIGHT: Self = Self { swing: SwingShape::Straight, raises_root: false };
}

const fn curved(rise: f64, aside: f64) -> MotionShape {
    MotionShape { swing: SwingShape::Curved { rise, aside }, raises_root: false }
}

const fn up_and_over(height: f64, aside: f64) -> MotionShape {
    MotionShape { swing: SwingShape::UpAndOver { height, aside }, raises_root: false }
}

const fn around(rise: f64, aside: f64) -> MotionShape {
    MotionShape { swing: SwingShape::Around { rise, aside }, raises_root: false }
}

const fn with_raised_root(shape: MotionShape) -> MotionShape {
    MotionShape { raises_root: true, ..shape }
}

impl SwingShape {
    /// Approximate length in excess of the straight line, m.
    pub fn extra_length(&self) -> f64 {
        match *self {
            Self::Straight => 0.0,
            Self::Curved { rise, aside } | Self::Around { rise, aside } => 2.0 * (rise + aside),
            Self::UpAndOver { height, aside } => 2.0 * (height + aside),
        }
    }

    /// The sole pose at fraction `t`. `outward` gives the unit vector away from the other leg; it
    /// is called only by shapes with a lateral offset.
    pub fn pose(&self, [from, to]: [&Pose; 2], outward: impl FnOnce() -> DVec3, t: f64) -> Pose {
        match *self {
            Self::Straight => interpolate(from, to, t),
            Self::Curved { rise, aside } => {
                let mut pose = interpolate(from, to, t);
                pose.translation += plateau(t) * (DVec3::Z * rise + outward() * aside);
                pose
            }
            Self::UpAndOver { height, aside } => {
                up_and_over_pose(from, to, height, || outward() * aside, t)
            }
            Self::Around { rise, aside } => {
                around_pose(from, to, DVec3::Z * rise + outward() * aside, t)
            }
        }
    }
}

/// 1 - (2 t - 1)^4: 0 at both ends, 1 halfway and nearly 1 for most of the path.
pub fn plateau(t: f64) -> f64 {
    let side = 2.0 * t - 1.0;
    1.0 - side * side * side * side
}

/// Unit vector away from the other leg: along y of the root's heading halfway between two root
/// poses, world.
pub fn outward(world_from_roots: [&Pose; 2], limb: usize) -> DVec3 {
    let left = rotation_about(
        DVec3::Z,
        yaw_of(interpolate(world_from_roots[0], world_from_roots[1], 0.5).rotation),
    ) * DVec3::Y;
    side_of(limb) * left
}

/// Up, across with an offset, and down; `t` is proportional to the length.
fn up_and_over_pose(
    from: &Pose,
    to: &Pose,
    height: f64,
    offset: impl FnOnce() -> DVec3,
    t: f64,
) -> Pose {
    let top = from.translation.z.max(to.translation.z) + height;
    let (rise, fall) = (top - from.translation.z, top - to.translation.z);
    let across = (to.translation - from.translation).truncate().length();
    let along = t * (rise + across + fall);
    let share = ((along - rise) / across.max(1e-9)).clamp(0.0, 1.0);
    let mut pose = interpolate(from, to, share);
    pose.translation.z = if along < rise {
        from.translation.z + along
    } else {
        top - (along - rise - across).max(0.0)
    };
    pose.translation += plateau(share) * offset();
    pose
}

/// Out by an offset, across, and back; `t` is proportional to the length.
fn around_pose(from: &Pose, to: &Pose, offset: DVec3, t: f64) -> Pose {
    let (out, across) = (offset.length(), from.translation.distance(to.translation));
    let along = t * (2.0 * out + across);
    let share = ((along - out) / across.max(1e-9)).clamp(0.0, 1.0);
    let mut pose = interpolate(from, to, share);
    pose.translation +=
        offset * (along.min(2.0 * out + across - along) / out.max(1e-9)).clamp(0.0, 1.0);
    pose
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DQuat;

    fn ends() -> [Pose; 2] {
        [DVec3::new(0.0, 0.1, 0.0), DVec3::new(0.4, 0.1, 0.2)]
            .map(|at| Pose::from_parts(at, DQuat::IDENTITY))
    }

    #[test]
    fn every_shape_leads_from_end_to_end_without_a_jump() {
        let [from, to] = &ends();
        for shape in SWINGS.iter().chain(&SHIFTS) {
            let at = |t| shape.swing.pose([from, to], || DVec3::Y, t).translation;
            assert!(
                at(0.0).distance(from.translation) < 1e-9
                    && at(1.0).distance(to.translation) < 1e-9,
                "{shape:?}"
            );
            let length = from.translation.distance(to.translation) + shape.swing.extra_length();
            let jump = (0..200)
                .map(|step| at(f64::from(step) / 200.0).distance(at(f64::from(step + 1) / 200.0)))
                .fold(0.0, f64::max);
            assert!(jump < 5.0 * length / 200.0, "{shape:?} jumps by {jump} m");
        }
    }

    #[test]
    fn a_foot_moves_outward_before_it_moves_across() {
        let [from, to] = &ends();
        let swing = SwingShape::Around { rise: 0.0, aside: 0.2 };
        let at = |along: f64| {
            swing
                .pose(
                    [from, to],
                    || DVec3::Y,
                    along / (0.4 + from.translation.distance(to.translation)),
                )
                .translation
        };
        assert!(
            at(0.2).distance(from.translation + DVec3::Y * 0.2) < 1e-9,
            "outward, not yet across"
        );
    }
}
