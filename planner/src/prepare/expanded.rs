//! The expanded geometry of C_S [Grey 4.1.1, 4.4.5]: boxes about a pair of placements that hold the
//! robot through all primitives of the pair. They are sized by sweeping those primitives.
//!
//! The lowest box of each foot turns with its ankle; all others stay upright and turn with the
//! heading. They divide space by height. Up to `SPLIT` above the higher placement there is only a
//! column about each leg, and one beside the stance foot where the swing foot rises; above it there
//! is the room of the body and the corridor of the swing leg. So whatever lies between the
//! placements, up to `SPLIT`, does not matter.

use bytemuck::{Pod, Zeroable};
use glam::{DMat3, DVec3};
use surefoot_shared_types::Pose;

use super::slices::{Owner, Slice};
use crate::body::Body;
use crate::collision::bvh::Aabb;
use crate::motion::primitive::gait::SPLIT;
use crate::motion::primitive::path::ACROSS;
use crate::motion::primitive::stand::Stand;
use crate::snapshot::Snapshot;

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
pub struct Expanded {
    /// By limb: the foot in its sole's frame, from the ground to the top of its lift.
    pub soles: [Bounds; 2],
    /// By limb: the column about a leg, in the frame of the foot's stand. Its top is the split.
    pub columns: [Bounds; 2],
    /// By stance limb: the column in which the other foot rises, in the frame of the stance foot's
    /// stand.
    pub neutrals: [Bounds; 2],
    /// By stance limb: trunk, arms and stance leg, in the frame of the stance foot's stand; heights
    /// from the split.
    pub bodies: [Bounds; 2],
    /// By stance limb: the swing leg, about the swing foot's stand along the stance foot's heading;
    /// heights from the split.
    pub swings: [Bounds; 2],
    /// Everything during a shift, about the line between both stands along their mean heading;
    /// heights from the split.
    pub shift: Bounds,
}

/// What a primitive does while the boxes are fitted around it.
#[derive(Debug, Clone, Copy)]
pub enum Phase {
    /// A stretch of a place over the foot `stance`; `landing` where the swing foot is in its sole
    /// box.
    Place {
        /// The foot that carries.
        stance: usize,
        /// The stretch.
        stretch: usize,
        /// Whether the swing foot is within its sole box.
        landing: bool,
    },
    /// A share of a shift from the left to the right foot.
    Shift {
        /// The share.
        share: f64,
    },
}

/// Boxes that grow around what they are shown.
#[derive(Debug, Clone, Copy)]
pub struct Fitting {
    /// How far a leg stays above the level of its sole, m.
    floor: f64,
    columns: [Aabb; 2],
    neutrals: [Aabb; 2],
    bodies: [Aabb; 2],
    swings: [Aabb; 2],
    shift: Aabb,
}

impl Fitting {
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

    /// Grows around a configuration of a primitive over two stands, by limb; `swing` is where the
    /// swing foot is. `false` where something is below the split that belongs to no column, or a
    /// leg too near to the ground.
    pub fn add(
        &mut self,
        slices: &[Slice],
        (body, snapshot): (&Body, &Snapshot),
        stands: &[Stand; 2],
        swing: &Stand,
        phase: Phase,
    ) -> bool {
        let split = split_height(stands);
        let frames = Frames::new(stands, swing, phase, split);
        slices.iter().all(|slice| {
            let world_from_slice =
                body.world_from_link(snapshot, slice.link) * slice.link_from_slice;
            let within = |world_from_frame: &Pose| {
                bounds_in(world_from_frame, &world_from_slice, &slice.bounds)
            };
            let rests = |limb: usize| match phase {
                Phase::Place { stance, landing, .. } => limb == stance || landing,
                Phase::Shift { .. } => true,
            };
            if matches!(slice.owner, Owner::Foot(limb) if rests(limb)) {
                return true;
            }
            let height = within(&Pose::IDENTITY);
            let held_below = height.min.z >= split
                || self.add_below(slice.owner, stands, &frames, phase, &within);
            if height.max.z > split {
                self.add_above(slice.owner, &frames, phase, &within);
            }
            held_below
        })
    }

    fn add_below(
        &mut self,
        owner: Owner,
        stands: &[Stand; 2],
        frames: &Frames,
        phase: Phase,
        within: &impl Fn(&Pose) -> Aabb,
    ) -> bool {
        let limb = match owner {
            Owner::Trunk => return false,
            Owner::Leg(limb) | Owner::Foot(limb) => limb,
        };
        match phase {
            Phase::Place { stance, stretch, .. } if limb != stance && stretch <= ACROSS => {
                self.neutrals[stance] = self.neutrals[stance].union(within(&frames.about_stance));
                stretch < ACROSS
            }
            _ => {
                let column = within(&stands[limb].world_from_stand());
                self.columns[limb] = self.columns[limb].union(column);
                column.min.z >= self.floor
            }
        }
    }

    fn add_above(
        &mut self,
        owner: Owner,
        frames: &Frames,
        phase: Phase,
        within: &impl Fn(&Pose) -> Aabb,
    ) {
        match (phase, owner) {
            (Phase::Shift { .. }, _) => self.shift = self.shift.union(within(&frames.between)),
            (Phase::Place { stance, .. }, Owner::Leg(limb) | Owner::Foot(limb))
                if limb != stance =>
            {
                self.swings[stance] = self.swings[stance].union(within(&frames.about_swing));
            }
            (Phase::Place { stance, .. }, _) => {
                self.bodies[stance] = self.bodies[stance].union(within(&frames.about_stance))
            }
        }
    }

    /// The boxes with `margin` (m) around them; `soles` are those of the feet.
    pub fn finish(&self, soles: [Aabb; 2], margin: f64) -> Expanded {
        let grown = |bounds: &Aabb| {
            Bounds::of(&bounds.grown(if bounds.min.x <= bounds.max.x { margin } else { 0.0 }))
        };
        let both = |pair: &[Aabb; 2]| [grown(&pair[0]), grown(&pair[1])];
        let mut columns = both(&self.columns);
        for (column, sole) in columns.iter_mut().zip(&soles) {
            column.min[2] = column.min[2].max(sole.min.z);
        }
        Expanded {
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
    fn new(stands: &[Stand; 2], swing: &Stand, phase: Phase, split: f64) -> Self {
        let at_split = |origin: DVec3, yaw: f64| {
            Stand { origin: origin.truncate().extend(split), yaw, tilt: 0.0 }.world_from_stand()
        };
        match phase {
            Phase::Place { stance, .. } => {
                let about = &stands[stance];
                let about_stance = at_split(about.origin, about.yaw);
                Self {
                    about_stance,
                    about_swing: at_split(swing.origin, about.yaw),
                    between: about_stance,
                }
            }
            Phase::Shift { share } => {
                let between =
                    at_split(stands[0].origin.lerp(stands[1].origin, share), mean_heading(stands));
                Self { about_stance: between, about_swing: between, between }
            }
        }
    }
}

/// The heading halfway between two stands, rad.
pub fn mean_heading(stands: &[Stand; 2]) -> f64 {
    stands[0].yaw + 0.5 * surefoot_shared_types::spatial::wrap_angle(stands[1].yaw - stands[0].yaw)
}

/// The height above which the boxes of body and swing leg begin, m.
pub fn split_height(stands: &[Stand; 2]) -> f64 {
    stands[0].origin.z.max(stands[1].origin.z) + SPLIT
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
