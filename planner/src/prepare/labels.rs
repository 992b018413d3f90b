//! The labels of equation 3.1, as far as they follow from the robot and the world's geometry
//! [Grey 3.1, 4.1].

use glam::{DVec2, DVec3};
use surefoot_shared_types::Pose;

use super::Preparation;
use super::expanded::{mean_heading, split_height};
use crate::body::Body;
use crate::collision::CollisionModel;
use crate::collision::bvh::Aabb;
use crate::motion::primitive::gait::SPLIT;
use crate::motion::primitive::stand::{Stand, side_of};
use crate::region::Region;

/// What C_N says of a pose of the root.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Necessary {
    /// Whether what is rigid with the root meets nothing.
    pub has_room: bool,
    /// By limb: whether anything of the world lies where the sole may be.
    pub may_stand: [bool; 2],
}

impl Necessary {
    /// Whether the robot can be there at all: with room, and on one foot at least.
    pub fn holds(&self) -> bool {
        self.has_room && self.may_stand.contains(&true)
    }
}

/// C_N of a pose of the root: `holds() == false` is certain, whatever the joints
/// [Grey 4.1.1, 4.2.1].
pub fn necessary(
    preparation: &Preparation<'_>,
    body: &Body,
    collision: &CollisionModel,
    world_from_root: &Pose,
) -> Necessary {
    let has_room = collision.root_hit(world_from_root).is_none();
    let may_stand = [0, 1]
        .map(|limb| has_room && may_stand(preparation, body, collision, world_from_root, limb));
    Necessary { has_room, may_stand }
}

/// Whether anything of the world lies where a leg's sole may be.
pub fn may_stand(
    preparation: &Preparation<'_>,
    body: &Body,
    collision: &CollisionModel,
    world_from_root: &Pose,
    limb: usize,
) -> bool {
    let sole_radius =
        body.sole_polygons[limb].iter().map(|vertex| vertex.length()).fold(0.0, f64::max);
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

/// A sole may be this far above what carries it, m.
const CONTACT_GAP: f64 = 0.005;

/// A foot on a placement, as C_S sees it.
#[derive(Debug, Clone, Copy)]
pub struct Print {
    /// Which foot.
    pub limb: usize,
    /// Where its sole is.
    pub world_from_sole: Pose,
    /// Whether the whole sole is carried, as on flat ground.
    pub is_whole: bool,
}

/// Whether a support polygon reaches every corner of the sole.
pub fn is_whole(body: &Body, limb: usize, support: &[DVec2]) -> bool {
    let support = Region::hull(support.iter().copied());
    body.sole_polygons[limb].iter().all(|&corner| support.margin(corner) >= -WHOLE_TOLERANCE)
}

/// How much of a sole's rim may be unsupported where the sole still counts as whole, m.
const WHOLE_TOLERANCE: f64 = 2e-3;

/// C_S of a transition: both primitives between the foot `stance` alone and the pair exist and meet
/// nothing of the world [Grey 4.1.1, 4.4.5].
pub fn sufficient(
    preparation: &Preparation<'_>,
    body: &Body,
    collision: &CollisionModel,
    stance: &Print,
    other: &Print,
) -> bool {
    let stands =
        [stance, other].map(|print| Stand::of(&body.legs[print.limb], &print.world_from_sole));
    are_prints_good(preparation, &[stance, other], &stands)
        && preparation.range(stance.limb).contains(&stands[0].offset_to(&stands[1], other.limb))
        && Room { preparation, collision }.has_place([stance, other], &stands)
}

/// C_S of everything that primitives do on two placements, the left one first: both transitions,
/// and the shift between them.
pub fn sufficient_pair(
    preparation: &Preparation<'_>,
    body: &Body,
    collision: &CollisionModel,
    [left, right]: [&Print; 2],
) -> bool {
    let stands =
        [left, right].map(|print| Stand::of(&body.legs[print.limb], &print.world_from_sole));
    let turned = [stands[1], stands[0]];
    let room = Room { preparation, collision };
    are_prints_good(preparation, &[left, right], &stands)
        && preparation.range(0).contains(&stands[0].offset_to(&stands[1], 1))
        && preparation.range(1).contains(&stands[1].offset_to(&stands[0], 0))
        && room.have_columns([left, right], &stands)
        && room.has_way([left, right], &stands)
        && room.has_way([right, left], &turned)
        && room.has_way_between(&stands)
}

/// C_S of the shift between a transition and its twin.
pub fn sufficient_shift(
    preparation: &Preparation<'_>,
    body: &Body,
    collision: &CollisionModel,
    left: &Print,
    right: &Print,
) -> bool {
    let stands =
        [left, right].map(|print| Stand::of(&body.legs[print.limb], &print.world_from_sole));
    are_prints_good(preparation, &[left, right], &stands)
        && preparation.range(0).contains(&stands[0].offset_to(&stands[1], 1))
        && preparation.range(1).contains(&stands[1].offset_to(&stands[0], 0))
        && Room { preparation, collision }.has_shift([left, right], &stands)
}

fn are_prints_good(
    preparation: &Preparation<'_>,
    prints: &[&Print; 2],
    stands: &[Stand; 2],
) -> bool {
    let are_whole = prints.iter().all(|print| print.is_whole);
    prints[0].limb != prints[1].limb
        && are_whole
        && stands.iter().all(|stand| stand.tilt <= preparation.gait().tilt)
}

/// The expanded geometry in a world.
struct Room<'a> {
    preparation: &'a Preparation<'a>,
    collision: &'a CollisionModel,
}

