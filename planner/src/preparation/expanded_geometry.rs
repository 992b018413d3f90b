//! The expanded geometry of C_S [Grey 4.1.1, 4.4.5]: boxes about a pair of placements that hold the
//! robot through all primitives of the pair. They are sized by sweeping those primitives.
//!
//! The lowest box of each foot turns with its ankle; all others stay upright and turn with the
//! heading. They divide space by height. Up to `SPLIT` above the higher placement there is only a
//! column about each leg, and one beside the stance foot where the swing foot rises; above it there
//! are the box of the body and the corridor of the swing leg. So whatever lies between the
//! placements, up to `SPLIT`, does not matter.

use bytemuck::{Pod, Zeroable};
use glam::{DMat3, DVec3};
use surefoot_shared_types::Pose;

use crate::geometry::bvh::Aabb;
use crate::preparation::shape_slices::{RobotPart, Slice};
use crate::primitives::gait::SPLIT;
use crate::primitives::level_sole::LevelSole;
use crate::primitives::step_path::ACROSS;
use crate::robot::kinematic_state::KinematicState;
use crate::robot::mechanism::Mechanism;

/// A box in some frame, as plain data. One whose `min` is above its `max` is empty.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Bounds {
    /// Lowest corner, m.
    pub min: [f64; 3],
    /// Highest corner, m.
    pub max: [f64; 3],
}

/// The boxes. Their heights begin where the split is; what is stored are their other sides.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct ExpandedGeometry {
    /// By limb: the foot in its sole's frame, from the ground to the top of its lift.
    pub soles: [Bounds; 2],
    /// By limb: the column about a leg, in the frame of the foot's level sole. Its top is the
    /// split.
    pub columns: [Bounds; 2],
    /// By stance limb: the column in which the other foot rises, in the frame of the stance foot's
    /// level sole.
    pub neutrals: [Bounds; 2],
    /// By stance limb: trunk, arms and stance leg, in the frame of the stance foot's level sole;
    /// heights from the split.
    pub bodies: [Bounds; 2],
    /// By stance limb: the swing leg, about the swing foot's level sole along the stance foot's
    /// heading; heights from the split.
    pub swings: [Bounds; 2],
    /// Everything during a shift, about the line between both level soles along their mean heading;
    /// heights from the split.
    pub shift: Bounds,
}

/// Part of a primitive to which a configuration belongs.
#[derive(Debug, Clone, Copy)]
pub enum PrimitivePart {
    /// A section of a half swing over the foot `stance`; `landing` if the swing foot is in its sole
    /// box.
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
pub struct ExpandedBuilder {
    /// How far a leg stays above the level of its sole, m.
    floor: f64,
    columns: [Aabb; 2],
    neutrals: [Aabb; 2],
    bodies: [Aabb; 2],
    swings: [Aabb; 2],
    shift: Aabb,
}

impl ExpandedBuilder {
    /// Boxes around nothing, for legs that stay `floor` (m) above the level of their soles.
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

    /// The boxes around both.
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

    /// Grows around a configuration of a primitive over two level soles, by limb; `swing` is where
    /// the swing foot is. `false` where something is below the split that belongs to no column, or
    /// a leg too near to the ground.
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
            let rests = |limb: usize| match part {
                PrimitivePart::HalfSwing { stance, landing, .. } => limb == stance || landing,
                PrimitivePart::Shift { .. } => true,
            };
            if matches!(slice.robot_part, RobotPart::Foot(limb) if rests(limb)) {
                return true;
            }
            let height = within(&Pose::IDENTITY);
            let held_below = height.min.z >= split
                || self.add_below(slice.robot_part, level_soles, &frames, part, &within);
            if height.max.z > split {
                self.add_above(slice.robot_part, &frames, part, &within);
            }
            held_below
        })
    }

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

    /// The boxes with `margin` (m) around them; `soles` are those of the feet.
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

/// The heading halfway between two level soles, rad.
pub fn mean_heading(level_soles: &[LevelSole; 2]) -> f64 {
    level_soles[0].yaw
        + 0.5
            * surefoot_shared_types::base::spatial::wrap_angle(
                level_soles[1].yaw - level_soles[0].yaw,
            )
}

/// The height above which the boxes of body and swing leg begin, m.
pub fn split_height(level_soles: &[LevelSole; 2]) -> f64 {
    level_soles[0].origin.z.max(level_soles[1].origin.z) + SPLIT
}

impl Bounds {
    /// The same box.
    pub fn of(bounds: &Aabb) -> Self {
        Self { min: bounds.min.into(), max: bounds.max.into() }
    }

    /// The same box.
    pub fn aabb(&self) -> Aabb {
        Aabb { min: self.min.into(), max: self.max.into() }
    }
}

/// The box around a box, in another frame.
fn bounds_in(world_from_frame: &Pose, world_from_box: &Pose, bounds: &Aabb) -> Aabb {
    let frame_from_box = world_from_frame.inv_mul(world_from_box);
    bounds.transformed(&DMat3::from_quat(frame_from_box.rotation), frame_from_box.translation)
}
