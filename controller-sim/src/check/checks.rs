//! The table of the physical checks: their order, and the margin that each measures.
//!
//! [`PhysicalCheck::of`] matches all variants of [`Check`], and all other matches are over
//! [`PhysicalCheck`] without a default, so a new check does not compile until the checker makes
//! it. The assertion below requires each physical check in [`PHYSICAL`], the list that the checker
//! runs.

use surefoot_shared_types::message::Check;

use crate::check::segment::SegmentReport;

/// A check on the motion; the other checks concern the message and its place in the stream.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum PhysicalCheck {
    Spacing,
    Acceleration,
    Limits,
    Contact,
    Balance,
    Torque,
    ZeroMoment,
    DynamicTorque,
    Collision,
    SelfCollision,
}

/// The physical checks, in the order in which they are made.
pub(crate) const PHYSICAL: [PhysicalCheck; 10] = [
    PhysicalCheck::Spacing,
    PhysicalCheck::Acceleration,
    PhysicalCheck::Limits,
    PhysicalCheck::Contact,
    PhysicalCheck::Balance,
    PhysicalCheck::Torque,
    PhysicalCheck::ZeroMoment,
    PhysicalCheck::DynamicTorque,
    PhysicalCheck::Collision,
    PhysicalCheck::SelfCollision,
];

impl PhysicalCheck {
    /// Those that look at the instants of a smooth motion.
    pub(crate) const OF_INSTANTS: [Self; 4] =
        [Self::Spacing, Self::Acceleration, Self::ZeroMoment, Self::DynamicTorque];

    /// The physical check of this name; nothing for checks of the message and of the stream.
    const fn of(check: Check) -> Option<Self> {
        match check {
            Check::Spacing => Some(Self::Spacing),
            Check::Acceleration => Some(Self::Acceleration),
            Check::Limits => Some(Self::Limits),
            Check::Contact => Some(Self::Contact),
            Check::Balance => Some(Self::Balance),
            Check::Torque => Some(Self::Torque),
            Check::ZeroMoment => Some(Self::ZeroMoment),
            Check::DynamicTorque => Some(Self::DynamicTorque),
            Check::Collision => Some(Self::Collision),
            Check::SelfCollision => Some(Self::SelfCollision),
            Check::Continuity
            | Check::Malformed
            | Check::Crc
            | Check::Stream
            | Check::Sequence
            | Check::Robot
            | Check::World
            | Check::Config
            | Check::Controller
            | Check::WorldDiffers
            | Check::FootMisplaced => None,
        }
    }

    /// Its name in messages and reports.
    pub(crate) const fn check(self) -> Check {
        match self {
            Self::Spacing => Check::Spacing,
            Self::Acceleration => Check::Acceleration,
            Self::Limits => Check::Limits,
            Self::Contact => Check::Contact,
            Self::Balance => Check::Balance,
            Self::Torque => Check::Torque,
            Self::ZeroMoment => Check::ZeroMoment,
            Self::DynamicTorque => Check::DynamicTorque,
            Self::Collision => Check::Collision,
            Self::SelfCollision => Check::SelfCollision,
        }
    }

    /// The margin of this check in a report; nothing where the check measures none.
    pub(crate) fn margin(self, report: &mut SegmentReport) -> Option<&mut f64> {
        let margins = &mut report.margins;
        match self {
            Self::Spacing => None,
            Self::Acceleration => Some(&mut report.acceleration),
            Self::Limits => Some(&mut margins.limits),
            Self::Contact => Some(&mut margins.contact),
            Self::Balance => Some(&mut margins.balance),
            Self::Torque => Some(&mut margins.torque),
            Self::ZeroMoment => Some(&mut margins.zero_moment),
            Self::DynamicTorque => Some(&mut margins.dynamic_torque),
            Self::Collision => Some(&mut margins.collision),
            Self::SelfCollision => Some(&mut margins.self_collision),
        }
    }
}

/// Whether a list holds each physical check once.
const fn is_complete(physical: &[PhysicalCheck]) -> bool {
    let mut index = 0;
    while index < Check::ALL.len() {
        let check = Check::ALL[index];
        let (mut count, mut place) = (0, 0);
        while place < physical.len() {
            count += (physical[place].check() as u32 == check as u32) as usize;
            place += 1;
        }
        if count != PhysicalCheck::of(check).is_some() as usize {
            return false;
        }
        index += 1;
    }
    true
}

const _: () = assert!(is_complete(&PHYSICAL), "PHYSICAL must hold each physical check once");

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_list_that_lacks_a_check_or_holds_one_twice_is_not_complete() {
        assert!(is_complete(&PHYSICAL));
        for place in 0..PHYSICAL.len() {
            let mut list = PHYSICAL.to_vec();
            list.remove(place);
            assert!(!is_complete(&list), "{place}");
            list.push(PHYSICAL[(place + 1) % PHYSICAL.len()]);
            assert!(!is_complete(&list), "{place}");
            list.extend([PHYSICAL[place]; 2]);
            assert!(!is_complete(&list), "{place}");
        }
    }
}
