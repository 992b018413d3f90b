//! A contact sequence for trajectory optimisers: phases with their contacts, and the robot's
//! motion, centre of mass and contact wrenches at knots.

use glam::DQuat;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use surefoot_controller_sim::statics::FootLoad;
use surefoot_shared_types::message::Contact;
use surefoot_shared_types::plan_format::blocks::{OriginBlock, PoseBlock};
use surefoot_shared_types::world::world::GRAVITY;

use crate::export::bodies::{body_motions, centre_of_mass};
use crate::export::error::ExportError;
use crate::export::loads::{StaticLoads, moment_about};
use crate::export::motion::{ExportMotion, SupportPhase};
use crate::export::sampling::{Sample, samples};

/// The `schema` field of every sequence.
pub const SCHEMA: &str = "surefoot-contact-sequence/1";

/// A contact sequence. Lengths in m, times in s since the plan's beginning, forces in N, moments in
/// N m, along the axes of the world, whose z points up.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct ContactSequence {
    /// [`SCHEMA`].
    pub schema: String,
    /// The robot.
    pub robot: SequenceRobot,
    /// What the plan was made from.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub origin: Option<OriginBlock>,
    /// Gravity along -z, m/s2.
    pub gravity: f64,
    /// Coefficient of friction of all contacts.
    pub mu: f64,
    /// "linear" (straight lines between the plan's waypoints: velocities jump there) or "quintic".
    pub interpolation: String,
    /// "static": the wrenches hold the robot at rest in each configuration; motion adds nothing to
    /// them.
    pub wrenches: String,
    /// The support phases in order. Each begins when the one before ends.
    pub phases: Vec<SequencePhase>,
    /// The knots in order, equally spaced in time.
    pub knots: Vec<Knot>,
}

/// The robot of a sequence.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SequenceRobot {
    /// Its name.
    pub name: String,
    /// Absolute path of its URDF.
    pub urdf: String,
    /// Its root link.
    pub root_link: String,
    /// Its mass, kg.
    pub mass: f64,
    /// The moving joints, in the order of `q`, `v` and `a`.
    pub joint_names: Vec<String>,
    /// Joints held still, and their positions, rad or m.
    pub locked_joints: std::collections::BTreeMap<String, f64>,
    /// The feet.
    pub feet: Vec<SequenceFoot>,
}

/// A foot of a sequence's robot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SequenceFoot {
    /// "left" or "right".
    pub name: String,
    /// The link that carries the sole.
    pub link: String,
    /// The sole frame in the link's frame.
    pub link_from_sole: PoseBlock,
    /// The sole's outline in the sole frame at z = 0, m: convex, counter-clockwise.
    pub polygon: Vec<[f64; 2]>,
}

/// A support phase.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SequencePhase {
    /// Its begin, s.
    pub begin: f64,
    /// Its end, s.
    pub end: f64,
    /// The stance feet.
    pub contacts: Vec<SequenceContact>,
}

/// A stance foot.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct SequenceContact {
    /// "left" or "right".
    pub foot: String,
    /// The sole frame in the world.
    pub sole_pose: PoseBlock,
}

/// The robot at an instant.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Knot {
    /// The time, s.
    pub t: f64,
    /// Index of its phase.
    pub phase: usize,
    /// The root link's pose in the world.
    pub root_pose: PoseBlock,
    /// Joint positions, rad or m.
    pub q: Vec<f64>,
    /// Velocity of the root's origin (m/s), angular velocity of the root (rad/s), both along the
    /// world's axes, then joint velocities.
    pub v: Vec<f64>,
    /// The derivative of `v`.
    pub a: Vec<f64>,
    /// The centre of mass.
    pub com: [f64; 3],
    /// Its velocity, m/s.
    pub com_velocity: [f64; 3],
    /// The wrench of the ground on each stance foot that carries weight.
    pub wrenches: Vec<Wrench>,
}

/// The wrench of the ground on a foot, about the origin of its sole frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize, JsonSchema)]
pub struct Wrench {
    /// "left" or "right".
    pub foot: String,
    /// The force, N.
    pub force: [f64; 3],
    /// The moment about the origin of the sole frame, N m.
    pub moment: [f64; 3],
    /// The centre of pressure, m.
    pub centre_of_pressure: [f64; 3],
}

