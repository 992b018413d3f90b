//! Sweeps the primitives of a robot: over which pairs of placements they hold, and how much room
//! they take.
//!
//! Every vertex of a lattice of pairs is tried, every other one with both soles inclined as far as
//! primitives allow, under constraints with more margin than a plan needs. That margin is what
//! covers the pairs between the vertices. A shift is tried with the left foot as stance only: the
//! pairs are the same.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::digest::Digest;
use surefoot_shared_types::robot::RobotModel;
use surefoot_shared_types::scene::World;
use surefoot_shared_types::spatial::rotation_about;

use super::BuildError;
use super::expanded::{Fitting, Phase};
use super::slices::{Owner, Slice, slices};
use crate::body::Body;
use crate::collision::bvh::Aabb;
use crate::collision::{CollisionModel, FootState};
use crate::constraint::{Constraints, Mode};
use crate::motion::foothold::{Foothold, double_mode, single_mode};
use crate::motion::primitive::gait::Gait;
use crate::motion::primitive::path::{LANDING, Place, STRETCHES, configuration, shift_at};
use crate::motion::primitive::stand::{PairOffset, Stand};
use crate::motion::primitive::{foot_state, with_legs};
use crate::motion::track::State;
use crate::random::{Random, Stream};
use crate::snapshot::Snapshot;

/// What is kept beyond a plan's clearance, m.
const CLEARANCE_SLACK: f64 = 0.006;
/// What a leg's links keep beyond a plan's clearance from the ground on which their foot stands, m.
const FLOOR_SLACK: f64 = 0.002;
/// What is kept beyond a plan's joint margin, rad.
const JOINT_SLACK: f64 = 0.02;
/// What is kept beyond a plan's balance margin, m.
const BALANCE_SLACK: f64 = 0.004;
/// The share of a plan's effort that is used.
const EFFORT_SHARE: f64 = 0.95;
/// Samples of each stretch of a place.
const STRETCH_SAMPLES: [usize; STRETCHES] = [2, 6, 2, 2];
/// Samples of a shift.
const SHIFT_SAMPLES: usize = 5;

/// The robot in an empty world, under stricter constraints.
#[derive(Debug)]
pub struct Probe {
    constraints: Constraints,
    slices: Vec<Slice>,
}

impl Probe {
    /// Compiles a robot.
    ///
    /// # Errors
    /// The robot is none that the planner can move.
    pub fn new(model: &RobotModel, config: &PlannerConfig) -> Result<Self, BuildError> {
        let strict = PlannerConfig {
            clearance: config.clearance + CLEARANCE_SLACK,
            joint_margin: config.joint_margin + JOINT_SLACK,
            effort_share: config.effort_share * EFFORT_SHARE,
            ..config.clone()
        };
        let constraints = in_empty_world(model, strict)?;
        let Constraints { body, collision, .. } = &constraints;
        let owner = |link: usize| owner_of(model, body, collision, link);
        let cut = |([link, index], frame, bounds): ([usize; 2], Pose, Aabb)| {
            slices(link, owner(link), frame, &model.links[link].shapes[index].shape, &bounds)
        };
        let slices = collision.part_bounds().flat_map(cut).collect();
        Ok(Self { constraints, slices })
    }

    /// The robot.
    pub fn body(&self) -> &Body {
        &self.constraints.body
    }

    /// How far to the side any part of a foot is from its ankle, m.
    pub fn foot_radius(&self) -> f64 {
        let radius = |limb: usize| {
            let ankle = self.body().legs[limb].sole_from_ankle();
            let bounds = self.constraints.collision.foot_bounds(limb);
            (bounds.min - ankle).abs().max((bounds.max - ankle).abs()).truncate().length()
        };
        radius(0).max(radius(1))
    }

    /// How near to the edge of its support the centre of mass may come, m.
    pub fn balance_margin(&self) -> f64 {
        self.constraints.config.com_margin + BALANCE_SLACK
    }

    /// The box that each foot needs in its sole's frame from the ground to the top of its lift,
    /// with `margin` (m) beside and above it.
    pub fn sole_boxes(&self, gait: &Gait, margin: f64) -> [Aabb; 2] {
        [0, 1].map(|limb| {
            let foot = self.constraints.collision.foot_bounds(limb);
            let (low, high) = (foot.min - DVec3::splat(margin), foot.max + DVec3::splat(margin));
            Aabb {
                min: low.truncate().extend(foot.min.z + SOLE_GAP),
                max: high.truncate().extend(high.z + gait.lift),
            }
        })
    }

    /// No room yet.
    pub fn no_room(&self) -> Fitting {
        Fitting::empty(self.constraints.config.clearance - CLEARANCE_SLACK + FLOOR_SLACK)
    }

    /// Whether all primitives of a pair hold, and the room that they take; `vertex` names the pair
    /// where soles are inclined.
    pub fn try_pair(
        &self,
        gait: &Gait,
        stance: usize,
        offset: &PairOffset,
        vertex: Option<u64>,
    ) -> Option<Fitting> {
        if self.body().legs.iter().any(|leg| leg.joints().len() != UNIQUE_JOINTS) {
            return None;
        }
        let stands = self.stands(stance, offset);
        let rotations = inclinations(&stands, gait.tilt, vertex);
        let footholds = [0, 1].map(|limb| {
            let leg = &self.body().legs[limb];
            Foothold::whole(self.body(), limb, stands[limb].sole(leg, rotations[limb]))
        });
        let mut fitting = self.no_room();
        let held = self.place_holds(gait, stance, &footholds, &stands, &mut fitting)
            && (stance == 1 || self.shift_holds(gait, &footholds, &stands, &mut fitting));
        held.then_some(fitting)
    }

