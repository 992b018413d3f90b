//! A plan: the motion from start to goal, in chunks.

use std::sync::Arc;

pub use surefoot_shared_types::base::digest::Digest;
pub use surefoot_shared_types::message::PlanChunk;
use surefoot_shared_types::message::{Contact, Interpolation, RestState, SupportMode, Waypoint};

use crate::api::plan_inputs::PlanInputs;
use crate::api::pose::Pose;
use crate::api::robot::Robot;
use crate::api::world::World;

/// A foot.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Foot {
    /// The left foot.
    Left,
    /// The right foot.
    Right,
}

impl Foot {
    pub(crate) fn of_limb(limb: u32) -> Option<Self> {
        [Self::Left, Self::Right].into_iter().find(|foot| *foot as u32 == limb)
    }
}

/// A place where a foot stands.
#[derive(Debug, Clone, PartialEq)]
pub struct Foothold {
    /// The foot.
    pub foot: Foot,
    /// When the foot is set down, s since the beginning of the plan; 0 for the start stance.
    pub time: f64,
    /// Position of the sole frame in the world, m.
    pub position: [f64; 3],
    /// Rotation of the sole frame in the world, unit quaternion x, y, z, w.
    pub rotation: [f64; 4],
    /// The supported part of the sole: convex, counter-clockwise, in the sole frame, m.
    pub polygon: Vec<[f64; 2]>,
}

impl Foothold {
    fn new(contact: &Contact, time: f64) -> Option<Self> {
        Some(Self {
            foot: Foot::of_limb(contact.limb)?,
            time,
            position: contact.position,
            rotation: contact.rotation,
            polygon: contact.polygon().to_vec(),
        })
    }
}

/// The feet that carry the robot at an instant.
#[derive(Debug, Clone, PartialEq)]
pub struct Contacts {
    /// One foothold for each stance foot.
    pub footholds: Vec<Foothold>,
}

impl Contacts {
    /// Whether a foot carries the robot.
    pub fn is_stance(&self, foot: Foot) -> bool {
        self.footholds.iter().any(|foothold| foothold.foot == foot)
    }
}

/// A configuration of the robot at an instant, with the feet that carry it.
#[derive(Debug, Clone, PartialEq)]
pub struct State {
    /// Time since the beginning of the plan, s.
    pub time: f64,
    /// Pose of the root link in the world.
    pub world_from_root: Pose,
    /// Joint positions in the order of [`Robot::joint_names`](crate::Robot::joint_names), rad or m.
    pub q: Vec<f64>,
    /// Velocity of the root's origin (m/s), the root's angular velocity (rad/s), both along the
    /// world's axes, then the joints' in the order of `q`.
    pub velocity: Vec<f64>,
    /// The derivative of `velocity`.
    pub acceleration: Vec<f64>,
    /// Feed-forward joint efforts in the order of `q`, N m or N; 0 in a quasi-static plan.
    pub torque: Vec<f64>,
    /// The stance feet.
    pub contacts: Contacts,
    rest_state: RestState,
}

impl State {
    /// The message that a planner begins from.
    pub(crate) fn rest_state(&self) -> &RestState {
        &self.rest_state
    }
}

/// A whole-body walk. It owns its chunks; cheap to clone.
#[derive(Debug, Clone)]
pub struct Plan {
    chunks: Arc<[PlanChunk]>,
    footholds: Arc<[Foothold]>,
    digest: Digest,
    inputs: Arc<PlanInputs>,
}

impl Plan {
    /// A plan of a complete stream of chunks, which has at least one, and what it answers.
    pub(crate) fn new(chunks: &[PlanChunk], digest: Digest, inputs: PlanInputs) -> Self {
        let inputs = Arc::new(inputs);
        Self { footholds: footholds(chunks).into(), chunks: chunks.into(), digest, inputs }
    }

    /// What it answers.
    pub(crate) fn inputs(&self) -> &PlanInputs {
        &self.inputs
    }

    /// The robot that it moves.
    pub fn robot(&self) -> &Robot {
        &self.inputs.robot
    }