/// The contact sequence of a plan with knots at a rate.
///
/// # Errors
/// Too many knots, or no contact forces hold the robot.
pub fn contact_sequence(motion: &ExportMotion, hz: f64) -> Result<ContactSequence, ExportError> {
    let mut loads = StaticLoads::new(motion)?;
    let knot_at = |sample: Sample| -> Result<Knot, ExportError> {
        let load = loads.at(&sample.waypoint, sample.phase)?;
        Ok(knot(motion, &sample, &load.feet))
    };
    let knots = samples(motion, hz)?.map(knot_at).collect::<Result<_, _>>()?;
    Ok(ContactSequence {
        schema: SCHEMA.to_owned(),
        robot: robot(motion),
        origin: motion.origin.clone(),
        gravity: GRAVITY,
        mu: motion.world.mu,
        interpolation: motion.interpolation.name().to_owned(),
        wrenches: "static".to_owned(),
        phases: motion.phases.iter().map(|phase| sequence_phase(motion, phase)).collect(),
        knots,
    })
}

/// The contact sequence of a plan as JSON.
///
/// # Errors
/// As [`contact_sequence`].
pub fn write(motion: &ExportMotion, hz: f64) -> Result<Vec<u8>, ExportError> {
    let sequence = contact_sequence(motion, hz)?;
    let mut text =
        serde_json::to_vec(&sequence).map_err(|error| ExportError::writer("contacts", error))?;
    text.push(b'\n');
    Ok(text)
}

fn robot(motion: &ExportMotion) -> SequenceRobot {
    let model = &motion.model;
    let feet = model.feet.iter().map(|foot| SequenceFoot {
        name: foot.name.clone(),
        link: model.links[foot.link].name.clone(),
        link_from_sole: PoseBlock::of(&foot.link_from_sole),
        polygon: foot.polygon.iter().map(|corner| corner.to_array()).collect(),
    });
    let locked = model.locked_joints.iter();
    SequenceRobot {
        name: model.name.clone(),
        urdf: model.urdf_path.to_string_lossy().into_owned(),
        root_link: model.links[0].name.clone(),
        mass: model.mass(),
        joint_names: model.joints.iter().map(|joint| joint.name.clone()).collect(),
        locked_joints: locked.map(|at| (at.joint.name.clone(), at.position)).collect(),
        feet: feet.collect(),
    }
}

fn sequence_phase(motion: &ExportMotion, phase: &SupportPhase) -> SequencePhase {
    let (begin, end) = motion.phase_span(phase);
    let contacts = phase.contacts.iter().map(|contact| SequenceContact {
        foot: motion.model.feet[contact.limb as usize].name.clone(),
        sole_pose: PoseBlock { xyz: contact.position, quat_xyzw: contact.rotation },
    });
    SequencePhase { begin, end, contacts: contacts.collect() }
}

fn knot(motion: &ExportMotion, sample: &Sample, feet: &[FootLoad]) -> Knot {
    let (waypoint, model) = (&sample.waypoint, &motion.model);
    let joints = model.joints.len();
    let (com, com_velocity) = centre_of_mass(model, &body_motions(model, waypoint));
    let wrench = |foot: &FootLoad| {
        let contact = motion.phases[sample.phase].contact(foot.limb)?;
        Some(wrench(&model.feet[foot.limb].name, foot, contact))
    };
    Knot {
        t: waypoint.time,
        phase: sample.phase,
        root_pose: PoseBlock {
            xyz: waypoint.root_position,
            quat_xyzw: DQuat::from_array(waypoint.root_rotation).normalize().to_array(),
        },
        q: waypoint.q[..joints].to_vec(),
        v: [&waypoint.root_velocity[..], &waypoint.joint_velocity[..joints]].concat(),
        a: [&waypoint.root_acceleration[..], &waypoint.joint_acceleration[..joints]].concat(),
        com: com.to_array(),
        com_velocity: com_velocity.to_array(),
        wrenches: feet.iter().filter_map(wrench).collect(),
    }
}

fn wrench(name: &str, foot: &FootLoad, contact: &Contact) -> Wrench {
    Wrench {
        foot: name.to_owned(),
        force: foot.force.to_array(),
        moment: moment_about(foot, contact.position.into()).to_array(),
        centre_of_pressure: foot.centre.to_array(),
    }
}
