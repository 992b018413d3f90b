//! Checks a finished plan once more with the planner's own conditions: every waypoint, and every
//! motion between two. Nobody who hands out a checked plan can be faster than this; benches measure
//! the search against it.

use surefoot_shared_types::Pose;
use surefoot_shared_types::message::{Contact, PlanChunk, SupportMode, Waypoint};

use crate::body::Configuration;
use crate::collision::FootState;
use crate::constraint::{Constraints, Mode, Rejection};
use crate::motion::foothold::{Foothold, double_mode, single_mode};
use crate::snapshot::Snapshot;

/// What a check of a whole plan looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Recheck {
    /// Waypoints checked; those that two chunks share count twice.
    pub waypoints: u64,
    /// Configurations checked between waypoints.
    pub between: u64,
}

/// A waypoint that does not hold.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Fault {
    /// The chunk.
    pub chunk: usize,
    /// The waypoint in it, or the one at the end of the motion that does not hold.
    pub waypoint: usize,
    /// Why; nothing where the chunk's contacts are not those of its mode.
    pub rejection: Option<Rejection>,
}

/// Checks a plan's chunks.
///
/// A swing foot that lacks the full clearance is checked as one that lifts off or lands: chunks do
/// not say which it does.
///
/// # Errors
/// The first waypoint that does not hold.
pub fn recheck(constraints: &Constraints, chunks: &[PlanChunk]) -> Result<Recheck, Fault> {
    let mut done = Recheck::default();
    for (index, chunk) in chunks.iter().enumerate() {
        let fault = |(waypoint, rejection)| Fault { chunk: index, waypoint, rejection };
        let mode = mode_of(chunk).ok_or((0, None)).map_err(fault)?;
        recheck_chunk(constraints, &mode, chunk.waypoints(), &mut done)
            .map_err(|(at, why)| fault((at, Some(why))))?;
    }
    Ok(done)
}

fn recheck_chunk(
    constraints: &Constraints,
    mode: &Mode,
    waypoints: &[Waypoint],
    done: &mut Recheck,
) -> Result<(), (usize, Rejection)> {
    let mut before: Option<Configuration> = None;
    let (mut snapshots, mut scratch) = <([Snapshot; 2], Snapshot)>::default();
    for (index, waypoint) in waypoints.iter().enumerate() {
        let configuration = configuration_of(waypoint);
        let [here, last] = [index % 2, 1 - index % 2];
        constraints.body.snapshot_into(&configuration, &mut snapshots[here]);
        done.waypoints += 1;
        either_way(mode, |feet| constraints.check(mode, &snapshots[here], feet))
            .map_err(|why| (index, why))?;
        if let Some(from) = before.replace(configuration) {
            let bound = constraints.collision.motion_bound(&snapshots[last], &snapshots[here]);
            let between = |feet| {
                constraints.check_between(mode, [&from, &configuration], bound, feet, &mut scratch)
            };
            done.between += either_way(mode, between).map_err(|why| (index, why))?;
        }
    }
    Ok(())
}

/// Checks with a swing foot in the air, and where it is too near to the world for that, with one
/// that lifts off or lands.
fn either_way<T>(
    mode: &Mode,
    mut check: impl FnMut([FootState; 2]) -> Result<T, Rejection>,
) -> Result<T, Rejection> {
    let feet = |swing| [0, 1].map(|limb| if mode.stands(limb) { FootState::Stance } else { swing });
    match check(feet(FootState::Free)) {
        Err(Rejection::Collision) if mode.swing().is_some() => check(feet(FootState::Leaving)),
        checked => checked,
    }
}

/// The mode of a chunk; nothing where its contacts are not those of its mode.
pub fn mode_of(chunk: &PlanChunk) -> Option<Mode> {
    let footholds: heapless::Vec<Foothold, 2> = chunk.contacts().iter().map(foothold_of).collect();
    let foot = |limb: usize| footholds.iter().find(|foothold| foothold.limb == limb);
    match SupportMode::from_wire(chunk.mode)? {
        SupportMode::Left => foot(0).map(single_mode),
        SupportMode::Right => foot(1).map(single_mode),
        SupportMode::Double => Some(double_mode(foot(0)?, foot(1)?)),
    }
}

fn foothold_of(contact: &Contact) -> Foothold {
    let pose = Pose::from_parts(contact.position.into(), glam::DQuat::from_array(contact.rotation));
    let support = contact.polygon[..contact.polygon_len as usize]
        .iter()
        .map(|vertex| (*vertex).into())
        .collect();
    Foothold::new(contact.limb as usize, pose, support)
}

/// The configuration of a waypoint.
pub fn configuration_of(waypoint: &Waypoint) -> Configuration {
    let rotation = glam::DQuat::from_array(waypoint.root_rotation);
    Configuration {
        world_from_root: Pose::from_parts(waypoint.root_position.into(), rotation),
        q: waypoint.q,
    }
}
