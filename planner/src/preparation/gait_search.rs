//! Derives a robot's gait, the range R_S of its primitives and the expanded geometry around them.

use rayon::prelude::*;
use surefoot_shared_types::config::PlannerConfig;

use crate::preparation::expanded_geometry::{ExpandedBuilder, ExpandedGeometry};
use crate::preparation::primitive_range::Lattice;
use crate::preparation::primitive_sweep::PrimitiveSweep;
use crate::primitives::Gait;
use crate::primitives::gait::Style;

/// Multiples of the standing posture's reach that are tried for the primitives.
const REACHES: [f64; 3] = [1.0, 1.05, 0.95];
/// Multiples of the standing posture's width that are tried.
const WIDTHS: [f64; 4] = [1.0, 1.3, 0.8, 0.65];
/// Rolls of the root over the stance foot that are tried, rad.
const ROLLS: [f64; 4] = [0.0, 0.06, 0.12, 0.18];
/// Shifts of the centre of mass inward of a sole's middle that are tried, as fractions of the space
/// there.
const LEANS: [f64; 2] = [0.0, 0.6];
/// The steepest placements that are tried, rad.
const TILTS: [f64; 3] = [0.1, 0.06, 0.02];
/// A steeper one is taken if it leaves this share of the pairs.
const TILT_WORTH: f64 = 0.8;
/// Gaits that are tried on the whole coarse lattice: those that hold over most of its level pairs.
const SHORTLIST: usize = 4;
/// What the boxes are larger than what was swept, beyond the clearance: covers the pairs between
/// those tried, m.
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
    /// The volume that the primitives occupy.
    pub expanded: ExpandedGeometry,
}

/// Derives the primitives of a robot; `progress` receives the fraction that is done.
pub fn derive(
    primitive_sweep: &PrimitiveSweep,
    config: &PlannerConfig,
    progress: &(dyn Fn(f64) + Sync),
) -> Primitives {
    let reach =
        primitive_sweep.robot().legs.iter().map(|leg| leg.reach()).fold(f64::INFINITY, f64::min);
    let lattice = Lattice::new(reach);
    let gait = best_gait(primitive_sweep, config, &lattice);
    progress(0.2);
    let [left, right] = [0, 1].map(|stance| {
        let swept = sweep(primitive_sweep, &gait, stance, &lattice);
        progress(0.6 + 0.4 * stance as f64);
        swept
    });
    let fitting = left.1.union(&right.1);
    let margin = config.clearance + BOX_SLACK;
    let expanded = fitting.finish(primitive_sweep.sole_boxes(&gait, margin), margin);
    Primitives {
        gait,
        lattice,
        cells: [lattice.cell_bits(&left.0), lattice.cell_bits(&right.0)],
        expanded,
    }
}

/// The gait that holds over most of the coarse lattice, the first of equals, for placements as
/// steep as that leaves it.
fn best_gait(primitive_sweep: &PrimitiveSweep, config: &PlannerConfig, lattice: &Lattice) -> Gait {
    let radius = primitive_sweep.foot_radius();
    let gait = |style: &Style| {
        Gait::new(
            primitive_sweep.robot(),
            style,
            radius,
            config.clearance,
            primitive_sweep.balance_margin(),
        )
    };
    let [level, coarse] = [Lattice::is_level, Lattice::is_coarse].map(|is_wanted| {
        (0..lattice.vertices()).filter(|&index| is_wanted(lattice, index)).collect::<Vec<usize>>()
    });
    let holds = |style: &Style, index: usize| {
        [0, 1].iter().all(|&stance| {
            primitive_sweep
                .try_pair(&gait(style), stance, &lattice.vertex(index), Some(index as u64))
                .is_some()
        })
    };
    let count =
        |style: &Style, tried: &[usize]| tried.iter().filter(|&&index| holds(style, index)).count();
    let mut ranked: Vec<(usize, Style)> =
        styles().into_par_iter().map(|style| (count(&style, &level), style)).collect();
    ranked.sort_by_key(|&(count, _)| std::cmp::Reverse(count));
    ranked.truncate(SHORTLIST);
    let counts: Vec<usize> = ranked.par_iter().map(|(_, style)| count(style, &coarse)).collect();
    let best = (0..ranked.len())
        .max_by_key(|&index| (counts[index], std::cmp::Reverse(index)))
        .unwrap_or(0);
    let style = ranked[best].1;
    let steeper = TILTS.into_par_iter().map(|tilt| Style { tilt, ..style });
    let held: Vec<(Style, usize)> = steeper.map(|style| (style, count(&style, &coarse))).collect();
    let enough = TILT_WORTH * counts[best] as f64;
    let steepest = held.iter().find(|(_, count)| *count as f64 >= enough);
    gait(&steepest.map_or(style, |(style, _)| *style))
}

/// Styles for all but level placements, the plain ones first.
fn styles() -> Vec<Style> {
    let tilt = TILTS[TILTS.len() - 1];
    let postures = ROLLS.into_iter().flat_map(|roll| LEANS.map(|lean| (roll, lean)));
    let styles = |(roll, lean)| {
        REACHES
            .into_iter()
            .flat_map(move |reach| WIDTHS.map(|width| Style { tilt, reach, width, roll, lean }))
    };
    postures.flat_map(styles).collect()
}

/// Tries every vertex, in turn level and inclined.
fn sweep(
    primitive_sweep: &PrimitiveSweep,
    gait: &Gait,
    stance: usize,
    lattice: &Lattice,
) -> (Vec<bool>, ExpandedBuilder) {
    let tried: Vec<Option<ExpandedBuilder>> = (0..lattice.vertices())
        .into_par_iter()
        .with_min_len(TASK_VERTICES)
        .map(|index| {
            let inclined = lattice.is_odd(index).then_some(index as u64);
            primitive_sweep.try_pair(gait, stance, &lattice.vertex(index), inclined)
        })
        .collect();
    let fitting =
        tried.iter().flatten().fold(primitive_sweep.empty_boxes(), |all, one| all.union(one));
    (tried.iter().map(Option::is_some).collect(), fitting)
}
