//! Changes of what the plan says about its feet.

use surefoot_shared_types::base::spatial::rotation_about;

use super::subject::{Subject, push, turn};

/// A foothold is declared elsewhere, m.
pub(super) fn move_contact(subject: &mut Subject, size: f64) -> bool {
    let (contact, way) = (subject.contact(), size * subject.direction());
    subject.same(&contact).for_each(|same| push(&mut same.sole_pose.xyz, way));
    true
}

/// A foothold is declared turned, rad.
pub(super) fn turn_contact(subject: &mut Subject, size: f64) -> bool {
    let (contact, rotation) = (subject.contact(), rotation_about(subject.direction(), size));
    subject.same(&contact).for_each(|same| turn(&mut same.sole_pose.quat_xyzw, rotation));
    true
}

/// A phase ends so many waypoints earlier or later.
pub(super) fn move_phase(subject: &mut Subject, size: f64) -> bool {
    let count = subject.plan.phases.len();
    if count < 2 {
        return false;
    }
    let phase = subject.random.below(count - 1);
    let by = subject.signed(size.round().max(1.0)) as isize;
    let (first, end) = (subject.plan.phases[phase].first, subject.plan.phases[phase].last);
    let last = subject.plan.phases[phase + 1].last;
    let moved = end.saturating_add_signed(by).clamp(first, last);
    subject.plan.phases[phase].last = moved;
    subject.plan.phases[phase + 1].first = moved;
    moved != end
}

/// The soles are declared larger by this factor.
pub(super) fn larger_soles(subject: &mut Subject, factor: f64) -> bool {
    let corners = subject.plan.robot.feet.values_mut().flat_map(|foot| &mut foot.polygon);
    corners.for_each(|corner| *corner = corner.map(|number| factor * number));
    true
}
