//! Changes of where the robot goes.

use surefoot_shared_types::base::spatial::rotation_about;

use super::subject::{Subject, add_rates, freedom_of, push, turn};

/// A joint bends and goes back, rad.
pub(super) fn bend(subject: &mut Subject, size: f64) -> bool {
    let (joint, size) = (subject.joint(), subject.signed(size));
    subject.bump(|waypoint, bump| {
        waypoint.q[joint] += size * bump.value;
        add_rates(waypoint, freedom_of(joint), bump, size);
    });
    true
}

/// A joint is off by the same angle everywhere, rad.
pub(super) fn offset(subject: &mut Subject, size: f64) -> bool {
    let (joint, size) = (subject.joint(), subject.signed(size));
    subject.plan.waypoints.iter_mut().for_each(|waypoint| waypoint.q[joint] += size);
    true
}

/// The root sways and comes back, m.
pub(super) fn sway(subject: &mut Subject, size: f64) -> bool {
    let way = size * subject.direction();
    subject.bump(|waypoint, bump| {
        push(&mut waypoint.root_xyz, bump.value * way);
        (0..3).for_each(|axis| add_rates(waypoint, axis, bump, way[axis]));
    });
    true
}

/// The root leans and comes back, rad.
pub(super) fn lean(subject: &mut Subject, size: f64) -> bool {
    let axis = subject.direction();
    subject.bump(|waypoint, bump| {
        turn(&mut waypoint.root_quat_xyzw, rotation_about(axis, size * bump.value));
        (0..3).for_each(|at| add_rates(waypoint, 3 + at, bump, size * axis[at]));
    });
    true
}

/// A joint is off at one waypoint, rad.
pub(super) fn twitch(subject: &mut Subject, size: f64) -> bool {
    let (joint, size, at) = (subject.joint(), subject.signed(size), subject.waypoint());
    subject.plan.waypoints[at].q[joint] += size;
    true
}

/// The whole walk is elsewhere in the world, m.
pub(super) fn shift(subject: &mut Subject, size: f64) -> bool {
    let way = size * subject.direction();
    subject.plan.waypoints.iter_mut().for_each(|waypoint| push(&mut waypoint.root_xyz, way));
    let contacts = subject.plan.phases.iter_mut().flat_map(|phase| &mut phase.contacts);
    contacts.for_each(|contact| push(&mut contact.sole_pose.xyz, way));
    true
}

/// Waypoints of a phase are left out, so many.
pub(super) fn leave_out(subject: &mut Subject, size: f64) -> bool {
    let phase = subject.random.below(subject.plan.phases.len());
    let (first, last) = (subject.plan.phases[phase].first, subject.plan.phases[phase].last);
    let inner = last.saturating_sub(first + 1);
    let count = (size.round() as usize).min(inner);
    if count == 0 {
        return false;
    }
    let begin = first + 1 + subject.random.below(inner - count + 1);
    subject.plan.waypoints.drain(begin..begin + count);
    let moved = |at: usize| if at < begin { at } else { at.max(begin + count) - count };
    for phase in &mut subject.plan.phases {
        (phase.first, phase.last) = (moved(phase.first), moved(phase.last));
    }
    for chunk in &mut subject.plan.chunks {
        (chunk.first, chunk.last) = (moved(chunk.first), moved(chunk.last));
    }
    true
}
