//! Legal changes of mode: one foot at a time, and the foot that stays does not move.

use surefoot_shared_types::base::spatial::rotation_distance;
use surefoot_shared_types::message::{Contact, SupportMode};
use surefoot_shared_types::robot::model::FOOT_NAMES;

use crate::base::comparison::is_at_most;

/// How far a kept foot's declared pose may differ between two modes, m; a turn counts as
/// [`METRES_PER_RADIAN`].
const KEPT_POSE_MAX: f64 = 1e-6;
/// Length as which a turn of a foot counts, m by rad: about half of a sole.
const METRES_PER_RADIAN: f64 = 0.1;

/// A mode with its contacts.
#[derive(Debug, Clone, Copy)]
pub struct Stance<'a> {
    /// The feet that carry the robot.
    pub mode: SupportMode,
    /// Their contacts.
    pub contacts: &'a [Contact],
}

/// The limbs that stand in a mode of a biped.
pub fn stance_limbs(mode: SupportMode) -> &'static [u32] {
    match mode {
        SupportMode::Left => &[0],
        SupportMode::Right => &[1],
        SupportMode::Double => &[0, 1],
    }
}

/// Whether the contacts are those of the mode, each once.
pub fn contacts_match(stance: &Stance) -> bool {
    let mut limbs: Vec<u32> = stance.contacts.iter().map(|contact| contact.limb).collect();
    limbs.sort_unstable();
    limbs == stance_limbs(stance.mode)
}

/// Whether a robot may change from one stance to the next at an instant.
///
/// # Errors
/// The reason for which it may not.
pub fn check_transition(before: &Stance, after: &Stance) -> Result<(), String> {
    let both_single = before.mode != SupportMode::Double && after.mode != SupportMode::Double;
    if both_single && before.mode != after.mode {
        return Err(format!(
            "from {} to {} support without both feet on the ground between",
            before.mode.name(),
            after.mode.name()
        ));
    }
    for old in before.contacts {
        for new in after.contacts.iter().filter(|new| new.limb == old.limb) {
            let moved = pose_difference(old, new);
            if !is_at_most(moved, KEPT_POSE_MAX) {
                return Err(format!(
                    "the {} foot is declared {:.6} mm from where it stood before",
                    FOOT_NAMES.get(old.limb as usize).copied().unwrap_or("unknown"),
                    1e3 * moved
                ));
            }
        }
    }
    Ok(())
}

/// How far two contacts are apart, m, turns included.
fn pose_difference(a: &Contact, b: &Contact) -> f64 {
    let (a, b) = (a.world_from_sole(), b.world_from_sole());
    a.translation.distance(b.translation)
        + METRES_PER_RADIAN * rotation_distance(a.rotation.normalize(), b.rotation.normalize())
}

#[cfg(test)]
mod tests {
    use glam::{DQuat, DVec3};

    use super::*;
    use crate::check_robot::contact;

    #[test]
    fn a_foot_that_stays_keeps_its_place_and_its_heading() {
        let stays = |moved: f64, turned: f64| {
            let (old, mut new) = ([contact(0)], [contact(0)]);
            new[0].position = (DVec3::from(old[0].position) + moved * DVec3::X).to_array();
            new[0].rotation = DQuat::from_rotation_z(turned).to_array();
            let stance = |contacts| Stance { mode: SupportMode::Left, contacts };
            check_transition(&stance(&old), &stance(&new)).is_ok()
        };
        assert!(stays(0.9e-6, 0.0) && !stays(1.1e-6, 0.0));
        // A turn of 10 urad moves the ends of a sole by 1 um.
        for turn in [9e-6, -9e-6] {
            assert!(stays(0.0, turn) && !stays(0.0, 1.3 * turn), "{turn}");
            assert!(!stays(0.2e-6, turn), "{turn}");
        }
    }
}
