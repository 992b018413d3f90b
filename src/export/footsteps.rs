//! A list of footsteps: where and when each foot stands, and how it swings there.

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use surefoot_shared_types::message::Contact;
use surefoot_shared_types::plan_format::blocks::{OriginBlock, PoseBlock};

use crate::export::bodies::{body_motions, world_from_sole};
use crate::export::error::ExportError;
use crate::export::motion::ExportMotion;

/// The `schema` field of every list.
pub const SCHEMA: &str = "surefoot-footsteps/1";

/// A list of footsteps. Lengths in m, times in s since the plan's beginning. Poses are those of
/// sole frames in the world: z points from the ground into the foot, x to the toes.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct FootstepList {
    /// [`SCHEMA`].
    pub schema: String,
    /// The robot's name.
    pub robot: String,
    /// What the plan was made from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub origin: Option<OriginBlock>,
    /// When the plan begins, s.
    pub begin: f64,
    /// When the plan ends, s.
    pub end: f64,
    /// The start stance, then each landing in order.
    pub footsteps: Vec<Footstep>,
}

/// A place where a foot stands.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Footstep {
    /// The foot: "left" or "right".
    pub foot: String,
    /// The sole frame in the world.
    pub sole_pose: PoseBlock,
    /// The sole's outline in the sole frame at z = 0, m: convex, counter-clockwise.
    pub polygon: Vec<[f64; 2]>,
    /// When the foot is set down, s; the plan's beginning for the start stance.
    pub touch_down: f64,
    /// How the foot came; none for the start stance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub swing: Option<Swing>,
}

/// The motion of a foot from one place to the next.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Swing {
    /// When the foot lifts off, s.
    pub lift_off: f64,
    /// The sole at the plan's waypoints, lift-off and touch-down included.
    pub waypoints: Vec<SwingWaypoint>,
}

/// The sole of a swing foot at an instant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SwingWaypoint {
    /// The time, s.
    pub t: f64,
    /// The sole frame in the world.
    pub sole_pose: PoseBlock,
}

/// The footsteps of a plan.
pub fn footsteps(motion: &ExportMotion) -> FootstepList {
    let (begin, end) = motion.span();
    let mut found: Vec<Footstep> =
        (0..motion.model.feet.len()).flat_map(|limb| of_foot(motion, limb)).collect();
    found.sort_by(|a, b| a.touch_down.total_cmp(&b.touch_down));
    FootstepList {
        schema: SCHEMA.to_owned(),
        robot: motion.model.name.clone(),
        origin: motion.origin.clone(),
        begin,
        end,
        footsteps: found,
    }
}

/// The footsteps of a plan as JSON.
///
/// # Errors
/// The JSON writer fails.
pub fn write(motion: &ExportMotion) -> Result<Vec<u8>, ExportError> {
    let mut text = serde_json::to_vec_pretty(&footsteps(motion))
        .map_err(|error| ExportError::writer("footsteps", error))?;
    text.push(b'\n');
    Ok(text)
}

fn of_foot(motion: &ExportMotion, limb: usize) -> Vec<Footstep> {
    let mut found = Vec::new();
    // Index of the waypoint at which the foot lifted off.
    let mut lifted: Option<usize> = None;
    let mut stands = false;
    for phase in &motion.phases {
        match phase.contact(limb) {
            None if stands => {
                lifted = Some(phase.first);
                stands = false;
            }
            None => {}
            Some(contact) => {
                if !stands {
                    let swing = lifted.take().map(|first| swing(motion, limb, first..=phase.first));
                    found.push(footstep(motion, contact, phase.first, swing));
                }
                stands = true;
            }
        }
    }
    found
}

fn footstep(
    motion: &ExportMotion,
    contact: &Contact,
    waypoint: usize,
    swing: Option<Swing>,
) -> Footstep {
    let foot = &motion.model.feet[contact.limb as usize];
    Footstep {
        foot: foot.name.clone(),
        sole_pose: PoseBlock { xyz: contact.position, quat_xyzw: contact.rotation },
        polygon: foot.polygon.iter().map(|corner| corner.to_array()).collect(),
        touch_down: motion.waypoints[waypoint].time,
        swing,
    }
}

fn swing(motion: &ExportMotion, limb: usize, range: std::ops::RangeInclusive<usize>) -> Swing {
    let at = |waypoint: &surefoot_shared_types::message::Waypoint| {
        let motions = body_motions(&motion.model, waypoint);
        let sole_pose = PoseBlock::of(&world_from_sole(&motion.model, &motions, limb));
        SwingWaypoint { t: waypoint.time, sole_pose }
    };
    Swing {
        lift_off: motion.waypoints[*range.start()].time,
        waypoints: motion.waypoints[range].iter().map(at).collect(),
    }
}
