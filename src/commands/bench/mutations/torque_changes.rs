//! Changes of the feed-forward torques.

use surefoot_shared_types::plan_format::blocks::WaypointBlock;

use super::subject::Subject;

/// The torques of a waypoint that are changed.
type Torques = fn(&mut WaypointBlock) -> &mut Vec<f64>;

/// A joint is fed more or less for a while, N m or N.
pub(super) fn torque(subject: &mut Subject, size: f64) -> bool {
    add(subject, size, |waypoint| &mut waypoint.torque)
}

/// A joint is fed more or less for a while where the robot rests, N m or N.
pub(super) fn rest_torque(subject: &mut Subject, size: f64) -> bool {
    add(subject, size, |waypoint| &mut waypoint.rest_torque)
}

/// A joint is fed more or less for a while where the robot brakes or goes on, N m s or N s.
pub(super) fn stop_torque(subject: &mut Subject, size: f64) -> bool {
    add(subject, size, |waypoint| &mut waypoint.rate_change_torque)
}

fn add(subject: &mut Subject, size: f64, of: Torques) -> bool {
    let (joint, size) = (subject.joint(), subject.signed(size));
    subject.bump(|waypoint, bump| {
        if let Some(torque) = of(waypoint).get_mut(joint) {
            *torque += size * bump.value;
        }
    });
    true
}

/// All joints are fed more, by this factor.
pub(super) fn all_torques(subject: &mut Subject, factor: f64) -> bool {
    let waypoints = &mut subject.plan.waypoints;
    let torques = waypoints.iter_mut().flat_map(|waypoint| &mut waypoint.torque);
    torques.map(|torque| *torque *= factor).count() > 0
}

/// The plan says that it is a walk as it was executed, and feeds all joints more by this factor, or
/// as much the other way.
pub(super) fn executed(subject: &mut Subject, factor: f64) -> bool {
    let factor = subject.signed(factor);
    subject.plan.executed = true;
    subject.plan.chunks.clear();
    all_torques(subject, factor)
}
