//! Back to where the robot can stand, the way it came.
//!
//! A robot that met what nobody knew of may stand where a search cannot begin: its lifted foot
//! touches what turned out to be there, or what carries it is not quite where it should be. What it
//! walked last it can walk backwards, whatever the planner believes of the world: it has been
//! there. So the lifted foot goes back to where it was lifted, farther back if need be, and the
//! search begins there.

use surefoot_shared_types::message::{PlanChunk, RestState, SupportMode, Waypoint};
use surefoot_shared_types::world::world::World;

use crate::constraints::constraints::Constraints;
use crate::ends::{StandingGround, stand_as};
use crate::foot_placement::sole_support::SurfacesError;

/// Lift-offs that are looked at, the nearest first.
const LIFT_OFFS_MAX: usize = 32;

/// A place that the robot came by.
#[derive(Debug, Clone)]
pub struct Earlier<'a> {
    /// How the robot stood there, with the support that the world gives it.
    pub standing: RestState,
    /// The chunks that it walked since, the first one first.
    pub since: &'a [PlanChunk],
    /// How many such places lie between there and where it stands now, itself included.
    pub places: usize,
}

/// Where a foot was lifted, the robot stood on both and everything holds in `world`, its centre of
/// mass `margin_min` (m) inside its support: the last such place but `places - 1`, or the farthest
/// there is. `walked` are the chunks that it walked, the last one to where it stands now.
/// Allocates.
///
/// # Errors
/// The world has a shape that cannot be used.
pub fn lift_off_before<'a>(
    (constraints, margin_min): (&Constraints, f64),
    world: &World,
    standing: &RestState,
    (walked, places): (&'a [PlanChunk], usize),
) -> Result<Option<Earlier<'a>>, SurfacesError> {
    let walked = &walked[connected_from(standing, walked)..];
    let is_lift_off = |pair: &[PlanChunk]| is_double(&pair[0]) && !is_double(&pair[1]);
    let lift_offs = walked.windows(2).enumerate().rev().filter(|(_, pair)| is_lift_off(pair));
    let mut ground = StandingGround::new(world)?;
    let mut farthest: Option<Earlier> = None;
    for (index, pair) in lift_offs.take(LIFT_OFFS_MAX) {
        let passed = farthest.as_ref().map_or(0, |place| place.places);
        if passed == places {
            break;
        }
        let (mode, contacts, waypoint) =
            (pair[0].mode, pair[0].contacts(), &pair[1].waypoints()[0]);
        let standing =
            ground.supported_anew(&constraints.robot, &standing.after(mode, contacts, waypoint));
        if stand_as(constraints, &standing).is_ok_and(|end| end.holds(constraints, margin_min)) {
            farthest = Some(Earlier { standing, since: &walked[index + 1..], places: passed + 1 });
        }
    }
    Ok(farthest)
}

/// From which chunk on each begins where the one before it ends, and the last one ends where the
/// robot stands; past the last one if it does not.
fn connected_from(standing: &RestState, walked: &[PlanChunk]) -> usize {
    let mut at = &standing.waypoint;
    let mut first = walked.len();
    for chunk in walked.iter().rev() {
        let [begin, .., end] = chunk.waypoints() else { break };
        if !is_same_configuration(end, at) {
            break;
        }
        (at, first) = (begin, first - 1);
    }
    first
}

fn is_same_configuration(a: &Waypoint, b: &Waypoint) -> bool {
    (a.root_position, a.root_rotation, a.q) == (b.root_position, b.root_rotation, b.q)
}

/// Whether the robot stands on both feet all through a chunk.
pub(crate) fn is_double(chunk: &PlanChunk) -> bool {
    chunk.mode == SupportMode::Double as u32
}
