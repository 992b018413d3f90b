//! Self-check of a finished plan with the planner's own constraints: every waypoint and every
//! motion between two. Its time is a lower bound of planning with checks, with which benches
//! compare the search.

use surefoot_shared_types::Pose;
use surefoot_shared_types::message::{Contact, PlanChunk, SupportMode, Waypoint};

use crate::collision::model::FootPhase;
use crate::constraints::constraints::Constraints;
use crate::constraints::foothold::{Foothold, double_mode, single_mode};
use crate::constraints::mode::Mode;
use crate::constraints::rejection::Rejection;
use crate::robot::configuration::Configuration;
use crate::robot::kinematic_state::KinematicState;

/// Statistics of a self-check.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct SelfCheckStats {
    /// Number of waypoints checked. A waypoint that two chunks share counts twice.
    pub waypoints: u64,
    /// Number of configurations checked between waypoints.
    pub between: u64,
}

/// A waypoint that violates a constraint.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct SelfCheckError {
    /// Index of the chunk.
    pub chunk: usize,
    /// Index of the waypoint in it; for a motion, of the waypoint at its end.
    pub waypoint: usize,
    /// The violated constraint; `None` if the chunk's contacts are not those of its mode.
    pub rejection: Option<Rejection>,
}

/// Checks a plan's chunks.
///
/// A swing foot without the full clearance is checked as one that lifts off or lands, because
/// chunks do not name the phase.
///
/// # Errors
/// The first waypoint that violates a constraint.
pub fn self_check(
    constraints: &Constraints,
    chunks: &[PlanChunk],
) -> Result<SelfCheckStats, SelfCheckError> {
    let mut stats = SelfCheckStats::default();
    for (index, chunk) in chunks.iter().enumerate() {
        let fault = |(waypoint, rejection)| SelfCheckError { chunk: index, waypoint, rejection };
        let mode = mode_of(chunk).ok_or((0, None)).map_err(fault)?;
        check_chunk(constraints, &mode, chunk.waypoints(), &mut stats)
            .map_err(|(at, why)| fault((at, Some(why))))?;
    }
    Ok(stats)
}

/// Checks the waypoints of one mode and the motions between them.
fn check_chunk(
    constraints: &Constraints,
    mode: &Mode,
    waypoints: &[Waypoint],
    stats: &mut SelfCheckStats,
) -> Result<(), (usize, Rejection)> {
    let mut before: Option<Configuration> = None;
    let (mut kinematic_states, mut scratch) = <([KinematicState; 2], KinematicState)>::default();
    for (index, waypoint) in waypoints.iter().enumerate() {
        let configuration = configuration_of(waypoint);
        let [here, last] = [index % 2, 1 - index % 2];
        kinematic_states[here].update(&constraints.robot, &configuration);
        stats.waypoints += 1;
        check_either_phase(mode, |feet| constraints.check(mode, &kinematic_states[here], feet))
            .map_err(|why| (index, why))?;
        if let Some(from) = before.replace(configuration) {
            let bound = constraints
                .collision
                .motion_bound(&kinematic_states[last], &kinematic_states[here]);
            let between = |feet| {
                constraints.check_between(mode, [&from, &configuration], bound, feet, &mut scratch)
            };
            stats.between += check_either_phase(mode, between).map_err(|why| (index, why))?;
        }
    }
    Ok(())
}

/// Checks with a swing foot in the air and, if that collides, with one that lifts off or lands.
fn check_either_phase<T>(
    mode: &Mode,
    mut check: impl FnMut([FootPhase; 2]) -> Result<T, Rejection>,
) -> Result<T, Rejection> {
    let feet =
        |swing| [0, 1].map(|limb| if mode.is_stance(limb) { FootPhase::Stance } else { swing });
    match check(feet(FootPhase::Swing)) {
        Err(Rejection::Collision) if mode.swing().is_some() => check(feet(FootPhase::LiftOff)),
        checked => checked,
    }
}

/// The mode of a chunk; `None` where its contacts are not those of its mode.
pub fn mode_of(chunk: &PlanChunk) -> Option<Mode> {
    mode_of_contacts(SupportMode::from_wire(chunk.mode)?, chunk.contacts())
}

/// The mode of a support mode with these contacts; `None` where a foot has none.
pub fn mode_of_contacts(support: SupportMode, contacts: &[Contact]) -> Option<Mode> {
    let footholds: heapless::Vec<Foothold, 2> = contacts.iter().map(foothold_of).collect();
    let foot = |limb: usize| footholds.iter().find(|foothold| foothold.limb == limb);
    match support {
        SupportMode::Left => foot(0).map(single_mode),
        SupportMode::Right => foot(1).map(single_mode),
        SupportMode::Double => Some(double_mode(foot(0)?, foot(1)?)),
    }
}

fn foothold_of(contact: &Contact) -> Foothold {
    let support = contact.polygon().iter().map(|vertex| (*vertex).into()).collect();
    Foothold::new(contact.limb as usize, contact.world_from_sole(), support)
}

/// The configuration of a waypoint.
pub fn configuration_of(waypoint: &Waypoint) -> Configuration {
    let rotation = glam::DQuat::from_array(waypoint.root_rotation);
    Configuration {
        world_from_root: Pose::from_parts(waypoint.root_position.into(), rotation),
        q: waypoint.q,
    }
}
