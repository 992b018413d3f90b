//! The motion of a chunk with misplaced feet: the root moves as planned, and the legs' joints are
//! solved for the actual soles.

use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::interpolate;
use surefoot_shared_types::message::{PlanChunk, Waypoint};

use crate::check::checker::Checker;
use crate::check::course::{PlanRate, is_resting};
use crate::execution::tuning::DIFFERENCE_SECONDS;
use crate::kinematics::forward::{Configuration, Posture};
use crate::kinematics::leg_ik::solve_leg_ik;
use crate::kinematics::trajectory;

/// A foot that stands, or stood, beside its planned place.
struct MisplacedFoot {
    limb: usize,
    planned_from_actual: Pose,
    /// Where it stands; nothing if it is lifted.
    world_from_stance_sole: Option<Pose>,
}

/// The chunk with its actual feet, each given in its planned sole frame. A lifted foot returns to
/// its planned path within the chunk.
///
/// # Errors
/// A leg does not reach its sole; one line says which.
pub(crate) fn actual_chunk(
    checker: &Checker,
    chunk: &PlanChunk,
    feet: &[Pose; 2],
) -> Result<PlanChunk, String> {
    let mut actual = *chunk;
    for limb in (0..2).filter(|&limb| feet[limb] != Pose::IDENTITY) {
        let planned_from_actual = feet[limb];
        let contacts = &mut actual.contacts[..chunk.contacts_len as usize];
        let contact = contacts.iter_mut().find(|contact| contact.limb as usize == limb);
        let world_from_stance_sole = contact.map(|contact| {
            let pose = contact.world_from_sole() * planned_from_actual;
            contact.position = pose.translation.to_array();
            contact.rotation = pose.rotation.normalize().to_array();
            contact.world_from_sole()
        });
        let foot = MisplacedFoot { limb, planned_from_actual, world_from_stance_sole };
        let planned = actual;
        for (index, waypoint) in
            actual.waypoints[..chunk.waypoints_len as usize].iter_mut().enumerate()
        {
            *waypoint = foot.actual_waypoint(checker, &planned, index)?;
        }
    }
    Ok(actual)
}

/// The time of a chunk's last waypoint, s.
pub(crate) fn end_time(chunk: &PlanChunk) -> f64 {
    chunk.waypoints().last().map_or(0.0, |waypoint| waypoint.time)
}

/// Whether a limb is in contact during a chunk.
pub(crate) fn is_in_contact(chunk: &PlanChunk, limb: usize) -> bool {
    chunk.contacts().iter().any(|contact| contact.limb as usize == limb)
}

impl MisplacedFoot {
    /// A waypoint with this foot; of a smooth chunk with the velocity and acceleration of its leg,
    /// by differences.
    fn actual_waypoint(
        &self,
        checker: &Checker,
        planned: &PlanChunk,
        index: usize,
    ) -> Result<Waypoint, String> {
        let waypoints = planned.waypoints();
        let here = self.moved(checker, planned, &waypoints[index])?;
        if !planned.is_smooth() || waypoints.len() < 2 {
            return Ok(here);
        }
        let beside = |first: usize, seconds: f64| {
            let [from, to] = [&waypoints[first], &waypoints[first + 1]];
            let instant = trajectory::between(from, to, waypoints[index].time + seconds);
            self.moved(checker, planned, &instant)
        };
        let (h, rests) = (DIFFERENCE_SECONDS, is_resting(&waypoints[index]));
        let before = beside(index.saturating_sub(1), -h)?;
        let after = beside(index.min(waypoints.len() - 2), h)?;
        let mut actual = here;
        for &joint in &checker.model().leg(self.limb) {
            let [a, b, c] = [&before, &here, &after].map(|waypoint| waypoint.q[joint]);
            // Where the plan rests, the leg does; differences leave a little.
            let velocity = if rests { 0.0 } else { (c - a) / (2.0 * h) };
            actual.joint_velocity[joint] = velocity;
            actual.joint_acceleration[joint] = (c - 2.0 * b + a) / (h * h);
        }
        Ok(actual)
    }

    /// A configuration of the chunk with this foot.
    fn moved(
        &self,
        checker: &Checker,
        planned: &PlanChunk,
        waypoint: &Waypoint,
    ) -> Result<Waypoint, String> {
        let (model, limb) = (checker.model(), self.limb);
        let mut configuration = Configuration::of_waypoint(waypoint, model.joints.len());
        let target = self.world_from_stance_sole.unwrap_or_else(|| {
            let world_from_planned =
                Posture::new(model, &configuration).world_from_sole(model, limb);
            let remaining = remaining(planned, waypoint.time);
            world_from_planned * interpolate(&Pose::IDENTITY, &self.planned_from_actual, remaining)
        });
        if !solve_leg_ik(model, &mut configuration, limb, &target) {
            return Err(format!("the leg of foot {limb} does not reach its actual pose"));
        }
        let mut moved = *waypoint;
        moved.q.iter_mut().zip(configuration.q).for_each(|(slot, position)| *slot = position);
        Ok(moved)
    }
}

/// The share of its displacement that a lifted foot still has at a time (s) of a chunk: from 1 to
/// 0, with zero velocity at both ends; in smooth motion also with zero acceleration.
fn remaining(chunk: &PlanChunk, time: f64) -> f64 {
    let (begin, end) = (chunk.waypoints[0].time, end_time(chunk));
    let share = if end > begin { ((time - begin) / (end - begin)).clamp(0.0, 1.0) } else { 0.0 };
    if chunk.is_smooth() {
        PlanRate::of_ramp(share, 1.0, true).rate
    } else {
        1.0 - share * share * (3.0 - 2.0 * share)
    }
}
