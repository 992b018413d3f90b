//! The primitive sweep of a robot: the placement pairs over which its primitives hold, and the
//! volume that they occupy.
//!
//! Every vertex of a lattice of pairs is tried, every second one with both soles inclined as far as
//! primitives allow, under constraints with larger margins than a plan's. The additional margin
//! covers the pairs between the vertices. A shift is tried with the left foot as stance only,
//! because both feet have the same pairs.

use glam::DVec3;
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::base::spatial::rotation_about;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::model::RobotModel;
use surefoot_shared_types::world::world::World;

use crate::base::random::{Random, Stream};
use crate::collision::model::{CollisionModel, FootPhase};
use crate::constraints::constraints::Constraints;
use crate::constraints::foothold::{Foothold, double_mode, single_mode};
use crate::constraints::mode::Mode;
use crate::constraints::mode_state::ModeState;
use crate::geometry::bvh::Aabb;
use crate::preparation::error::BuildError;
use crate::preparation::expanded_geometry::{ExpandedBuilder, PrimitivePart};
use crate::preparation::shape_slices::{RobotPart, Slice, slices};
use crate::preparation::tuning::{
    BALANCE_SLACK, CLEARANCE_SLACK, EFFORT_FRACTION, FLOOR_SLACK, JOINT_SLACK, SECTION_SAMPLES,
    SHIFT_SAMPLES,
};
use crate::primitives::level_sole::{LevelSole, PairOffset};
use crate::primitives::step_path::{LANDING, SECTIONS, shift_at};
use crate::primitives::step_state::{foot_phase, with_legs};
use crate::primitives::{Gait, HalfSwing, configuration};
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::Mechanism;

/// The robot in an empty world, under stricter constraints than a plan's.
#[derive(Debug)]
pub(crate) struct PrimitiveSweep {
    constraints: Constraints,
    slices: Vec<Slice>,
}

impl PrimitiveSweep {
    /// Compiles a robot.
    ///
    /// # Errors
    /// The planner cannot move the robot.
    pub fn new(model: &RobotModel, config: &PlannerConfig) -> Result<Self, BuildError> {
        let strict = PlannerConfig {
            clearance: config.clearance + CLEARANCE_SLACK,
            joint_margin: config.joint_margin + JOINT_SLACK,
            effort_share: config.effort_share * EFFORT_FRACTION,
            ..config.clone()
        };
        let constraints = constraints_in_empty_world(model, strict)?;
        let Constraints { robot, collision, .. } = &constraints;
        let robot_part = |link: usize| robot_part_of(model, robot, collision, link);
        let cut = |([link, index], frame, bounds): ([usize; 2], Pose, Aabb)| {
            slices(link, robot_part(link), frame, &model.links[link].shapes[index].shape, &bounds)
        };
        let slices = collision.part_bounds().flat_map(cut).collect();
        Ok(Self { constraints, slices })
    }

    /// The robot.
    pub fn robot(&self) -> &Mechanism {
        &self.constraints.robot
    }

    /// The largest horizontal distance of any part of a foot from its ankle, m.
    pub fn foot_radius(&self) -> f64 {
        let radius = |limb: usize| {
            let ankle = self.robot().legs[limb].sole_from_ankle();
            let bounds = self.constraints.collision.foot_bounds(limb);
            (bounds.min - ankle).abs().max((bounds.max - ankle).abs()).truncate().length()
        };
        radius(0).max(radius(1))
    }

    /// The least distance of the centre of mass from the edge of its support, m.
    pub fn balance_margin(&self) -> f64 {
        self.constraints.config.com_margin + BALANCE_SLACK
    }

    /// The box of each foot in its sole's frame, from the ground to the top of its lift, with
    /// `margin` (m) beside and above it.
    pub fn sole_boxes(&self, gait: &Gait, margin: f64) -> [Aabb; 2] {
        [0, 1].map(|limb| {
            let foot = self.constraints.collision.foot_bounds(limb);
            let (low, high) = (foot.min - DVec3::splat(margin), foot.max + DVec3::splat(margin));
            Aabb {
                min: low.truncate().extend(foot.min.z + SOLE_GAP),
                max: high.truncate().extend(high.z + gait.lift_height),
            }
        })
    }

    /// Empty boxes of the expanded geometry.
    pub fn empty_boxes(&self) -> ExpandedBuilder {
        ExpandedBuilder::empty(self.constraints.config.clearance - CLEARANCE_SLACK + FLOOR_SLACK)
    }

    /// The volume that the primitives of a pair occupy; `None` if one of them violates a
    /// constraint. `vertex` is the pair's number if its soles are inclined.
    pub fn try_pair(
        &self,
        gait: &Gait,
        stance: usize,
        offset: &PairOffset,
        vertex: Option<u64>,
    ) -> Option<ExpandedBuilder> {
        if self.robot().legs.iter().any(|leg| leg.joints().len() != UNIQUE_JOINTS) {
            return None;
        }
        let level_soles = self.level_soles(stance, offset);
        let rotations = inclinations(&level_soles, gait.tilt, vertex);
        let footholds = [0, 1].map(|limb| {
            let leg = &self.robot().legs[limb];
            Foothold::whole(self.robot(), limb, level_soles[limb].sole(leg, rotations[limb]))
        });
        let mut fitting = self.empty_boxes();
        let held = self.half_swing_holds(gait, stance, &footholds, &level_soles, &mut fitting)
            && (stance == 1 || self.shift_holds(gait, &footholds, &level_soles, &mut fitting));
        held.then_some(fitting)
    }

    /// The level soles of a pair, by limb.
    fn level_soles(&self, stance: usize, offset: &PairOffset) -> [LevelSole; 2] {
        let about = LevelSole { origin: DVec3::ZERO, yaw: 0.0, tilt: 0.0 };
        let other = about.at_offset(offset, 1 - stance);
        if stance == 0 { [about, other] } else { [other, about] }
    }

