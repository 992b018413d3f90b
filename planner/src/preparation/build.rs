//! What is made once per robot, from the robot alone [Grey 4.1.1, 4.2.1, 4.4.5]: the space R that
//! each leg may reach, the gait of the primitive trajectories with its range R_S of placement
//! pairs, the expanded geometry that holds them, and the step limits.
//!
//! [`build`] makes it, as words that can be written to a file; [`Preparation::from_bytes`] checks
//! such bytes and reads them in place. One robot and one set of margins give the same bytes on any
//! number of threads. [`necessary`] and [`sufficient`] evaluate C_N and C_S with it.

use crate::collision::error::CollisionError;
use crate::geometry::voxel_grid::VoxelGrid;
use crate::kinematics::Leg;
use crate::kinematics::leg::LegError;
use crate::preparation::expanded_geometry::ExpandedGeometry;
use crate::preparation::file_format::{Contents, PreparationError, Writer};
use crate::preparation::primitive_range::{Lattice, PairRange, RangeHeader};
use crate::preparation::primitive_sweep::{PrimitiveSweep, constraints_in_empty_world};
use crate::preparation::reachable_space::{ReachableSpace, ReachableSpaceHeader};
use crate::preparation::step_limits::StepLimits;
use crate::preparation::{file_format, gait_search, reach_sweep, reachable_space};
use crate::primitives::Gait;
use crate::robot::mechanism::MechanismError;
use std::sync::atomic::{AtomicU32, Ordering};

use glam::DVec3;
use rayon::prelude::*;
use surefoot_shared_types::base::digest::Digest;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::model::RobotModel;

pub(crate) use crate::preparation::file_format::key;

/// A robot that cannot be prepared.
#[derive(Debug, thiserror::Error)]
pub enum BuildError {
    /// The robot is none that the planner can move.
    #[error(transparent)]
    Mechanism(#[from] MechanismError),
    /// A shape of the robot cannot be compiled.
    #[error(transparent)]
    Collision(#[from] CollisionError),
    /// What was just made does not hold together.
    #[error("what was prepared for the robot {0}; please report this with the robot's files")]
    Unsound(#[from] PreparationError),
}

impl From<LegError> for BuildError {
    fn from(error: LegError) -> Self {
        Self::Mechanism(error.into())
    }
}

/// What was prepared for a robot, read in place.
#[derive(Debug, Clone, Copy)]
pub struct Preparation<'a> {
    key: Digest,
    contents: &'a Contents,
    reach: [ReachableSpace<'a>; 2],
    ranges: [PairRange<'a>; 2],
}

impl<'a> Preparation<'a> {
    /// Reads a preparation made from `key`, whose bytes begin at a multiple of eight.
    ///
    /// # Errors
    /// What is wrong with the bytes. All of them are checked before use.
    pub fn from_bytes(bytes: &'a [u8], key: &Digest) -> Result<Self, PreparationError> {
        let contents = &file_format::header(bytes, key)?.contents;
        let reach = |limb: usize| {
            let at: &ReachableSpaceHeader = &contents.reach[limb];
            ReachableSpace::new(
                at,
                file_format::array(bytes, at.bits)?,
                file_format::array(bytes, at.blocks)?,
            )
            .ok_or(PreparationError::Damaged)
        };
        let range = |limb: usize| {
            let at: &RangeHeader = &contents.ranges[limb];
            PairRange::new(at, file_format::array(bytes, at.bits)?).ok_or(PreparationError::Damaged)
        };
        if !contents.gait.is_sound() || !contents.step_limits.is_sound() {
            return Err(PreparationError::Damaged);
        }
        Ok(Self {
            key: *key,
            contents,
            reach: [reach(0)?, reach(1)?],
            ranges: [range(0)?, range(1)?],
        })
    }

    /// Whether this was made for a robot and the margins of a configuration.
    pub fn is_for(&self, model: &RobotModel, config: &PlannerConfig) -> bool {
        self.key == key(model, config)
    }

    /// Whether a leg may place its sole at a point of the root's frame, however turned. `false` is
    /// certain.
    pub fn may_reach(&self, limb: usize, root_from_sole: DVec3) -> bool {
        self.reach[limb].may_reach(root_from_sole)
    }

    /// The reachable space of a leg.
    pub fn reach(&self, limb: usize) -> &ReachableSpace<'a> {
        &self.reach[limb]
    }

    /// The shape of the primitives.
    pub fn gait(&self) -> &'a Gait {
        &self.contents.gait
    }

    /// R_S with `stance` as the foot that carries.
    pub fn range(&self, stance: usize) -> &PairRange<'a> {
        &self.ranges[stance]
    }

    /// The step limits.
    pub fn step_limits(&self) -> &'a StepLimits {
        &self.contents.step_limits
    }

