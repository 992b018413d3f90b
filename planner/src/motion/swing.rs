//! How a robot travels between two states of a mode: the way of its swing sole, and whether it
//! stands up meanwhile. These are the parametrised primitive trajectories that a single-mode search
//! begins with [Grey 4.4.5].

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::spatial::{interpolate, rotation_about, yaw_of};

use crate::motion::primitive::stand::side_of;

/// The way between two states.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Travel {
    /// The way of the swing sole.
    pub path: Path,
    /// Whether the root rises as high as the legs allow, its hip over the swing foot above the
    /// other, and sinks again: legs that are all but straight need less room.
    pub stands_up: bool,
}

/// How the swing sole travels between two poses.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Path {
    /// Straight.
    Straight,
    /// Straight plus a hump, m: along z, and away from the other leg.
    Hump {
        /// Along z.
        rise: f64,
        /// Away from the other leg, along y of the root's heading halfway.
        aside: f64,
    },
    /// Up, across with a hump away from the other leg, and down, m.
    Over {
        /// Above the higher end.
        height: f64,
        /// Away from the other leg, as above.
        aside: f64,
    },
    /// Out, across, and back, m: around the other leg where the feet stand one before the other.
    Around {
        /// Along z.
        rise: f64,
        /// Away from the other leg, as above.
        aside: f64,
    },
}

/// What is tried with one foot in the air, in this order: the humble first, then whatever succeeded
/// most often where those before it did not.
pub const SWINGS: [Travel; 23] = [
    hump(0.02, 0.0),
    hump(0.06, 0.0),
    over(0.02, 0.0),
    hump(0.06, 0.08),
    standing_up(over(0.08, 0.0)),
    hump(0.14, 0.08),
    standing_up(over(0.02, 0.24)),
    standing_up(hump(0.14, 0.16)),
    hump(0.14, 0.16),
    over(0.08, 0.0),
    standing_up(over(0.1, 0.1)),
    around(0.3, 0.1),
    standing_up(around(0.15, 0.25)),
    standing_up(around(0.06, 0.15)),
    standing_up(around(0.02, 0.3)),
    around(0.02, 0.2),
    standing_up(hump(0.06, 0.08)),
    standing_up(hump(0.06, 0.0)),
    standing_up(hump(0.06, 0.16)),
    around(0.02, 0.1),
    hump(0.14, 0.0),
    over(0.2, 0.0),
    hump(0.3, 0.0),
];
/// With both feet on the ground only the root travels.
pub const SHIFTS: [Travel; 2] = [Travel::STRAIGHT, standing_up(Travel::STRAIGHT)];

impl Travel {
    /// Straight in all coordinates.
    pub const STRAIGHT: Self = Self { path: Path::Straight, stands_up: false };
}

const fn hump(rise: f64, aside: f64) -> Travel {
    Travel { path: Path::Hump { rise, aside }, stands_up: false }
}

const fn over(height: f64, aside: f64) -> Travel {
    Travel { path: Path::Over { height, aside }, stands_up: false }
}

const fn around(rise: f64, aside: f64) -> Travel {
    Travel { path: Path::Around { rise, aside }, stands_up: false }
}

const fn standing_up(travel: Travel) -> Travel {
    Travel { stands_up: true, ..travel }
}

impl Path {
    /// How much longer it is than the straight way, m; about.
    pub fn detour(&self) -> f64 {
        match *self {
            Self::Straight => 0.0,
            Self::Hump { rise, aside } | Self::Around { rise, aside } => 2.0 * (rise + aside),
            Self::Over { height, aside } => 2.0 * (height + aside),
        }
    }

    /// The sole a share `t` of the way. `outward` leads away from the other leg, and is asked for
    /// where the way leads aside.
    pub fn pose(&self, [from, to]: [&Pose; 2], outward: impl FnOnce() -> DVec3, t: f64) -> Pose {
        match *self {
            Self::Straight => interpolate(from, to, t),
            Self::Hump { rise, aside } => {
                let mut pose = interpolate(from, to, t);
                pose.translation += plateau(t) * (DVec3::Z * rise + outward() * aside);
                pose
            }
            Self::Over { height, aside } => over_pose(from, to, height, || outward() * aside, t),
            Self::Around { rise, aside } => {
                around_pose(from, to, DVec3::Z * rise + outward() * aside, t)
            }
        }
    }
}

/// 0 at both ends of a way, 1 halfway, and nearly so for most of it.
pub fn plateau(t: f64) -> f64 {
    let side = 2.0 * t - 1.0;
    1.0 - side * side * side * side
}

/// Away from the other leg: along y of the root's heading halfway.
pub fn outward(world_from_roots: [&Pose; 2], limb: usize) -> DVec3 {
    let left = rotation_about(
        DVec3::Z,
        yaw_of(interpolate(world_from_roots[0], world_from_roots[1], 0.5).rotation),
    ) * DVec3::Y;
    side_of(limb) * left
}

/// Up, across by way of an offset, down, each in proportion to its length.
fn over_pose(from: &Pose, to: &Pose, height: f64, offset: impl FnOnce() -> DVec3, t: f64) -> Pose {
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

/// Out by an offset, across, and back, each in proportion to its length.
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
    fn every_path_leads_from_one_end_to_the_other_without_a_leap() {
        let [from, to] = &ends();
        for travel in SWINGS.iter().chain(&SHIFTS) {
            let at = |t| travel.path.pose([from, to], || DVec3::Y, t).translation;
            assert!(
                at(0.0).distance(from.translation) < 1e-9
                    && at(1.0).distance(to.translation) < 1e-9,
                "{travel:?}"
            );
            let length = from.translation.distance(to.translation) + travel.path.detour();
            let leap = (0..200)
                .map(|step| at(f64::from(step) / 200.0).distance(at(f64::from(step + 1) / 200.0)))
                .fold(0.0, f64::max);
            assert!(leap < 5.0 * length / 200.0, "{travel:?} leaps by {leap} m");
        }
    }

    #[test]
    fn a_foot_goes_out_before_it_goes_across() {
        let [from, to] = &ends();
        let path = Path::Around { rise: 0.0, aside: 0.2 };
        let at = |along: f64| {
            path.pose(
                [from, to],
                || DVec3::Y,
                along / (0.4 + from.translation.distance(to.translation)),
            )
            .translation
        };
        assert!(
            at(0.2).distance(from.translation + DVec3::Y * 0.2) < 1e-9,
            "out to the side, not yet across"
        );
    }
}
