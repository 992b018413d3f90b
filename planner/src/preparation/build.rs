//! Builds the preparation of a robot, from the robot and its margins alone [Grey 4.1.1, 4.2.1,
//! 4.4.5].

use std::sync::atomic::{AtomicU32, Ordering};

use glam::DVec3;
use rayon::prelude::*;
use surefoot_shared_types::config::PlannerConfig;
use surefoot_shared_types::robot::model::RobotModel;

use crate::geometry::voxel_grid::VoxelGrid;
use crate::kinematics::Leg;
use crate::preparation::data::Preparation;
use crate::preparation::error::BuildError;
use crate::preparation::file_format::{self, Contents, Writer};
use crate::preparation::primitive_range::{Lattice, RangeHeader};
use crate::preparation::primitive_sweep::{PrimitiveSweep, constraints_in_empty_world};
use crate::preparation::reachable_space::ReachableSpaceHeader;
use crate::preparation::step_limits::StepLimits;
use crate::preparation::{gait_search, reach_sweep, reachable_space};

/// Prepares a robot in memory, without a cache.
///
/// # Errors
/// The planner cannot move the robot.
pub fn prepare(model: &RobotModel, config: &PlannerConfig) -> Result<Preparation, BuildError> {
    let words = build(model, config, &|_| ())?;
    Ok(Preparation::from_words(words, &file_format::key(model, config))?)
}

/// The share of the reachable spaces in the progress.
const REACH_SHARE: f64 = 0.5;

/// The words of a robot's preparation. `progress` receives the completed fraction, 0 to 1, from any
/// thread. The same robot and margins give the same words on any number of threads.
///
/// # Errors
/// The planner cannot move the robot.
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
    Ok(writer.finish(file_format::key(model, config), contents))
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