    /// The volume that the primitives occupy.
    pub fn expanded(&self) -> &'a ExpandedGeometry {
        &self.contents.expanded
    }
}

/// Prepares a robot and keeps it in memory to the end of the process, without a cache.
///
/// # Errors
/// The robot is no biped that the planner can move.
pub fn make(
    model: &RobotModel,
    config: &PlannerConfig,
) -> Result<Preparation<'static>, BuildError> {
    let bytes: &'static [u8] = bytemuck::cast_slice(Vec::leak(build(model, config, &|_| ())?));
    Ok(Preparation::from_bytes(bytes, &key(model, config))?)
}

/// The share of the work that the reachable spaces are.
const REACH_SHARE: f64 = 0.5;

/// Prepares a robot; `progress` receives the fraction that is done, 0 to 1, from any thread.
///
/// # Errors
/// The robot is no biped that the planner can move.
pub fn build(
    model: &RobotModel,
    config: &PlannerConfig,
    progress: &(dyn Fn(f64) + Sync),
) -> Result<Vec<u64>, BuildError> {
    let primitive_sweep = PrimitiveSweep::new(model, config)?;
    let legs = [Leg::new(model, 0, 0.0)?, Leg::new(model, 1, 0.0)?];
    let steps = legs.iter().map(|leg| leg.joints().len()).sum::<usize>() as f64;
    let done = AtomicU32::new(0);
    let step =
        || progress(REACH_SHARE * f64::from(done.fetch_add(1, Ordering::Relaxed) + 1) / steps);
    let spaces: Vec<VoxelGrid> =
        legs.par_iter().map(|leg| reach_sweep::reachable(leg, &step)).collect();
    let primitives = gait_search::derive(&primitive_sweep, config, &|share| {
        progress(REACH_SHARE + (1.0 - REACH_SHARE) * share)
    });
    let mut writer = Writer::default();
    let reach = [0, 1].map(|limb| {
        let near = legs[limb].root_from_sole(&model.standing_q).translation;
        write_reach(&mut writer, &spaces[limb], near)
    });
    let ranges =
        [0, 1].map(|limb| write_range(&mut writer, &primitives.lattice, &primitives.cells[limb]));
    let step_limits = StepLimits::of(&constraints_in_empty_world(model, config.clone())?);
    let contents = Contents {
        reach,
        gait: primitives.gait,
        ranges,
        expanded: primitives.expanded,
        step_limits,
    };
    Ok(writer.finish(key(model, config), contents))
}

fn write_reach(writer: &mut Writer, cubes: &VoxelGrid, near: DVec3) -> ReachableSpaceHeader {
    let bits = writer.append(&cubes.words);
    let blocks = writer.append(&reachable_space::blocks(cubes, near));
    ReachableSpaceHeader {
        origin: cubes.origin.into(),
        side: cubes.side,
        dims: cubes.dims.into(),
        padding: 0,
        bits,
        blocks,
    }
}

fn write_range(writer: &mut Writer, lattice: &Lattice, cells: &[u64]) -> RangeHeader {
    RangeHeader { lattice: *lattice, bits: writer.append(cells) }
}