impl Room<'_> {
    /// Whether the boxes of a place are free; the stance foot first.
    fn has_place(&self, prints: [&Print; 2], stands: &[Stand; 2]) -> bool {
        self.have_columns(prints, stands) && self.has_way(prints, stands)
    }

    /// Whether the boxes of a place are free beside those of both feet and legs; the stance foot
    /// first.
    fn has_way(&self, prints: [&Print; 2], stands: &[Stand; 2]) -> bool {
        let expanded = self.preparation.expanded();
        let split = split_height(stands);
        let (stance, limb) = (prints[0].limb, prints[1].limb);
        let stance_frame = stands[0].world_from_stand();
        let at_split = Pose::from_parts(
            stance_frame.translation.truncate().extend(split),
            stance_frame.rotation,
        );
        let neutral = DVec3::new(0.0, side_of(limb) * self.preparation.gait().width, 0.0);
        let target = (stance_frame.inverse() * stands[1].origin).truncate().extend(0.0);
        let mut rising = expanded.neutrals[stance].aabb();
        (rising.min.z, rising.max.z) = (stands[0].origin.z + SPLIT - split, 0.0);
        self.is_free(&at_split, &rising)
            && self.is_free(&at_split, &expanded.bodies[stance].aabb().risen())
            && self
                .is_free(&at_split, &expanded.swings[stance].aabb().risen().along(neutral, target))
    }

    /// Whether the boxes of a shift are free; the left foot first.
    fn has_shift(&self, prints: [&Print; 2], stands: &[Stand; 2]) -> bool {
        self.have_columns(prints, stands) && self.has_way_between(stands)
    }

    /// Whether the box of a shift is free beside those of both feet and legs; the left foot first.
    fn has_way_between(&self, stands: &[Stand; 2]) -> bool {
        let split = split_height(stands);
        let middle = Stand {
            origin: stands[0].origin.midpoint(stands[1].origin).truncate().extend(split),
            yaw: mean_heading(stands),
            tilt: 0.0,
        };
        let frame = middle.world_from_stand();
        let [from, to] = [0, 1]
            .map(|limb: usize| (frame.inverse() * stands[limb].origin).truncate().extend(0.0));
        self.is_free(&frame, &self.preparation.expanded().shift.aabb().risen().along(from, to))
    }

    /// Whether both feet and the columns about both legs are free.
    fn have_columns(&self, prints: [&Print; 2], stands: &[Stand; 2]) -> bool {
        let expanded = self.preparation.expanded();
        let split = split_height(stands);
        prints.iter().zip(stands).all(|(print, stand)| {
            let mut column = expanded.columns[print.limb].aabb();
            column.max.z = split - stand.origin.z;
            self.is_free(&print.world_from_sole, &expanded.soles[print.limb].aabb())
                && self.is_free(&stand.world_from_stand(), &column)
        })
    }

    fn is_free(&self, world_from_frame: &Pose, bounds: &Aabb) -> bool {
        let half = bounds.half_extents();
        let is_empty = half.cmple(DVec3::ZERO).any();
        is_empty
            || self
                .collision
                .box_hit(&(*world_from_frame * Pose::from_translation(bounds.center())), half)
                .is_none()
    }
}

/// Boxes as C_S moves them.
trait Stretched {
    /// The box with its bottom at height 0.
    fn risen(self) -> Self;
    /// The box around this one at both places.
    fn along(self, from: DVec3, to: DVec3) -> Self;
}

impl Stretched for Aabb {
    fn risen(mut self) -> Self {
        self.min.z = 0.0;
        self
    }

    fn along(self, from: DVec3, to: DVec3) -> Self {
        let at = |by: DVec3| Self { min: self.min + by, max: self.max + by };
        at(from).union(at(to))
    }
}
