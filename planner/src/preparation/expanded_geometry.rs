//! The expanded geometry of C_S [Grey 4.1.1, 4.4.5]: boxes around a pair of placements that contain
//! the robot throughout all primitives of the pair. A sweep of those primitives sizes them.
//!
//! The lowest box of each foot turns with its ankle; all others stay upright and turn with the
//! heading. A height, the split, divides them: `SPLIT` above the higher placement. Below it are a
//! column around each leg and one beside the stance foot, in which the swing foot rises. Above it
//! are the box of the upper body and the corridor of the swing leg. So obstacles between the
//! placements up to the height `SPLIT` do not matter.

use bytemuck::{Pod, Zeroable};
use glam::{DMat3, DVec3};
use surefoot_shared_types::Pose;
use surefoot_shared_types::base::spatial::wrap_angle;

use crate::geometry::bvh::Aabb;
use crate::preparation::shape_slices::{RobotPart, Slice};
use crate::primitives::gait::SPLIT;
use crate::primitives::level_sole::LevelSole;
use crate::primitives::step_path::ACROSS;
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::Mechanism;

/// A box in some frame, as plain data. A box whose `min` exceeds its `max` is empty.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Bounds {
    /// Lowest corner, m.
    pub min: [f64; 3],
    /// Highest corner, m.
    pub max: [f64; 3],
}

/// The boxes. Where a height is relative to the split, the split is their bottom or top.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ExpandedGeometry {
    /// By limb: the foot in its sole's frame, from the ground to the top of its lift.
    pub soles: [Bounds; 2],
    /// By limb: the column around a leg, in the frame of the foot's level sole. Its top is the
    /// split.
    pub columns: [Bounds; 2],
    /// By stance limb: the column in which the other foot rises, in the frame of the stance foot's
    /// level sole.
    pub neutrals: [Bounds; 2],
    /// By stance limb: trunk, arms and stance leg, in the frame of the stance foot's level sole;
    /// heights from the split.
    pub bodies: [Bounds; 2],
    /// By stance limb: the swing leg, at the swing foot's level sole along the stance foot's
    /// heading; heights from the split.
    pub swings: [Bounds; 2],
    /// The robot during a shift, at the point between both level soles along their mean heading;
    /// heights from the split.
    pub shift: Bounds,
}

/// The part of a primitive to which a configuration belongs.
#[derive(Debug, Clone, Copy)]
pub(crate) enum PrimitivePart {
    /// A section of a half swing over a stance foot.
    HalfSwing {
        /// The stance foot.
        stance: usize,
        /// The section.
        section: usize,
        /// Whether the swing foot is within its sole box.
        landing: bool,
    },
    /// A fraction of a shift from the left to the right foot.
    Shift {
        /// The fraction.
        fraction: f64,
    },
}

/// Boxes that grow around configurations.
#[derive(Debug, Clone, Copy)]
pub(crate) struct ExpandedBuilder {
    /// The least height of a leg above the level of its sole, m.
    floor: f64,
    columns: [Aabb; 2],
    neutrals: [Aabb; 2],
    bodies: [Aabb; 2],
    swings: [Aabb; 2],
    shift: Aabb,
}

impl ExpandedBuilder {
    /// Empty boxes, for legs that stay `floor` (m) above the level of their soles.
    pub const fn empty(floor: f64) -> Self {
        let pair = [Aabb::EMPTY; 2];
        Self {
            floor,
            columns: pair,
            neutrals: pair,
            bodies: pair,
            swings: pair,
            shift: Aabb::EMPTY,
        }
    }

    /// The boxes around those of both builders.
    pub fn union(&self, other: &Self) -> Self {
        let both = |a: &[Aabb; 2], b: &[Aabb; 2]| [a[0].union(b[0]), a[1].union(b[1])];
        Self {
            floor: self.floor,
            columns: both(&self.columns, &other.columns),
            neutrals: both(&self.neutrals, &other.neutrals),
            bodies: both(&self.bodies, &other.bodies),
            swings: both(&self.swings, &other.swings),
            shift: self.shift.union(other.shift),
        }
    }

    /// Grows the boxes around a configuration of a primitive over two level soles, by limb. `swing`
    /// is the level sole of the swing foot. Returns `false` if a part of the robot outside the
    /// columns is below the split, or a leg is too near to the ground.
    pub fn add(
        &mut self,
        slices: &[Slice],
        (robot, kinematic_state): (&Mechanism, &KinematicState),
        level_soles: &[LevelSole; 2],
        swing: &LevelSole,
        part: PrimitivePart,
    ) -> bool {
        let split = split_height(level_soles);
        let frames = Frames::new(level_soles, swing, part, split);
        slices.iter().all(|slice| {
            let world_from_slice =
                kinematic_state.world_from_link(robot, slice.link) * slice.link_from_slice;
            let within = |world_from_frame: &Pose| {
                bounds_in(world_from_frame, &world_from_slice, &slice.bounds)
            };
            let is_in_sole_box = |limb: usize| match part {
                PrimitivePart::HalfSwing { stance, landing, .. } => limb == stance || landing,
                PrimitivePart::Shift { .. } => true,
            };
            if matches!(slice.robot_part, RobotPart::Foot(limb) if is_in_sole_box(limb)) {
                return true;
            }
            let height = within(&Pose::IDENTITY);
            let fits_below = height.min.z >= split
                || self.add_below(slice.robot_part, level_soles, &frames, part, &within);
            if height.max.z > split {
                self.add_above(slice.robot_part, &frames, part, &within);
            }
            fits_below
        })
    }

