//! Derives a robot's gait, the range R_S of its primitives and the expanded geometry around them.

use rayon::prelude::*;
use surefoot_shared_types::config::PlannerConfig;

use super::expanded::{Expanded, Fitting};
use super::probe::Probe;
use super::range::Lattice;
use crate::motion::primitive::gait::Gait;

/// Multiples of the standing posture's reach that are tried for the primitives.
const REACH_FACTORS: [f64; 3] = [1.0, 0.96, 0.92];
/// Multiples of the standing posture's width that are tried.
const WIDTH_FACTORS: [f64; 2] = [1.0, 1.3];
/// What the boxes are larger than what was swept, beyond the clearance: covers the pairs between those tried, m.
const BOX_SLACK: f64 = 0.01;
/// Vertices that one task tries.
const TASK_VERTICES: usize = 64;

/// What was derived.
#[derive(Debug)]
pub struct Primitives {
    /// The shape of the primitives.
    pub gait: Gait,
    /// The lattice of pairs.
    pub lattice: Lattice,
    /// By stance limb: a bit for each cell of the lattice that holds.
    pub cells: [Vec<u64>; 2],
    /// The room that the primitives take.
    pub expanded: Expanded,
}

/// Derives the primitives of a robot; `progress` is told the share that is done.
pub fn derive(probe: &Probe, config: &PlannerConfig, progress: &(dyn Fn(f64) + Sync)) -> Primitives {
    let reach = probe.body().legs.iter().map(|leg| leg.reach()).fold(f64::INFINITY, f64::min);
    let lattice = Lattice::new(reach);
    let gait = best_gait(probe, config, &lattice);
    progress(0.2);
    let [left, right] = [0, 1].map(|stance| {
        let swept = sweep(probe, &gait, stance, &lattice);
        progress(0.6 + 0.4 * stance as f64);
        swept
    });
    let fitting = left.1.union(&right.1);
    let margin = config.clearance + BOX_SLACK;
    let expanded = fitting.finish(probe.sole_boxes(&gait, margin), margin);
    Primitives { gait, lattice, cells: [lattice.cell_bits(&left.0), lattice.cell_bits(&right.0)], expanded }
}

/// The gait that holds over most of the coarse lattice; the first of equals.
fn best_gait(probe: &Probe, config: &PlannerConfig, lattice: &Lattice) -> Gait {
    let radius = probe.foot_radius();
    let coarse: Vec<usize> = (0..lattice.vertices()).filter(|&index| lattice.is_coarse(index)).collect();
    let candidates = REACH_FACTORS.iter().flat_map(|&reach| WIDTH_FACTORS.map(|width| (reach, width)));
    let gaits: Vec<Gait> = candidates.map(|(reach, width)| Gait::new(probe.body(), reach, width, radius, config.clearance)).collect();
    let counts: Vec<usize> = gaits
        .par_iter()
        .map(|gait| coarse.iter().filter(|&&index| probe.try_pair(gait, 0, &lattice.vertex(index), None).is_some()).count())
        .collect();
    let best = (0..gaits.len()).max_by_key(|&index| (counts[index], std::cmp::Reverse(index))).unwrap_or(0);
    gaits[best]
}

/// Tries every vertex, in turn level and inclined.
fn sweep(probe: &Probe, gait: &Gait, stance: usize, lattice: &Lattice) -> (Vec<bool>, Fitting) {
    let tried: Vec<Option<Fitting>> = (0..lattice.vertices())
        .into_par_iter()
        .with_min_len(TASK_VERTICES)
        .map(|index| {
            let inclined = lattice.is_odd(index).then_some(index as u64);
            probe.try_pair(gait, stance, &lattice.vertex(index), inclined)
        })
        .collect();
    let fitting = tried.iter().flatten().fold(Fitting::EMPTY, |all, one| all.union(one));
    (tried.iter().map(Option::is_some).collect(), fitting)
}
