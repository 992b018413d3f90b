//! Changes of how fast the robot goes.

use surefoot_shared_types::plan_format::blocks::PlanFile;

use super::subject::{Subject, freedom_of};

/// The whole walk is faster by this factor.
pub(super) fn hurry(subject: &mut Subject, factor: f64) -> bool {
    let end = subject.plan.waypoints.len() - 1;
    compress(&mut subject.plan, [0, end], factor);
    true
}

/// A phase is faster by this factor.
pub(super) fn hurry_phase(subject: &mut Subject, factor: f64) -> bool {
    let phase = subject.random.below(subject.plan.phases.len());
    let (first, last) = (subject.plan.phases[phase].first, subject.plan.phases[phase].last);
    compress(&mut subject.plan, [first, last], factor);
    first < last
}

/// Divides the time between two waypoints, and that of the stops in it.
fn compress(plan: &mut PlanFile, [first, last]: [usize; 2], factor: f64) {
    let (begin, end) = (plan.waypoints[first].t, plan.waypoints[last].t);
    let sooner = |time: f64| {
        let within = (time - begin).clamp(0.0, end - begin);
        time - within * (1.0 - 1.0 / factor)
    };
    for chunk in &mut plan.chunks {
        let rest = sooner(chunk.brake_at + 0.5 * chunk.brake_duration);
        chunk.brake_at = sooner(chunk.brake_at);
        chunk.brake_duration = 2.0 * (rest - chunk.brake_at).max(0.0);
    }
    for (index, waypoint) in plan.waypoints.iter_mut().enumerate() {
        waypoint.t = sooner(waypoint.t);
        if (first..=last).contains(&index) {
            waypoint.velocity.iter_mut().for_each(|speed| *speed *= factor);
            waypoint.acceleration.iter_mut().for_each(|change| *change *= factor * factor);
        }
    }
}

/// A stated joint velocity is off, rad/s.
pub(super) fn velocity(subject: &mut Subject, size: f64) -> bool {
    let (joint, size, at) = (subject.joint(), subject.signed(size), subject.waypoint());
    let slot = subject.plan.waypoints[at].velocity.get_mut(freedom_of(joint));
    slot.map(|speed| *speed += size).is_some()
}

/// A stated joint acceleration is off, rad/s2.
pub(super) fn acceleration(subject: &mut Subject, size: f64) -> bool {
    let (joint, size, at) = (subject.joint(), subject.signed(size), subject.waypoint());
    let slot = subject.plan.waypoints[at].acceleration.get_mut(freedom_of(joint));
    slot.map(|acceleration| *acceleration += size).is_some()
}

/// A chunk's stop is faster by this factor, with the rest at the same instant.
pub(super) fn brake(subject: &mut Subject, factor: f64) -> bool {
    let braking: Vec<usize> = (0..subject.plan.chunks.len())
        .filter(|&chunk| subject.plan.chunks[chunk].brake_duration > 0.0)
        .collect();
    if braking.is_empty() {
        return false;
    }
    let chunk = &mut subject.plan.chunks[braking[subject.random.below(braking.len())]];
    let shorter = chunk.brake_duration / factor;
    chunk.brake_at += 0.5 * (chunk.brake_duration - shorter);
    (chunk.brake_duration, chunk.resume_duration) = (shorter, chunk.resume_duration / factor);
    true
}
