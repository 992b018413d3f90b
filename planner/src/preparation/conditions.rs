//! The conditions C_N and C_S of equation 3.1, from the preparation and the world's geometry
//! [Grey 3.1, 4.1].

use glam::DVec3;
use surefoot_shared_types::Pose;

use crate::collision::model::CollisionModel;
use crate::constraints::foothold::FootPlacement;
use crate::geometry::bvh::Aabb;
use crate::preparation::data::Preparation;
use crate::preparation::expanded_geometry::{mean_heading, split_height};
use crate::primitives::gait::SPLIT;
use crate::primitives::level_sole::{LevelSole, side_of};
use crate::robot::mechanism::Mechanism;

/// C_N of a root pose.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Necessary {
    /// Whether the links fixed to the root are free of collisions.
    pub is_root_free: bool,
    /// By limb: whether any part of the world lies where the sole may be.
    pub may_stand: [bool; 2],
}

impl Necessary {
    /// Whether the root is free and at least one foot may stand.
    pub fn holds(&self) -> bool {
        self.is_root_free && self.may_stand.contains(&true)
    }
}

/// C_N of a pose of the root. `holds() == false` is certain for all joint positions
/// [Grey 4.1.1, 4.2.1].
pub fn necessary(
    preparation: &Preparation,
    robot: &Mechanism,
    collision: &CollisionModel,
    world_from_root: &Pose,
) -> Necessary {
    let is_root_free = collision.root_hit(world_from_root).is_none();
    let may_stand = [0, 1].map(|limb| {
        is_root_free && may_stand(preparation, robot, collision, world_from_root, limb)
    });
    Necessary { is_root_free, may_stand }
}

/// Whether any part of the world lies where a leg's sole may be.
pub fn may_stand(
    preparation: &Preparation,
    robot: &Mechanism,
    collision: &CollisionModel,
    world_from_root: &Pose,
    limb: usize,
) -> bool {
    let sole_radius =
        robot.soles[limb].polygon.iter().map(|vertex| vertex.length()).fold(0.0, f64::max);
    preparation.reach(limb).blocks().iter().any(|block| {
        let world_from_block = *world_from_root * Pose::from_translation(block.center.into());
        collision
            .box_hit(
                &world_from_block,
                DVec3::from(block.half_extents) + DVec3::splat(sole_radius + CONTACT_GAP),
            )
            .is_some()
    })
}

/// Largest gap between a sole and the surface that supports it, m.
const CONTACT_GAP: f64 = 0.005;

/// C_S of a transition: both primitives between the foot `stance` alone and the pair exist and
/// collide with nothing of the world [Grey 4.1.1, 4.4.5].
pub fn sufficient(
    preparation: &Preparation,
    robot: &Mechanism,
    collision: &CollisionModel,
    stance: &FootPlacement,
    other: &FootPlacement,
) -> bool {
    let level_soles = level_soles_of(robot, [stance, other]);
    are_placements_valid(preparation, &[stance, other], &level_soles)
        && preparation
            .range(stance.limb)
            .contains(&level_soles[0].offset_to(&level_soles[1], other.limb))
        && ExpandedTest { preparation, collision }.is_half_swing_free([stance, other], &level_soles)
}

/// C_S of all primitives on two placements, the left one first: both transitions and the shift
/// between them.
pub fn sufficient_pair(
    preparation: &Preparation,
    robot: &Mechanism,
    collision: &CollisionModel,
    [left, right]: [&FootPlacement; 2],
) -> bool {
    let level_soles = level_soles_of(robot, [left, right]);
    let swapped = [level_soles[1], level_soles[0]];
    let test = ExpandedTest { preparation, collision };
    are_placements_valid(preparation, &[left, right], &level_soles)
        && is_in_both_ranges(preparation, &level_soles)
        && test.are_columns_free([left, right], &level_soles)
        && test.are_swing_boxes_free([left, right], &level_soles)
        && test.are_swing_boxes_free([right, left], &swapped)
        && test.is_shift_box_free(&level_soles)
}

/// C_S of the shift between a transition and its twin.
pub fn sufficient_shift(
    preparation: &Preparation,
    robot: &Mechanism,
    collision: &CollisionModel,
    left: &FootPlacement,
    right: &FootPlacement,
) -> bool {
    let level_soles = level_soles_of(robot, [left, right]);
    are_placements_valid(preparation, &[left, right], &level_soles)
        && is_in_both_ranges(preparation, &level_soles)
        && ExpandedTest { preparation, collision }.is_shift_free([left, right], &level_soles)
}

/// The level soles of two placements.
fn level_soles_of(robot: &Mechanism, placements: [&FootPlacement; 2]) -> [LevelSole; 2] {
    placements
        .map(|placement| LevelSole::of(&robot.legs[placement.limb], &placement.world_from_sole))
}

/// Whether a pair of level soles, the left one first, is in R_S with either foot as stance.
fn is_in_both_ranges(preparation: &Preparation, [left, right]: &[LevelSole; 2]) -> bool {
    preparation.range(0).contains(&left.offset_to(right, 1))
        && preparation.range(1).contains(&right.offset_to(left, 0))
}