    fn stands(&self, stance: usize, offset: &PairOffset) -> [Stand; 2] {
        let about = Stand { origin: DVec3::ZERO, yaw: 0.0, tilt: 0.0 };
        let other = about.at_offset(offset, 1 - stance);
        if stance == 0 { [about, other] } else { [other, about] }
    }

    fn place_holds(
        &self,
        gait: &Gait,
        stance: usize,
        footholds: &[Foothold; 2],
        stands: &[Stand; 2],
        fitting: &mut Fitting,
    ) -> bool {
        let mode = single_mode(&footholds[stance]);
        let other = &footholds[1 - stance];
        let Ok(place) = Place::new(self.body(), gait, &footholds[stance], other) else {
            return false;
        };
        let leg = &self.body().legs[1 - stance];
        let mut seed = place.placed;
        (0..STRETCHES).rev().all(|stretch| {
            (0..=STRETCH_SAMPLES[stretch]).rev().all(|sample| {
                let t = sample as f64 / STRETCH_SAMPLES[stretch] as f64;
                let Ok(state) = with_legs(self.body(), place.at(stretch, t, &seed)) else {
                    return false;
                };
                seed = state;
                let snapshot = self.body().snapshot(&state.configuration);
                let mut feet = [FootState::Stance; 2];
                feet[1 - stance] = foot_state(stretch);
                let phase = Phase::Place { stance, stretch, landing: stretch == LANDING };
                let swing = Stand::of(leg, &state.world_from_soles[1 - stance]);
                self.admits(&mode, &snapshot, feet)
                    && fitting.add(&self.slices, (self.body(), &snapshot), stands, &swing, phase)
            })
        })
    }

    fn shift_holds(
        &self,
        gait: &Gait,
        footholds: &[Foothold; 2],
        stands: &[Stand; 2],
        fitting: &mut Fitting,
    ) -> bool {
        let body = self.body();
        let mode = double_mode(&footholds[0], &footholds[1]);
        let over = |limb: usize| configuration(body, gait, &footholds[limb], &footholds[1 - limb]);
        let (Ok(left), Ok(right)) = (over(0), over(1)) else { return false };
        let mut seed: State = left;
        (0..=SHIFT_SAMPLES).all(|sample| {
            let share = sample as f64 / SHIFT_SAMPLES as f64;
            let moved = shift_at(&left.configuration, &right.configuration, share, &seed);
            let Ok(state) = with_legs(body, moved) else { return false };
            seed = state;
            let snapshot = body.snapshot(&state.configuration);
            self.admits(&mode, &snapshot, [FootState::Stance; 2])
                && fitting.add(
                    &self.slices,
                    (body, &snapshot),
                    stands,
                    &stands[0],
                    Phase::Shift { share },
                )
        })
    }

    fn admits(&self, mode: &Mode, snapshot: &Snapshot, feet: [FootState; 2]) -> bool {
        mode.region.margin(snapshot.com.truncate())
            >= self.constraints.com_margin(mode) + BALANCE_SLACK
            && self.constraints.check(mode, snapshot, feet).is_ok()
    }
}

/// A robot's constraints where nothing is in its way.
///
/// # Errors
/// The robot is none that the planner can move.
pub fn in_empty_world(
    model: &RobotModel,
    config: PlannerConfig,
) -> Result<Constraints, BuildError> {
    let body = Body::new(model, &config)?;
    let world = World { mu: 1.0, shapes: vec![], digest: Digest::default() };
    let collision = CollisionModel::new(model, &world, config.clearance)?;
    Ok(Constraints { body, collision, config })
}

/// Joints of a leg whose positions follow from its sole: with more of them a neutral configuration
/// is not unique.
const UNIQUE_JOINTS: usize = 6;
/// Where a foot's box begins above the ground: a leaving foot's own clearance begins there, m.
const SOLE_GAP: f64 = 0.0005;

fn owner_of(model: &RobotModel, body: &Body, collision: &CollisionModel, link: usize) -> Owner {
    if let Some(limb) = collision.foot_of(link) {
        return Owner::Foot(limb);
    }
    let chain = model.chain(link);
    let in_leg =
        |limb: usize| body.legs[limb].joints().iter().any(|joint| chain.contains(&joint.index));
    match (in_leg(0), in_leg(1)) {
        (true, false) => Owner::Leg(0),
        (false, true) => Owner::Leg(1),
        _ => Owner::Trunk,
    }
}

/// The rotations of both soles: level, or inclined as far as primitives allow in directions that
/// depend on the vertex.
fn inclinations(stands: &[Stand; 2], tilt: f64, vertex: Option<u64>) -> [glam::DQuat; 2] {
    [0, 1].map(|limb| {
        let level = rotation_about(DVec3::Z, stands[limb].yaw);
        let Some(vertex) = vertex else { return level };
        let direction = Random::new(0, Stream::Preparation, limb as u64 | 1 << 32, vertex)
            .uniform(-std::f64::consts::PI, std::f64::consts::PI);
        let axis = DVec3::new(libm::cos(direction), libm::sin(direction), 0.0);
        rotation_about(axis, tilt) * level
    })
}
