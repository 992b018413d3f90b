//! The searched motion of a phase as a path: linear from one waypoint to the next, at rest at each.

use std::ops::Range;

use surefoot_shared_types::base::spatial::scaled_axis_from_rotation;

use crate::robot::configuration::{Configuration, midway};
use crate::smooth_path::layout::SearchedPlan;
use crate::timing::path_point::{PathPoint, VELOCITY_MAX};

/// Number of intervals between two waypoints.
pub(crate) const INTERVALS: usize = 4;

/// The expected time of the motion between two waypoints, s.
const SECONDS: f64 = 0.1;

/// The searched motion of a phase.
#[derive(Debug)]
pub(crate) struct SearchedPhase<'a> {
    pub plan: SearchedPlan<'a>,
    /// The edges of the phase.
    pub edges: Range<usize>,
}

impl SearchedPhase<'_> {
    /// Number of motions between two waypoints.
    pub fn len(&self) -> usize {
        let motion = |edge| self.plan.roadmap.motion(self.plan.edge(edge)).unwrap_or_default();
        self.edges.clone().map(|edge| motion(edge).len()).sum()
    }

    /// The waypoint up to which the swing foot lifts off, and the one from which it lands; the
    /// first and the last one where no lift-off is known.
    pub fn lift_offs(&self) -> [usize; 2] {
        let edge = self.plan.edge(self.edges.start);
        let motion = self.plan.roadmap.motion(edge).unwrap_or_default();
        let [off, on] =
            self.plan.roadmap.lifted(edge).map(|known| known.map_or(&[][..], |(_, path)| path));
        let lifted = motion.iter().zip(off).take_while(|(here, known)| here == known).count();
        let before_last = motion.iter().rev().skip(1);
        let landing = before_last.zip(on).take_while(|(here, known)| here == known).count();
        [lifted, self.len() - landing]
    }

    /// Waypoint `index` and the one after it, with their edge; `None` after the last.
    pub fn pair(&self, mut index: usize) -> Option<(usize, [Configuration; 2])> {
        for edge in self.edges.clone() {
            let path = self.plan.roadmap.motion(self.plan.edge(edge)).unwrap_or_default();
            if let Some(to) = path.get(index) {
                let begin = || self.plan.roadmap.state(self.plan.nodes[edge]).configuration;
                let from = index.checked_sub(1).map_or_else(begin, |before| path[before]);
                return Some((edge, [from, *to]));
            }
            index -= path.len();
        }
        None
    }
}

/// The points of the motion between two waypoints, from a value of the path's parameter (s) on.
pub(crate) fn points(
    from: &Configuration,
    to: &Configuration,
    parameter: f64,
) -> [PathPoint; INTERVALS + 1] {
    let mut first = [0.0; VELOCITY_MAX];
    let shift = to.world_from_root.translation - from.world_from_root.translation;
    let turn = scaled_axis_from_rotation(
        to.world_from_root.rotation * from.world_from_root.rotation.conjugate(),
    );
    first[..3].copy_from_slice(&shift.to_array());
    first[3..6].copy_from_slice(&turn.to_array());
    for (joint, slot) in first[6..].iter_mut().enumerate() {
        *slot = to.q[joint] - from.q[joint];
    }
    first.iter_mut().for_each(|slot| *slot /= SECONDS);
    std::array::from_fn(|index| {
        let fraction = index as f64 / INTERVALS as f64;
        let here = match index {
            0 => *from,
            INTERVALS => *to,
            _ => midway(from, to, fraction),
        };
        PathPoint {
            parameter: parameter + SECONDS * fraction,
            world_from_root: here.world_from_root,
            q: here.q,
            first,
            second: [0.0; VELOCITY_MAX],
        }
    })
}
