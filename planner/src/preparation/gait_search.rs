//! Derives a robot's gait, the range R_S of its primitives and the expanded geometry around them.

use rayon::prelude::*;
use surefoot_shared_types::config::PlannerConfig;

use crate::preparation::expanded_geometry::{ExpandedBuilder, ExpandedGeometry};
use crate::preparation::primitive_range::Lattice;
use crate::preparation::primitive_sweep::PrimitiveSweep;
use crate::preparation::tuning::{
    BOX_SLACK, GAIT_LEANS, GAIT_REACHES, GAIT_ROLLS, GAIT_SHORTLIST, GAIT_TILTS, GAIT_WIDTHS,
    KEPT_PAIRS_SHARE, TASK_VERTICES,
};
use crate::primitives::Gait;
use crate::primitives::gait::Style;

/// The primitives of a robot.
#[derive(Debug)]
pub(crate) struct Primitives {
    /// Their parameters.
    pub gait: Gait,
    /// The lattice of pairs.
    pub lattice: Lattice,
    /// By stance limb: a bit for each cell of the lattice, set where the primitives hold.
    pub cells: [Vec<u64>; 2],
    /// The volume that they occupy.
    pub expanded: ExpandedGeometry,
}

/// Derives the primitives of a robot. `progress` receives the completed fraction, 0 to 1.
pub(crate) fn derive(
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

/// The gait that holds over most of the coarse lattice, the first of equals, with the steepest tilt
/// that keeps [`KEPT_PAIRS_SHARE`] of those pairs.
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
    let [level, coarse] = [Lattice::is_level, Lattice::is_coarse].map(|is_selected| {
        (0..lattice.vertices()).filter(|&index| is_selected(lattice, index)).collect::<Vec<usize>>()
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
    ranked.truncate(GAIT_SHORTLIST);
    let counts: Vec<usize> = ranked.par_iter().map(|(_, style)| count(style, &coarse)).collect();
    let best = (0..ranked.len())
        .max_by_key(|&index| (counts[index], std::cmp::Reverse(index)))
        .unwrap_or(0);
    let style = ranked[best].1;
    let steeper = GAIT_TILTS.into_par_iter().map(|tilt| Style { tilt, ..style });
    let held: Vec<(Style, usize)> = steeper.map(|style| (style, count(&style, &coarse))).collect();
    let enough = KEPT_PAIRS_SHARE * counts[best] as f64;
    let steepest = held.iter().find(|(_, count)| *count as f64 >= enough);
    gait(&steepest.map_or(style, |(style, _)| *style))
}

/// All styles with the smallest tilt, the upright ones first.
fn styles() -> Vec<Style> {
    let tilt = GAIT_TILTS[GAIT_TILTS.len() - 1];
    let postures = GAIT_ROLLS.into_iter().flat_map(|roll| GAIT_LEANS.map(|lean| (roll, lean)));
    let styles = |(roll, lean)| {
        GAIT_REACHES.into_iter().flat_map(move |reach| {
            GAIT_WIDTHS.map(|width| Style { tilt, reach, width, roll, lean })
        })
    };
    postures.flat_map(styles).collect()
}

/// Tries every vertex, alternately level and inclined. Returns whether each holds, and their
/// volume.
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