    /// The world that it was planned in.
    pub fn world(&self) -> &World {
        &self.inputs.world
    }

    /// All footholds: the start stance, then each landing in order.
    pub fn footholds(&self) -> &[Foothold] {
        &self.footholds
    }

    /// The chunks as they are published: at most 32 waypoints each, one support mode each. Session
    /// and receiver are not set.
    pub fn chunks(&self) -> &[PlanChunk] {
        &self.chunks
    }

    /// The digest of the chunk stream: equal plans have equal digests. A plan file holds less than
    /// the stream, so a loaded plan has another digest than the one that was saved.
    pub fn digest(&self) -> Digest {
        self.digest
    }

    /// Duration, s.
    pub fn duration(&self) -> f64 {
        self.chunks.last().and_then(|chunk| chunk.waypoints().last()).map_or(0.0, |last| last.time)
    }

    /// The feet that carry the robot at time `t` (s), clamped to the duration.
    pub fn contacts_at(&self, t: f64) -> Contacts {
        contacts(self.chunk_at(t))
    }

    /// The motion at time `t` (s), clamped to the duration. Between two waypoints of a quasi-static
    /// plan joints and root position are linear in time, the root's rotation follows the shortest
    /// arc; between two of a smooth plan all follow polynomials of degree 5.
    pub fn sample(&self, t: f64) -> State {
        let index = self.chunk_index_at(t);
        let chunk = &self.chunks[index];
        let interpolation =
            Interpolation::from_wire(chunk.interpolation).unwrap_or(Interpolation::Linear);
        let waypoint = interpolation.sample(chunk.waypoints(), t);
        let joints = chunk.joints_len as usize;
        let rates = |root: &[f64], joint: &[f64]| [root, &joint[..joints]].concat();
        State {
            time: waypoint.time,
            world_from_root: waypoint.world_from_root().into(),
            q: waypoint.q[..joints].to_vec(),
            velocity: rates(&waypoint.root_velocity, &waypoint.joint_velocity),
            acceleration: rates(&waypoint.root_acceleration, &waypoint.joint_acceleration),
            torque: waypoint.torque[..joints].to_vec(),
            contacts: contacts(chunk),
            rest_state: self.rest_state(index, &waypoint.rested()),
        }
    }

    /// The first chunk that ends at `t` (s) or later, or the last one.
    pub(crate) fn chunk_at(&self, t: f64) -> &PlanChunk {
        &self.chunks[self.chunk_index_at(t)]
    }

    fn chunk_index_at(&self, t: f64) -> usize {
        let ends_before = |chunk: &PlanChunk| chunk.waypoints().last().is_some_and(|w| w.time < t);
        self.chunks.partition_point(ends_before).min(self.chunks.len().saturating_sub(1))
    }

    /// The state at a waypoint of a chunk. A lifted foot keeps the contact that it had.
    fn rest_state(&self, index: usize, waypoint: &Waypoint) -> RestState {
        let unknown = RestState { contacts_len: 0, ..bytemuck::Zeroable::zeroed() };
        self.chunks[..=index].iter().fold(unknown, |state: RestState, chunk| {
            state.after(chunk.mode, chunk.contacts(), waypoint)
        })
    }
}

fn contacts(chunk: &PlanChunk) -> Contacts {
    let time = chunk.waypoints().first().map_or(0.0, |first| first.time);
    let mode = SupportMode::from_wire(chunk.mode);
    let carries = |contact: &&Contact| mode.is_some_and(|mode| mode.carries(contact.limb as usize));
    let stance = chunk.contacts().iter().filter(carries);
    Contacts { footholds: stance.filter_map(|contact| Foothold::new(contact, time)).collect() }
}

/// The start stance and each landing.
fn footholds(chunks: &[PlanChunk]) -> Vec<Foothold> {
    let mut known: [Option<[f64; 7]>; 2] = [None; 2];
    let mut footholds = vec![];
    for foothold in chunks.iter().flat_map(|chunk| contacts(chunk).footholds) {
        let [x, y, z] = foothold.position;
        let [i, j, k, w] = foothold.rotation;
        let pose = Some([x, y, z, i, j, k, w]);
        if known[foothold.foot as usize] != pose {
            known[foothold.foot as usize] = pose;
            footholds.push(foothold);
        }
    }
    footholds
}