    /// Grows the boxes below the split around a slice. Returns `false` if none may contain it.
    fn add_below(
        &mut self,
        robot_part: RobotPart,
        level_soles: &[LevelSole; 2],
        frames: &Frames,
        part: PrimitivePart,
        within: &impl Fn(&Pose) -> Aabb,
    ) -> bool {
        let limb = match robot_part {
            RobotPart::Trunk => return false,
            RobotPart::Leg(limb) | RobotPart::Foot(limb) => limb,
        };
        match part {
            PrimitivePart::HalfSwing { stance, section, .. }
                if limb != stance && section <= ACROSS =>
            {
                self.neutrals[stance] = self.neutrals[stance].union(within(&frames.about_stance));
                section < ACROSS
            }
            _ => {
                let column = within(&level_soles[limb].world_from_level_sole());
                self.columns[limb] = self.columns[limb].union(column);
                column.min.z >= self.floor
            }
        }
    }

    /// Grows the boxes above the split around a slice.
    fn add_above(
        &mut self,
        robot_part: RobotPart,
        frames: &Frames,
        part: PrimitivePart,
        within: &impl Fn(&Pose) -> Aabb,
    ) {
        match (part, robot_part) {
            (PrimitivePart::Shift { .. }, _) => {
                self.shift = self.shift.union(within(&frames.between))
            }
            (
                PrimitivePart::HalfSwing { stance, .. },
                RobotPart::Leg(limb) | RobotPart::Foot(limb),
            ) if limb != stance => {
                self.swings[stance] = self.swings[stance].union(within(&frames.about_swing));
            }
            (PrimitivePart::HalfSwing { stance, .. }, _) => {
                self.bodies[stance] = self.bodies[stance].union(within(&frames.about_stance))
            }
        }
    }

    /// The boxes with `margin` (m) around them. `soles` are the boxes of the feet.
    pub fn finish(&self, soles: [Aabb; 2], margin: f64) -> ExpandedGeometry {
        let grown = |bounds: &Aabb| {
            Bounds::of(&bounds.grown(if bounds.min.x <= bounds.max.x { margin } else { 0.0 }))
        };
        let both = |pair: &[Aabb; 2]| [grown(&pair[0]), grown(&pair[1])];
        let mut columns = both(&self.columns);
        for (column, sole) in columns.iter_mut().zip(&soles) {
            column.min[2] = column.min[2].max(sole.min.z);
        }
        ExpandedGeometry {
            soles: [Bounds::of(&soles[0]), Bounds::of(&soles[1])],
            columns,
            neutrals: both(&self.neutrals),
            bodies: both(&self.bodies),
            swings: both(&self.swings),
            shift: grown(&self.shift),
        }
    }
}

/// The frames in which the boxes are fitted, each at the height of the split.
struct Frames {
    about_stance: Pose,
    about_swing: Pose,
    between: Pose,
}

impl Frames {
    fn new(
        level_soles: &[LevelSole; 2],
        swing: &LevelSole,
        part: PrimitivePart,
        split: f64,
    ) -> Self {
        let at_split = |origin: DVec3, yaw: f64| {
            LevelSole { origin: origin.truncate().extend(split), yaw, tilt: 0.0 }
                .world_from_level_sole()
        };
        match part {
            PrimitivePart::HalfSwing { stance, .. } => {
                let about = &level_soles[stance];
                let about_stance = at_split(about.origin, about.yaw);
                Self {
                    about_stance,
                    about_swing: at_split(swing.origin, about.yaw),
                    between: about_stance,
                }
            }
            PrimitivePart::Shift { fraction } => {
                let between = at_split(
                    level_soles[0].origin.lerp(level_soles[1].origin, fraction),
                    mean_heading(level_soles),
                );
                Self { about_stance: between, about_swing: between, between }
            }
        }
    }
}

/// The mean heading of two level soles, rad.
pub fn mean_heading(level_soles: &[LevelSole; 2]) -> f64 {
    level_soles[0].yaw + 0.5 * wrap_angle(level_soles[1].yaw - level_soles[0].yaw)
}

/// The height of the split in the world, m.
pub fn split_height(level_soles: &[LevelSole; 2]) -> f64 {
    level_soles[0].origin.z.max(level_soles[1].origin.z) + SPLIT
}

impl Bounds {
    /// A box as plain data.
    pub fn of(bounds: &Aabb) -> Self {
        Self { min: bounds.min.into(), max: bounds.max.into() }
    }

    /// The box.
    pub fn aabb(&self) -> Aabb {
        Aabb { min: self.min.into(), max: self.max.into() }
    }
}

/// The box around a box, in another frame.
fn bounds_in(world_from_frame: &Pose, world_from_box: &Pose, bounds: &Aabb) -> Aabb {
    let frame_from_box = world_from_frame.inv_mul(world_from_box);
    bounds.transformed(&DMat3::from_quat(frame_from_box.rotation), frame_from_box.translation)
}
