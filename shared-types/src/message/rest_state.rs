//! Rest states: configurations in which the robot may stop.

use bytemuck::{Pod, Zeroable};
use iceoryx2::prelude::ZeroCopySend;

use crate::base::limits::{CONTACTS_MAX, POLYGON_VERTICES_MAX};
use crate::base::spatial::{wrap_angle, yaw_of};
use crate::config::scenario::StancePose;
use crate::message::chunk::{Contact, SupportMode, Waypoint, is_rotation};
use crate::message::layout::layout;

/// A statically stable configuration with its contacts.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable, ZeroCopySend)]
#[repr(C)]
#[type_name("surefoot.RestState.v1")]
pub struct RestState {
    /// A [`SupportMode`] as its wire value.
    pub mode: u32,
    /// Number of used entries of `contacts`: one for each limb that has been in contact. 0 if the
    /// rest state is unknown.
    pub contacts_len: u32,
    /// The configuration and the time of the plan at which it was reached.
    pub waypoint: Waypoint,
    /// The contact of each limb; of a lifted limb, its last contact.
    pub contacts: [Contact; CONTACTS_MAX],
}

const _: () = assert!(
    size_of::<RestState>() == 8 + size_of::<Waypoint>() + CONTACTS_MAX * size_of::<Contact>()
);

layout!(RestState {
    mode: u32,
    contacts_len: u32,
    waypoint: Waypoint,
    contacts: [Contact; CONTACTS_MAX],
} with [Waypoint, Contact]);

impl RestState {
    /// Whether the rest state is known.
    pub fn is_known(&self) -> bool {
        self.contacts_len > 0
    }

    /// The used entries of `contacts`.
    pub fn contacts(&self) -> &[Contact] {
        &self.contacts[..(self.contacts_len as usize).min(CONTACTS_MAX)]
    }

    /// The contact or last contact of a limb, if it has one.
    pub fn contact_of(&self, limb: u32) -> Option<&Contact> {
        self.contacts().iter().find(|contact| contact.limb == limb)
    }

    /// The stance of limbs 0 and 1 at their contacts or last contacts, if both have one.
    pub fn stance_pose(&self) -> Option<StancePose> {
        let [left, right] = [0, 1].map(|limb| self.contact_of(limb).map(Contact::world_from_sole));
        let (left, right) = (left?, right?);
        let yaw = yaw_of(left.rotation);
        let turn = wrap_angle(yaw_of(right.rotation) - yaw);
        let stance_width = left.translation.distance(right.translation);
        Some(StancePose {
            position: left.translation.midpoint(right.translation),
            yaw: wrap_angle(yaw + 0.5 * turn),
            stance_width,
        })
    }

    /// The rest state after a chunk that was executed from this one. `mode` and `contacts` are the
    /// chunk's, `waypoint` is its last one. Lifted limbs keep their last contact.
    pub fn after(&self, mode: u32, contacts: &[Contact], waypoint: &Waypoint) -> Self {
        let mut next = Self { mode, waypoint: waypoint.rested(), ..*self };
        for contact in contacts {
            let known = next.contacts().iter().position(|old| old.limb == contact.limb);
            let index = known.unwrap_or(next.contacts_len as usize);
            if index < CONTACTS_MAX {
                next.contacts[index] = *contact;
                next.contacts_len = next.contacts_len.max(index as u32 + 1);
            }
        }
        next
    }

    /// Whether counts, mode, limbs and rotations are valid and all numbers are finite.
    pub fn is_well_formed(&self) -> bool {
        let numbers = self
            .waypoint
            .root_position
            .iter()
            .chain(&self.waypoint.root_rotation)
            .chain(&self.waypoint.q);
        self.contacts_len as usize <= CONTACTS_MAX
            && SupportMode::from_wire(self.mode).is_some()
            && self.waypoint.time.is_finite()
            && numbers.into_iter().all(|x| x.is_finite())
            && self.waypoint.rates().all(f64::is_finite)
            && (!self.is_known() || is_rotation(self.waypoint.root_rotation))
            && self.contacts().iter().all(|contact| self.is_well_formed_contact(contact))
    }

    fn is_well_formed_contact(&self, contact: &Contact) -> bool {
        let same_limb = self.contacts().iter().filter(|other| other.limb == contact.limb).count();
        SupportMode::Double.carries(contact.limb as usize)
            && same_limb == 1
            && contact.polygon_len as usize <= POLYGON_VERTICES_MAX
            && is_rotation(contact.rotation)
            && contact.position.iter().chain(contact.polygon.as_flattened()).all(|x| x.is_finite())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const UPRIGHT: [f64; 4] = [0.0, 0.0, 0.0, 1.0];

    fn contact(limb: u32, x: f64) -> Contact {
        Contact { limb, position: [x, 0.0, 0.0], rotation: UPRIGHT, ..Contact::zeroed() }
    }

    fn at(time: f64) -> Waypoint {
        Waypoint { time, root_rotation: UPRIGHT, ..Waypoint::zeroed() }
    }

    #[test]
    fn a_lifted_foot_keeps_its_last_contact() {
        let rest_state = RestState::zeroed();
        assert!(!rest_state.is_known());
        let both = rest_state.after(
            SupportMode::Double as u32,
            &[contact(0, 0.1), contact(1, 0.2)],
            &at(0.0),
        );
        let lifted = both.after(SupportMode::Left as u32, &[contact(0, 0.1)], &at(2.0));
        assert_eq!(
            (lifted.mode, lifted.contacts_len, lifted.waypoint.time),
            (SupportMode::Left as u32, 2, 2.0)
        );
        assert_eq!(lifted.contact_of(1).unwrap().position[0], 0.2);
        let landed =
            lifted.after(SupportMode::Double as u32, &[contact(0, 0.1), contact(1, 0.5)], &at(0.0));
        assert_eq!((landed.contacts_len, landed.contact_of(1).unwrap().position[0]), (2, 0.5));
        assert!(landed.is_well_formed() && landed.contact_of(2).is_none());
    }

    #[test]
    fn unknown_limbs_and_invalid_rotations_are_malformed() {
        let good = RestState::zeroed().after(
            SupportMode::Double as u32,
            &[contact(0, 0.1), contact(1, 0.2)],
            &at(1.0),
        );
        assert!(good.is_well_formed() && RestState::zeroed().is_well_formed());
        let with = |second: Contact| RestState {
            contacts: [good.contacts[0], second, good.contacts[2], good.contacts[3]],
            ..good
        };
        let bad = [
            with(contact(2, 0.2)),
            with(contact(u32::MAX, 0.2)),
            with(contact(0, 0.2)),
            with(Contact { rotation: [0.0; 4], ..contact(1, 0.2) }),
            with(Contact { rotation: [0.0, 0.0, f64::NAN, 1.0], ..contact(1, 0.2) }),
            with(Contact { rotation: [0.0, 0.1, 0.0, 1.0], ..contact(1, 0.2) }),
            with(Contact { polygon_len: POLYGON_VERTICES_MAX as u32 + 1, ..contact(1, 0.2) }),
            RestState { waypoint: Waypoint { root_rotation: [0.0; 4], ..good.waypoint }, ..good },
        ];
        assert!(bad.iter().all(|rest_state| !rest_state.is_well_formed()));
    }
}
