//! The places of a phase at which its configurations are made.

use crate::smooth_path::curve::Curve;
use crate::smooth_path::key_table::KeySource;
use crate::smooth_path::layout::swing_of;
use crate::smooth_path::tuning::{
    INTERVALS_MAX, INTERVALS_MIN, KEY_SECONDS, POINT_STEP, REFINEMENTS_MAX, SWING_POINT_STEP,
};

/// Most intervals of a phase that is not refined.
const INTERVALS_COARSE_MAX: usize = INTERVALS_MAX >> REFINEMENTS_MAX;

/// Number of configurations beyond each end of a phase.
pub(crate) const BEYOND: usize = 2;

/// A phase of the curve, divided into intervals.
#[derive(Debug, Clone, Copy, Default)]
pub(crate) struct PhaseGrid {
    /// The phase.
    pub phase: usize,
    /// The place of the curve at which it begins.
    pub begin: f64,
    /// The length of an interval, in keys.
    pub step: f64,
    /// Number of intervals.
    pub intervals: usize,
}

impl PhaseGrid {
    /// The grid of a phase, whose intervals are halved as often as `refinements`; `None` where it
    /// has no length.
    pub fn new(
        source: &KeySource<'_>,
        curve: &Curve,
        phase: usize,
        refinements: u8,
    ) -> Option<Self> {
        let [first, last] = source.layout.end_keys(phase);
        let (begin, end, way) = if let Some(swing) = swing_of(phase) {
            let [begin, end] = curve.swings[swing];
            (begin, end, curve.swing(&source.plan, source.layout, swing).length())
        } else {
            let after = phase / 2;
            let begin = if curve.rests[first] { first as f64 } else { curve.swings[after - 1][1] };
            let end = if curve.rests[last] { last as f64 } else { curve.swings[after][0] };
            (begin, end, 0.0)
        };
        if end <= begin {
            return None;
        }
        let wanted = ((end - begin) / POINT_STEP).max(way / SWING_POINT_STEP);
        let intervals = (libm::ceil(wanted) as usize).clamp(INTERVALS_MIN, INTERVALS_COARSE_MAX);
        let intervals = intervals << refinements;
        Some(Self { phase, begin, step: (end - begin) / intervals as f64, intervals })
    }

    /// The grid of a followed motion whose spline ends at place `end`, of this many intervals.
    pub fn followed(phase: usize, end: usize, intervals: usize) -> Self {
        Self { phase, begin: 0.0, step: end as f64 / intervals as f64, intervals }
    }

    /// A place in the middle of the phase.
    pub fn middle(&self) -> f64 {
        self.begin + 0.5 * self.step * self.intervals as f64
    }

    /// The place of a configuration; the first of the phase has index [`BEYOND`].
    pub fn place(&self, index: usize) -> f64 {
        self.begin + self.step * (index as f64 - BEYOND as f64)
    }

    /// Number of configurations, those beyond both ends included.
    pub fn len(&self) -> usize {
        self.intervals + 1 + 2 * BEYOND
    }

    /// The interval between two points in units of the path's parameter, s.
    pub fn seconds(&self) -> f64 {
        KEY_SECONDS * self.step
    }
}