/// Whether two placements are of different feet, wholly supported and no steeper than primitives
/// allow.
fn are_placements_valid(
    preparation: &Preparation,
    placements: &[&FootPlacement; 2],
    level_soles: &[LevelSole; 2],
) -> bool {
    let are_whole = placements.iter().all(|placement| placement.is_whole);
    placements[0].limb != placements[1].limb
        && are_whole
        && level_soles.iter().all(|level_sole| level_sole.tilt <= preparation.gait().tilt)
}

/// Collision tests of the expanded geometry in a world.
struct ExpandedTest<'a> {
    preparation: &'a Preparation,
    collision: &'a CollisionModel,
}

impl ExpandedTest<'_> {
    /// Whether the boxes of a half swing are free; the stance foot first.
    fn is_half_swing_free(
        &self,
        placements: [&FootPlacement; 2],
        level_soles: &[LevelSole; 2],
    ) -> bool {
        self.are_columns_free(placements, level_soles)
            && self.are_swing_boxes_free(placements, level_soles)
    }

    /// Whether the boxes of a half swing, except those of both feet and legs, are free; the stance
    /// foot first.
    fn are_swing_boxes_free(
        &self,
        placements: [&FootPlacement; 2],
        level_soles: &[LevelSole; 2],
    ) -> bool {
        let expanded = self.preparation.expanded();
        let split = split_height(level_soles);
        let (stance, limb) = (placements[0].limb, placements[1].limb);
        let stance_frame = level_soles[0].world_from_level_sole();
        let at_split = Pose::from_parts(
            stance_frame.translation.truncate().extend(split),
            stance_frame.rotation,
        );
        let neutral = DVec3::new(0.0, side_of(limb) * self.preparation.gait().width, 0.0);
        let target = (stance_frame.inverse() * level_soles[1].origin).truncate().extend(0.0);
        let mut rising = expanded.neutrals[stance].aabb();
        (rising.min.z, rising.max.z) = (level_soles[0].origin.z + SPLIT - split, 0.0);
        self.is_box_free(&at_split, &rising)
            && self.is_box_free(&at_split, &expanded.bodies[stance].aabb().with_bottom_at_zero())
            && self.is_box_free(
                &at_split,
                &expanded.swings[stance].aabb().with_bottom_at_zero().swept(neutral, target),
            )
    }

    /// Whether the boxes of a shift are free; the left foot first.
    fn is_shift_free(&self, placements: [&FootPlacement; 2], level_soles: &[LevelSole; 2]) -> bool {
        self.are_columns_free(placements, level_soles) && self.is_shift_box_free(level_soles)
    }

    /// Whether the box of a shift, except those of both feet and legs, is free; the left foot
    /// first.
    fn is_shift_box_free(&self, level_soles: &[LevelSole; 2]) -> bool {
        let split = split_height(level_soles);
        let middle = LevelSole {
            origin: level_soles[0].origin.midpoint(level_soles[1].origin).truncate().extend(split),
            yaw: mean_heading(level_soles),
            tilt: 0.0,
        };
        let frame = middle.world_from_level_sole();
        let [from, to] = [0, 1]
            .map(|limb: usize| (frame.inverse() * level_soles[limb].origin).truncate().extend(0.0));
        self.is_box_free(
            &frame,
            &self.preparation.expanded().shift.aabb().with_bottom_at_zero().swept(from, to),
        )
    }

    /// Whether the boxes of both feet and the columns around both legs are free.
    fn are_columns_free(
        &self,
        placements: [&FootPlacement; 2],
        level_soles: &[LevelSole; 2],
    ) -> bool {
        let expanded = self.preparation.expanded();
        let split = split_height(level_soles);
        placements.iter().zip(level_soles).all(|(placement, level_sole)| {
            let mut column = expanded.columns[placement.limb].aabb();
            column.max.z = split - level_sole.origin.z;
            self.is_box_free(&placement.world_from_sole, &expanded.soles[placement.limb].aabb())
                && self.is_box_free(&level_sole.world_from_level_sole(), &column)
        })
    }

    /// Whether a box in a frame collides with nothing. An empty box is free.
    fn is_box_free(&self, world_from_frame: &Pose, bounds: &Aabb) -> bool {
        let half = bounds.half_extents();
        let is_empty = half.cmple(DVec3::ZERO).any();
        is_empty
            || self
                .collision
                .box_hit(&(*world_from_frame * Pose::from_translation(bounds.center())), half)
                .is_none()
    }
}

/// Boxes of the expanded geometry at their heights and positions.
trait MovedBox {
    /// The box with its bottom at height 0.
    fn with_bottom_at_zero(self) -> Self;
    /// The box around this one at two translations, m.
    fn swept(self, from: DVec3, to: DVec3) -> Self;
}

impl MovedBox for Aabb {
    fn with_bottom_at_zero(mut self) -> Self {
        self.min.z = 0.0;
        self
    }

    fn swept(self, from: DVec3, to: DVec3) -> Self {
        let at = |by: DVec3| Self { min: self.min + by, max: self.max + by };
        at(from).union(at(to))
    }
}
