//! The kinds of limits that bound the rates of a path.

use bytemuck::Zeroable;
use surefoot_shared_types::base::limits::{CHUNK_BINDINGS_MAX, JOINTS_MAX};
use surefoot_shared_types::message::{ChunkBinding, LimitKind};

/// A limit that bounds rates.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum Limit {
    /// The largest rate of the path's parameter.
    #[default]
    PathRate,
    /// The speed of a joint.
    Speed(u8),
    /// The acceleration of a joint.
    Acceleration(u8),
    /// The torque of a joint.
    Torque(u8),
    /// The centre of pressure inside the soles.
    CentreOfPressure,
    /// The zero-moment point inside the support.
    ZeroMoment,
    /// Friction.
    Friction,
    /// Contact forces and torques together.
    Contacts,
    /// The speed of a landing sole.
    Touchdown,
    /// The speed of a stance sole.
    StanceSole,
}

impl Limit {
    /// Number of limits without joints.
    const PLAIN: usize = 7;
    /// Number of limits.
    pub const COUNT: usize = Self::PLAIN + 3 * JOINTS_MAX;

    /// All limits, by their index.
    pub fn all() -> impl Iterator<Item = Self> {
        let plain = [
            Self::PathRate,
            Self::CentreOfPressure,
            Self::ZeroMoment,
            Self::Friction,
            Self::Contacts,
            Self::Touchdown,
            Self::StanceSole,
        ];
        let of_joints = [Self::Speed, Self::Acceleration, Self::Torque]
            .into_iter()
            .flat_map(|of| (0..JOINTS_MAX).map(move |joint| of(joint as u8)));
        plain.into_iter().chain(of_joints)
    }

    /// The place among all limits.
    pub fn index(self) -> usize {
        let of_joint = |kind: usize, joint: u8| Self::PLAIN + kind * JOINTS_MAX + joint as usize;
        match self {
            Self::PathRate => 0,
            Self::CentreOfPressure => 1,
            Self::ZeroMoment => 2,
            Self::Friction => 3,
            Self::Contacts => 4,
            Self::Touchdown => 5,
            Self::StanceSole => 6,
            Self::Speed(joint) => of_joint(0, joint),
            Self::Acceleration(joint) => of_joint(1, joint),
            Self::Torque(joint) => of_joint(2, joint),
        }
    }

    /// Its kind in messages.
    pub fn kind(self) -> LimitKind {
        match self {
            Self::PathRate => LimitKind::PathRate,
            Self::Speed(_) => LimitKind::Speed,
            Self::Acceleration(_) => LimitKind::Acceleration,
            Self::Torque(_) => LimitKind::Torque,
            Self::CentreOfPressure => LimitKind::CentreOfPressure,
            Self::ZeroMoment => LimitKind::ZeroMoment,
            Self::Friction => LimitKind::Friction,
            Self::Contacts => LimitKind::Contacts,
            Self::Touchdown => LimitKind::Touchdown,
            Self::StanceSole => LimitKind::StanceSole,
        }
    }

    /// Its name in reports.
    pub fn name(self) -> &'static str {
        self.kind().name()
    }

    /// The joint that it concerns.
    pub fn joint(self) -> Option<usize> {
        match self {
            Self::Speed(joint) | Self::Acceleration(joint) | Self::Torque(joint) => {
                Some(joint as usize)
            }
            _ => None,
        }
    }
}

/// How long each limit binds a timed motion.
#[derive(Debug, Clone, PartialEq)]
pub struct BindingTimes {
    /// By the index of the limit, s.
    seconds: [f64; Limit::COUNT],
    /// Time in which the rates are shrunk because the rounded motion, or a stop, was beyond a
    /// limit, s. It counts for the limit that binds, too.
    pub slowed: f64,
    /// Time in which no limit binds: at rests, and where the acceleration changes, s.
    pub free: f64,
}

impl Default for BindingTimes {
    fn default() -> Self {
        Self { seconds: [0.0; Limit::COUNT], slowed: 0.0, free: 0.0 }
    }
}

impl BindingTimes {
    /// A limit binds for some time (s); none, where no limit does.
    pub fn add(&mut self, limit: Option<Limit>, seconds: f64, is_slowed: bool) {
        match limit {
            Some(limit) => self.seconds[limit.index()] += seconds,
            None => self.free += seconds,
        }
        self.slowed += if is_slowed { seconds } else { 0.0 };
    }

    /// Adds other times.
    pub fn add_all(&mut self, other: &Self) {
        self.seconds.iter_mut().zip(&other.seconds).for_each(|(sum, seconds)| *sum += seconds);
        (self.slowed, self.free) = (self.slowed + other.slowed, self.free + other.free);
    }

    /// What a chunk states of them: the longest ones, also the time in which no limit binds.
    pub fn longest(&self) -> [ChunkBinding; CHUNK_BINDINGS_MAX] {
        let of_limit = |(limit, seconds): (Limit, f64)| {
            ChunkBinding::new(limit.kind(), limit.joint(), seconds)
        };
        let free = ChunkBinding::new(LimitKind::None, None, self.free);
        let mut longest = [ChunkBinding::zeroed(); CHUNK_BINDINGS_MAX];
        for entry in self.iter().map(of_limit).chain([free]) {
            let at = longest.partition_point(|other| other.seconds >= entry.seconds);
            if let Some(shorter @ [_, ..]) = longest.get_mut(at..) {
                shorter.rotate_right(1);
                shorter[0] = entry;
            }
        }
        longest
    }

    /// Every limit with the time for which it binds, s.
    pub fn iter(&self) -> impl Iterator<Item = (Limit, f64)> + '_ {
        Limit::all().map(|limit| (limit, self.seconds[limit.index()]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_limit_has_a_place_of_its_own() {
        let places: Vec<usize> = Limit::all().map(Limit::index).collect();
        assert_eq!(places, (0..Limit::COUNT).collect::<Vec<_>>());
    }

    #[test]
    fn times_accumulate() {
        let mut times = BindingTimes::default();
        times.add(Some(Limit::Torque(3)), 0.5, false);
        times.add(Some(Limit::Torque(3)), 0.25, true);
        times.add(None, 1.0, false);
        assert_eq!((times.slowed, times.free), (0.25, 1.0));
        let mut sum = times.clone();
        sum.add_all(&times);
        assert_eq!((sum.slowed, sum.free), (0.5, 2.0));
        let entries = [(LimitKind::None, None, 2.0), (LimitKind::Torque, Some(3), 1.5)];
        let longest = sum.longest();
        assert_eq!([longest[0], longest[1]].map(|entry| entry.known()), entries.map(Some));
        assert_eq!(longest[2].known(), None);
        let bound: Vec<_> = times.iter().filter(|(_, seconds)| *seconds > 0.0).collect();
        assert_eq!(bound, [(Limit::Torque(3), 0.75)]);
        assert_eq!((Limit::Torque(3).name(), Limit::Torque(3).joint()), ("torque", Some(3)));
    }
}