    /// Whether the half swing of a pair meets every constraint; adds its volume to `fitting`.
    fn half_swing_holds(
        &self,
        gait: &Gait,
        stance: usize,
        footholds: &[Foothold; 2],
        level_soles: &[LevelSole; 2],
        fitting: &mut ExpandedBuilder,
    ) -> bool {
        let mode = single_mode(&footholds[stance]);
        let other = &footholds[1 - stance];
        let Ok(half_swing) = HalfSwing::new(self.robot(), gait, &footholds[stance], other) else {
            return false;
        };
        let leg = &self.robot().legs[1 - stance];
        let mut seed = half_swing.placed;
        (0..SECTIONS).rev().all(|section| {
            (0..=SECTION_SAMPLES[section]).rev().all(|sample| {
                let t = sample as f64 / SECTION_SAMPLES[section] as f64;
                let Ok(state) = with_legs(self.robot(), half_swing.at(section, t, &seed)) else {
                    return false;
                };
                seed = state;
                let kinematic_state = KinematicState::new(self.robot(), &state.configuration);
                let mut feet = [FootPhase::Stance; 2];
                feet[1 - stance] = foot_phase(section);
                let part =
                    PrimitivePart::HalfSwing { stance, section, landing: section == LANDING };
                let swing = LevelSole::of(leg, &state.world_from_soles[1 - stance]);
                self.is_valid(&mode, &kinematic_state, feet)
                    && fitting.add(
                        &self.slices,
                        (self.robot(), &kinematic_state),
                        level_soles,
                        &swing,
                        part,
                    )
            })
        })
    }

    /// Whether the shift of a pair meets every constraint; adds its volume to `fitting`.
    fn shift_holds(
        &self,
        gait: &Gait,
        footholds: &[Foothold; 2],
        level_soles: &[LevelSole; 2],
        fitting: &mut ExpandedBuilder,
    ) -> bool {
        let robot = self.robot();
        let mode = double_mode(&footholds[0], &footholds[1]);
        let over = |limb: usize| configuration(robot, gait, &footholds[limb], &footholds[1 - limb]);
        let (Ok(left), Ok(right)) = (over(0), over(1)) else { return false };
        let mut seed: ModeState = left;
        (0..=SHIFT_SAMPLES).all(|sample| {
            let fraction = sample as f64 / SHIFT_SAMPLES as f64;
            let moved = shift_at(&left.configuration, &right.configuration, fraction, &seed);
            let Ok(state) = with_legs(robot, moved) else { return false };
            seed = state;
            let kinematic_state = KinematicState::new(robot, &state.configuration);
            self.is_valid(&mode, &kinematic_state, [FootPhase::Stance; 2])
                && fitting.add(
                    &self.slices,
                    (robot, &kinematic_state),
                    level_soles,
                    &level_soles[0],
                    PrimitivePart::Shift { fraction },
                )
        })
    }

    /// Whether a state meets every constraint, with the additional balance margin.
    fn is_valid(
        &self,
        mode: &Mode,
        kinematic_state: &KinematicState,
        feet: [FootPhase; 2],
    ) -> bool {
        mode.region.margin(kinematic_state.com.truncate())
            >= self.constraints.com_margin(mode) + BALANCE_SLACK
            && self.constraints.check(mode, kinematic_state, feet).is_ok()
    }
}

/// A robot's constraints in an empty world.
///
/// # Errors
/// The planner cannot move the robot.
pub(crate) fn constraints_in_empty_world(
    model: &RobotModel,
    config: PlannerConfig,
) -> Result<Constraints, BuildError> {
    let robot = Mechanism::new(model, &config)?;
    let world = World { mu: 1.0, shapes: vec![], digest: Digest::default() };
    let collision = CollisionModel::new(model, &world, config.clearance)?;
    Ok(Constraints::new(robot, collision, config))
}

/// Number of joints of a leg whose positions follow from its sole's pose. With more joints a
/// neutral configuration is not unique.
const UNIQUE_JOINTS: usize = 6;
/// Height of the bottom of a foot's box above the ground, m: the clearance of a foot that lifts off
/// begins there.
const SOLE_GAP: f64 = 0.0005;

/// The part of the robot that a link belongs to.
fn robot_part_of(
    model: &RobotModel,
    robot: &Mechanism,
    collision: &CollisionModel,
    link: usize,
) -> RobotPart {
    if let Some(limb) = collision.foot_of(link) {
        return RobotPart::Foot(limb);
    }
    let chain = model.chain(link);
    let in_leg =
        |limb: usize| robot.legs[limb].joints().iter().any(|joint| chain.contains(&joint.index));
    match (in_leg(0), in_leg(1)) {
        (true, false) => RobotPart::Leg(0),
        (false, true) => RobotPart::Leg(1),
        _ => RobotPart::Trunk,
    }
}

/// The rotations of both soles in the world: level, or inclined by `tilt` (rad) in random
/// directions that depend on the vertex.
fn inclinations(level_soles: &[LevelSole; 2], tilt: f64, vertex: Option<u64>) -> [glam::DQuat; 2] {
    [0, 1].map(|limb| {
        let level = rotation_about(DVec3::Z, level_soles[limb].yaw);
        let Some(vertex) = vertex else { return level };
        let direction = Random::new(0, Stream::Preparation, limb as u64 | 1 << 32, vertex)
            .uniform(-std::f64::consts::PI, std::f64::consts::PI);
        let axis = DVec3::new(libm::cos(direction), libm::sin(direction), 0.0);
        rotation_about(axis, tilt) * level
    })
}
