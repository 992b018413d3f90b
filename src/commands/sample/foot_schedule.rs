//! The contacts of the feet at a chunk, and when they change.

use std::collections::VecDeque;

use bytemuck::Zeroable;
use surefoot_shared_types::base::limits::CONTACTS_MAX;
use surefoot_shared_types::message::set_point::FootSchedule;
use surefoot_shared_types::message::{PlanChunk, SupportMode};

/// The schedule of all feet while `chunk` is played, from the accepted `chunks` of its plan.
pub(crate) fn schedule(
    chunk: &PlanChunk,
    chunks: &VecDeque<PlanChunk>,
) -> [FootSchedule; CONTACTS_MAX] {
    let later = || chunks.iter().filter(|other| other.sequence > chunk.sequence);
    let mut feet = [FootSchedule::zeroed(); CONTACTS_MAX];
    for (limb, foot) in feet.iter_mut().take(2).enumerate() {
        let carries = carries(chunk, limb);
        let change = later().find(|other| self::carries(other, limb) != carries);
        let changes_at = change.and_then(|other| other.waypoints().first());
        (foot.in_contact, foot.changes_at) =
            (u64::from(carries), changes_at.map_or(-1.0, |first| first.time));
        let stance = if carries { Some(chunk) } else { change };
        let contact = stance.and_then(|chunk| {
            chunk.contacts().iter().find(|contact| contact.limb as usize == limb)
        });
        if let Some(contact) = contact {
            (foot.has_pose, foot.position, foot.rotation) = (1, contact.position, contact.rotation);
        }
    }
    feet
}

fn carries(chunk: &PlanChunk, limb: usize) -> bool {
    SupportMode::from_wire(chunk.mode).is_some_and(|mode| mode.carries(limb))
}
