//! The phases of a plan: double support and swings in turn. Both ends of the plan are double
//! support, of no length where the robot starts on one foot.

use std::ops::Range;

use surefoot_shared_types::message::SupportMode;

use crate::base::arena::reserve;
use crate::motion::ids::TransitionId;
use crate::motion::roadmap::{ModeEdge, Roadmap};
use crate::smooth_path::tuning::STANCE_KEYS;

/// The plan that is smoothed: Gamma_M and the nodes of the plan.
#[derive(Debug, Clone, Copy)]
pub struct SearchedPlan<'a> {
    /// Gamma_M.
    pub roadmap: &'a Roadmap,
    /// The transitions of the plan, with the nodes of its boundaries.
    pub nodes: &'a [TransitionId],
}

impl SearchedPlan<'_> {
    /// Edge `index` of the plan, from node `index` to the next.
    pub(crate) fn edge(&self, index: usize) -> ModeEdge {
        ModeEdge { from: self.nodes[index], to: self.nodes[index + 1] }
    }
}

/// The phases of a plan, numbered: swing `v` is phase `2 v + 1`, the double supports around it are
/// its neighbours.
#[derive(Debug)]
pub(crate) struct Layout {
    /// The edge of each swing.
    swings: Vec<u32>,
    /// Number of edges of the plan.
    edges_len: usize,
}

impl Layout {
    /// Reserves memory for plans of `edges_max` edges.
    pub fn new(edges_max: usize) -> Self {
        Self { swings: reserve(edges_max), edges_len: 0 }
    }

    /// Reads the phases of a plan.
    pub fn read(&mut self, plan: &SearchedPlan<'_>) {
        self.edges_len = plan.nodes.len().saturating_sub(1);
        self.swings.clear();
        let is_swing = |index: &usize| !plan.roadmap.is_double(plan.edge(*index));
        self.swings.extend((0..self.edges_len).filter(is_swing).map(|index| index as u32));
    }

    /// Number of swings.
    pub fn swings_len(&self) -> usize {
        self.swings.len()
    }

    /// Number of phases.
    pub fn phases_len(&self) -> usize {
        2 * self.swings.len() + 1
    }

    /// Number of keys.
    pub fn keys_len(&self) -> usize {
        STANCE_KEYS * self.swings.len() + 2
    }

    /// The edge of a swing.
    pub fn swing_edge(&self, swing: usize) -> usize {
        self.swings[swing] as usize
    }

    /// The edges of a phase; none where two swings follow each other.
    pub fn edges(&self, phase: usize) -> Range<usize> {
        if let Some(swing) = swing_of(phase) {
            let edge = self.swing_edge(swing);
            return edge..edge + 1;
        }
        let after = phase / 2;
        let first = if after == 0 { 0 } else { self.swing_edge(after - 1) + 1 };
        let last = self.swings.get(after).map_or(self.edges_len, |edge| *edge as usize);
        first..last
    }

    /// The keys at which a phase begins and ends if the robot rests there.
    pub fn end_keys(&self, phase: usize) -> [usize; 2] {
        let first = STANCE_KEYS * (phase / 2) + phase % 2;
        [first, if phase % 2 == 1 { first + STANCE_KEYS - 1 } else { first + 1 }]
    }

    /// Bytes reserved.
    pub fn bytes(&self) -> usize {
        self.swings.capacity() * size_of::<u32>()
    }
}

/// The swing of a phase; `None` in double support.
pub(crate) fn swing_of(phase: usize) -> Option<usize> {
    (phase % 2 == 1).then_some(phase / 2)
}

/// The stance foot of a support mode; the left one in double support.
pub(crate) fn stance_limb(support: SupportMode) -> usize {
    usize::from(support == SupportMode::Right)
}