#[cfg(test)]
mod tests {
    use std::collections::BTreeMap;

    use bytemuck::Zeroable;
    use surefoot_shared_types::plan_format::blocks::EndBlock;

    use super::*;

    fn waypoint(time: f64, x: f64) -> Waypoint {
        let mut waypoint = Waypoint { time, root_position: [x, 0.0, 1.0], ..Zeroable::zeroed() };
        (waypoint.root_rotation[3], waypoint.q[0]) = (1.0, 2.0 * x);
        waypoint
    }

    /// Chunks on both feet, then on the left, then on both with the right foot moved on.
    fn plan() -> Plan {
        let contact = |limb, x| Contact {
            limb,
            position: [x, 0.0, 0.0],
            rotation: [0.0, 0.0, 0.0, 1.0],
            ..Zeroable::zeroed()
        };
        let chunk = |mode: SupportMode, contacts: &[Contact], times: [f64; 2]| {
            let mut chunk = PlanChunk { mode: mode as u32, joints_len: 1, ..Zeroable::zeroed() };
            chunk.contacts[..contacts.len()].copy_from_slice(contacts);
            chunk.contacts_len = contacts.len() as u32;
            chunk.waypoints[..2].copy_from_slice(&times.map(|time| waypoint(time, time)));
            chunk.waypoints_len = 2;
            chunk
        };
        let (left, before, after) = (contact(0, 0.0), contact(1, 0.0), contact(1, 0.3));
        let chunks = [
            chunk(SupportMode::Double, &[left, before], [0.0, 1.0]),
            chunk(SupportMode::Left, &[left], [1.0, 3.0]),
            chunk(SupportMode::Double, &[left, after], [3.0, 4.0]),
        ];
        let robot = Robot::load("configs/robots/hubo/robot.toml").unwrap();
        let world = World::load("configs/worlds/flat_walk.toml").unwrap();
        let end = EndBlock::Feet { soles: BTreeMap::new(), tol: 0.1 };
        let inputs = PlanInputs { robot, world, ends: [end.clone(), end] };
        Plan::new(&chunks, Digest::default(), inputs)
    }

    #[test]
    fn footholds_are_the_start_stance_and_each_landing() {
        let plan = plan();
        let found: Vec<(Foot, f64, f64)> = plan
            .footholds()
            .iter()
            .map(|foothold| (foothold.foot, foothold.time, foothold.position[0]))
            .collect();
        let expected = [(Foot::Left, 0.0, 0.0), (Foot::Right, 0.0, 0.0), (Foot::Right, 3.0, 0.3)];
        assert_eq!(found, expected);
    }

    #[test]
    fn samples_lie_between_the_waypoints_and_stay_within_the_duration() {
        let plan = plan();
        assert_eq!(plan.duration(), 4.0);
        let state = plan.sample(2.5);
        assert_eq!((state.time, state.q[0], state.world_from_root.position[0]), (2.5, 5.0, 2.5));
        assert_eq!(state.velocity, [1.0, 0.0, 0.0, 0.0, 0.0, 0.0, 2.0]);
        assert_eq!((&state.acceleration[..], &state.torque[..]), (&[0.0; 7][..], &[0.0][..]));
        assert!(state.contacts.is_stance(Foot::Left) && !state.contacts.is_stance(Foot::Right));
        let lifted = state.rest_state().contact_of(1).unwrap();
        assert_eq!(lifted.position[0], 0.0, "a lifted foot keeps the contact that it had");
        assert_eq!(plan.sample(-1.0).time, 0.0);
        assert_eq!(plan.sample(9.0).time, 4.0);
        assert_eq!(plan.sample(3.5).rest_state().contact_of(1).unwrap().position[0], 0.3);
    }
}
